"""The functions of `import casa_assets`: runs of single items, in the caller's process."""
