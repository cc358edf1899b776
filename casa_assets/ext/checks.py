"""Checks, and what they measure."""

from __future__ import annotations

from casa_assets.checks.check import (
    Check,
    Measurement,
    all_at_least,
    all_at_most,
    at_least,
    at_most,
    count,
    no_fault,
    not_applicable,
)

__all__ = [
    "all_at_least",
    "all_at_most",
    "at_least",
    "at_most",
    "Check",
    "count",
    "Measurement",
    "no_fault",
    "not_applicable",
]
