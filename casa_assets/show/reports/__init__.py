"""Reports made from a library's entries and from kitchens, as HTML and JSON; and the documentation of checks."""
