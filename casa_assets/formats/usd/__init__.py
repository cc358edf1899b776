"""Assets and kitchens -> USD; the same names as in the MJCF writer."""
