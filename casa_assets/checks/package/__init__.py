"""Checks of the written files: MJCF and USD load, keep the conventions, and agree with each other."""
