"""How many faults the tests catch: each is planted in a copy of a checkout, and the tests that reach it are run."""
