"""Load what was learned from labelled cases, for the search of moving parts."""

from __future__ import annotations

from functools import cache

from casa_assets import registry
from casa_assets.articulate.controls.classify import check_forest
from casa_assets.articulate.models import Models


@cache
def load_models() -> Models:
    """Return the forests of registry/learned/. Raises RegistryError, or ValueError where one fits other features."""
    return Models(controls=check_forest(registry.learned_forest("controls")))
