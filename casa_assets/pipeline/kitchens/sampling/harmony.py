"""Tell whether finishes of walls, floor, worktops and cabinets go together, by what their recipes say of them.

No picture is painted for that: a recipe names its colours. Of pictures of packs nothing is known; they go with all.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from typing import Any

import numpy as np

from casa_assets.core.color import srgb_from_hex
from casa_assets.model.kitchen.mixing import Harmony
from casa_assets.model.registry.texture_recipe import TextureRecipe
from casa_assets.pipeline.textures.recipes import find_recipe
from casa_assets.registry.mixing import load_mixing
from casa_assets.textures.distance import oklab

COLOR = re.compile(r"#[0-9a-fA-F]{6}")
# Parts of recipes whose colours cover little of the picture.
SMALL_PARTS = frozenset(
    {"joint", "grout", "pore", "heart", "undercoat", "bare_color", "veins", "specks", "body", "stain"}
)


@dataclass(frozen=True)
class Tone:
    """Mean of the main colours of a recipe in Oklab: lightness, chroma, and hue in degrees."""

    lightness: float
    chroma: float
    hue_deg: float


def goes_together(names: Iterable[str]) -> bool:
    """True if finishes of the four surfaces go together. Raises UnknownId."""
    rules = load_mixing().finishes
    recipes = [find_recipe(name) for name in names]
    tones = [tone for recipe in recipes if (tone := tone_of(recipe)) is not None]
    strong = [tone for tone in tones if _is_strong(tone, rules)]
    return (
        sum(recipe.kind in rules.patterned for recipe in recipes) <= rules.most_patterned
        and sum(recipe.kind in rules.wooden for recipe in recipes) <= rules.most_wooden
        and sum(tone.lightness < rules.dark_below for tone in tones) <= rules.most_dark
        and all(_hues_apart(first, second) <= rules.most_hue_deg for first, second in combinations(strong, 2))
    )


def is_wooden(name: str) -> bool:
    """True if a finish with a picture shows wood. Raises UnknownId."""
    return find_recipe(name).kind in load_mixing().finishes.wooden


@lru_cache(maxsize=1024)
def tone_of(recipe: TextureRecipe) -> Tone | None:
    """Mean of the main colours that a recipe names; None where it names none."""
    colors = [srgb_from_hex(color) for color in _colors(json.loads(recipe.params))]
    if not colors:
        return None
    lightness, a, b = oklab(np.array(colors)).mean(axis=0)
    return Tone(float(lightness), float(np.hypot(a, b)), float(np.degrees(np.arctan2(b, a))))


def _colors(value: Any, name: str = "") -> Iterator[str]:
    """Colours as `#rrggbb` in the parameters of a recipe, without those of small parts."""
    if name in SMALL_PARTS:
        return
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _colors(inner, key)
    elif isinstance(value, list):
        for inner in value:
            yield from _colors(inner, name)
    elif isinstance(value, str) and COLOR.fullmatch(value):
        yield value


def _is_strong(tone: Tone, rules: Harmony) -> bool:
    low, high = rules.earth_hues_deg
    return tone.chroma >= rules.strong_from and not low <= tone.hue_deg <= high


def _hues_apart(first: Tone, second: Tone) -> float:
    """Degrees between two hues, 0 to 180."""
    apart = abs(first.hue_deg - second.hue_deg) % 360.0
    return min(apart, 360.0 - apart)
