"""Parts of what stands and hangs about: jars, leaves, kitchen tools."""
