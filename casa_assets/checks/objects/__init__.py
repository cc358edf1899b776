"""Checks of parametric objects that are placed around a kitchen: each member, and all members together."""
