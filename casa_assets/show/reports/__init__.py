"""Reports made from a library's entries: index, attribution, HTML pages; and the documentation of checks."""
