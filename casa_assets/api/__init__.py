"""The functions of `import casa_assets`: the pipeline for one thing at a time, in the caller's process."""
