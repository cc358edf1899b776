"""Load what was learned from labelled cases, for the search of moving parts."""

from __future__ import annotations

from functools import cache

from casa_assets import registry
from casa_assets.articulate.controls.classify import check_forest
from casa_assets.articulate.fronts.front_hypotheses import check_front_forest
from casa_assets.articulate.models import Models


@cache
def load_models() -> Models:
    """Return the forests of registry/learned/. Raises RegistryError, or ValueError where one fits other features."""
    return Models(
        controls=check_forest(registry.learned_forest("controls")),
        fronts_alone=check_front_forest(registry.learned_forest("fronts_alone"), with_context=False),
        fronts=check_front_forest(registry.learned_forest("fronts"), with_context=True),
    )
