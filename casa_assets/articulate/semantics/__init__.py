"""Names, regions, states and rules that runtimes look for, put on the parts that were found."""
