"""casa-assets export: one module per form, put together in `app`."""
