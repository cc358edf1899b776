"""What is derived from the entries of a library: index, attribution, report, pictures, the page of checks."""
