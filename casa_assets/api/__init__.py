"""What `import casa_assets` offers: the functions of the pipeline for one thing at a time, in the caller's process."""
