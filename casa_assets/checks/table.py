"""All checks, one literal table; docs/checks.md is printed from it."""

from __future__ import annotations

from casa_assets.checks.check import Check

TABLE: tuple[Check, ...] = ()
