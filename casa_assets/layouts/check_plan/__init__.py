"""Check plans without building anything, mend what is wrong with them, and fit them to rooms."""
