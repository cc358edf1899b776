"""The 3D viewer of pages: its bundle of JavaScript, and the files through which a page shows a model."""
