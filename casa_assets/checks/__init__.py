"""Judges: small pure functions over finished things, one literal table, limits from registry/limits.yaml."""
