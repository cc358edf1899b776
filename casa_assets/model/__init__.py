"""Frozen records that every stage reads and writes; no disk, no clock."""
