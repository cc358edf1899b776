"""Commands of casa-assets, one file each."""
