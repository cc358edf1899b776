"""All checks: one literal row each, by subject; docs/reference/checks.md is printed from them."""

from __future__ import annotations

from collections.abc import Mapping

from casa_assets.checks.check import Check
from casa_assets.checks.table import assets, batch_forms, filters, formats, kitchens, libraries, motion, objects, scenes

TABLE: tuple[Check, ...] = (
    *assets.ROWS,
    *motion.ROWS,
    *formats.ROWS,
    *filters.ROWS,
    *objects.ROWS,
    *libraries.ROWS,
    *scenes.ROWS,
    *kitchens.ROWS,
    *batch_forms.ROWS,
)


def explained(limits: Mapping[str, float]) -> dict[str, str]:
    """Code -> title and description of every check, such as `Overall size: The longest side ...`."""
    return {row.code: f"{row.title}: {row.describe(limits)}" for row in TABLE}
