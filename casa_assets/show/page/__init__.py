"""Parts of pages: templates, the report of a kitchen, the 3D viewer, and the files with which a page shows a model."""
