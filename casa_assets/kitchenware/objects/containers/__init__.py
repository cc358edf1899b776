"""Bottles, cans and jars with what closes them."""
