"""Asset -> USD package: one module per concept, the same names as in the MJCF writer."""
