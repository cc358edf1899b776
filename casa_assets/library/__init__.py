"""The library on disk: folders, asset.json, resume, review."""
