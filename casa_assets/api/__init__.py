"""The functions of `import casa_assets`: the pipeline for single items, in the caller's process."""
