"""What every check tests, for pages, without loading the checks."""

from __future__ import annotations

from casa_assets import registry
from casa_assets.pipeline.cache.remembered import recall, remember


def explanations() -> dict[str, str]:
    """Code -> title and description of every check, such as `Overall size: The longest side ...`."""
    known = recall("explanations")
    if isinstance(known, dict):
        return known
    from casa_assets.checks.table.table import explained  # here, since it loads all checks

    found = explained(registry.load().limits)
    remember(found, "explanations")
    return found
