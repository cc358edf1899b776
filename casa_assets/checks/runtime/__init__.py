"""Checks of what a runtime reads: names, sites, regions, thresholds, state machines."""
