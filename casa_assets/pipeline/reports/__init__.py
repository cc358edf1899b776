"""What is derived from a library's entries: index, attribution, HTML pages, documentation of checks."""
