"""Checks of things out of numbers that stand about in a kitchen: each member, and all of them together."""
