"""The code of every family, by name. Their presets are data: `casa_assets.registry.families` joins the two."""

from __future__ import annotations

from typing import Any

from casa_assets.families.fixtures import cabinets, cold, cooking, counters, decor, room, small
from casa_assets.families.kit.assemble import ParametricModel

GROUPS: dict[str, tuple[ParametricModel[Any], ...]] = {
    "cabinets": cabinets.MODELS,
    "counters": counters.MODELS,
    "cooking": cooking.MODELS,
    "cold": cold.MODELS,
    "small": small.MODELS,
    "decor": decor.MODELS,
    "room": room.MODELS,
}
MODELS: dict[str, ParametricModel[Any]] = {model.name: model for models in GROUPS.values() for model in models}
