"""Mix styles by a seed, with finishes that go together by the colours that their recipes name.

Every part is in some style as it is, and so was looked at and checked there. Pictures of packs go with all.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from typing import Any

import numpy as np

from casa_assets.core.numeric import rng_for, srgb_from_hex
from casa_assets.model.kitchen.style import PresetChoice, Style
from casa_assets.model.registry.rows import TextureRecipe
from casa_assets.projects import read_once
from casa_assets.registry.kitchens import load_mixing, load_style, style_names
from casa_assets.textures.distance import oklab
from casa_assets.textures.run.recipes import find_recipe

COLOR = re.compile(r"#[0-9a-fA-F]{6}")
# Parts of recipes whose colours cover little of the picture.
SMALL_PARTS = {"joint", "grout", "pore", "heart", "undercoat", "bare_color", "veins", "specks", "body", "stain"}
GROUPS = ("base", "upper", "tall", "island")  # of cabinets


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
    low, high = rules.earth_hues_deg
    strong = [t for t in tones if t.chroma >= rules.strong_from and not low <= t.hue_deg <= high]
    apart = [abs(first.hue_deg - second.hue_deg) % 360.0 for first, second in combinations(strong, 2)]
    return (
        sum(recipe.kind in rules.patterned for recipe in recipes) <= rules.most_patterned
        and sum(recipe.kind in rules.wooden for recipe in recipes) <= rules.most_wooden
        and sum(tone.lightness < rules.dark_below for tone in tones) <= rules.most_dark
        and all(min(degrees, 360.0 - degrees) <= rules.most_hue_deg for degrees in apart)
    )


def is_wooden(name: str) -> bool:
    """True if a finish with a picture shows wood. Raises UnknownId."""
    return find_recipe(name).kind in load_mixing().finishes.wooden


@lru_cache(maxsize=1024)
def tone_of(recipe: TextureRecipe) -> Tone | None:
    """Return the mean of the main colours that a recipe names, or None if it names no colour."""
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


def mixed_style(style: Style, seed: int, turn: int = 0) -> Style:
    """Return a style with fronts, worktop edges, woodwork, models and props of other styles; its finishes stay.

    Every part has a separate random stream. Another `turn` gives another draw, if the first does not fit into a plan.
    """
    parts = {part: _drawn(style, _styles(), seed, turn, part) for part in ("fronts", "worktops", "woodwork", "props")}
    fronts, tops, room, props = parts.values()
    faces = {name: getattr(style.cabinets, name).face for name in GROUPS}
    groups = {name: getattr(fronts.cabinets, name).replace(face=face) for name, face in faces.items()}
    return style.replace(
        cabinets=fronts.cabinets.replace(**groups),
        counter=tops.counter.replace(face=style.counter.face),
        island=tops.island.replace(face=style.island.face),
        backsplash=tops.backsplash,
        room=room.room.replace(wall=style.room.wall, floor=style.room.floor, turn_deg=style.room.turn_deg),
        models=_models(style, seed, turn, parts),
        props=props.props,
    )


def models_of_roles() -> dict[str, tuple[str, ...]]:
    """Every model that a mixed kitchen may have, by role: `family/preset`, sorted, each once."""
    roles = sorted({role for style in _styles() for role in style.models})
    return {role: tuple(sorted({s.models[role].preset for s in _styles() if role in s.models})) for role in roles}


def kinds_of_fronts() -> tuple[tuple[str | None, str | None], ...]:
    """Kinds of fronts and handles of base units that a mixed kitchen may have, sorted, each once."""
    bases = (style.cabinets.base for style in _styles())
    return tuple(sorted({(base.front, base.handle) for base in bases}, key=str))


def _models(style: Style, seed: int, turn: int, parts: Mapping[str, Style]) -> Mapping[str, PresetChoice]:
    """The models of a mixed style: the roles of the style itself, suite by suite and else one by one.

    `parts`: name of a part -> style that it comes from; a suite of that name comes from it too.
    """
    suites = dict(load_mixing().suites)
    in_suites = {role for roles in suites.values() for role in roles}
    suites |= {role: (role,) for role in style.models if role not in in_suites}
    source: dict[str, Style] = {}
    for name, roles in suites.items():
        wanted = [role for role in roles if role in style.models]
        whole = [other for other in _styles() if all(role in other.models for role in wanted)]
        drawn = parts.get(name)
        if drawn not in whole:
            drawn = _drawn(style, whole, seed, turn, f"models/{name}")
        source |= dict.fromkeys(wanted, drawn)
    return {role: source[role].models[role] for role in style.models}


def _drawn(style: Style, others: Sequence[Style], seed: int, turn: int, part: str) -> Style:
    rng = rng_for(seed, f"scene/mix/{part}/{turn}")
    if float(rng.random()) < load_mixing().own_share or not others:
        return style
    return others[int(rng.integers(len(others)))]


@read_once
def _styles() -> tuple[Style, ...]:
    return tuple(load_style(name)[0] for name in style_names())
