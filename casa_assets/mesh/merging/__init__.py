"""Merge boxes and other primitives into fewer ones, without closing a space that something could get into."""
