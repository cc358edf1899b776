"""The starter of a project, which `casa-assets init` copies."""
