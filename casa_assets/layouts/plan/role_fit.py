"""Fit an asset of a library to a role: whether its category suits, and by which factor it is scaled to its place."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Any

from casa_assets.errors import CasaError
from casa_assets.model.asset.asset import Base
from casa_assets.model.kitchen.style import LIBRARY, PresetChoice
from casa_assets.model.registry.rows import RoleRule

SIDES = ("width", "depth", "height")
SCALE_DIGITS = 4
# Of the assets of the libraries whose category suits a role, so many are read and so many named where one does not fit.
MAX_READ, MAX_NAMED = 20, 4
# A place of a stated width that would stay emptier than this beside its appliance is refused, metres.
MAX_GAP_M = 0.03
SIZES = ("width", "depth", "height", "level", "size", "sweep", "drop")  # lengths of an asset, all scaled alike
NONE_IN_LIBRARIES = ", of which the libraries have none"


@dataclass(frozen=True)
class Place:
    """Place of a model in a kitchen.

    Attributes:
        most: maximum size of a model by dimension, metres.
        fills: whether the plan states the width of the unit, which the model then has to fill.
        name: of the unit.
        reach: how far doors may swing out to the side of the model, metres; None: as far as they do.
    """

    most: Mapping[str, float]
    fills: bool = False
    name: str = ""
    reach: float | None = None


class ModelMisfit(CasaError):
    """An asset that cannot be placed where it is named: what could be placed there, what to do, and what was given."""

    def __init__(self, expected: str, got: str) -> None:
        self.expected, self.got = expected, got
        super().__init__(f"expected {expected}, got {got}")


def category_of(asset_id: str) -> str:
    """Category of an asset by its id, such as `mug` of `mug_0a1b2c3d4e` or of `mug_articulated_<digits>`."""
    return asset_id.rpartition("_")[0].removesuffix("_articulated")


def fitted_choice(
    choice: PresetChoice, role: str, rule: RoleRule, library: Mapping[str, Mapping[str, Any]], place: Place
) -> tuple[PresetChoice, dict[str, Any]]:
    """An asset of a library, fitted to a role, with its scale and base if they differ; and its sizes at that scale.

    The choice names it, and may state both. `library`: sizes of all assets by id. Raises ModelMisfit: it does not suit.
    """
    sizes = library[choice.name]
    if rule.refused:
        raise ModelMisfit(f"a preset of a family for the {role}: {rule.refused}", named(choice))
    if rule.categories and sizes["category"] not in rule.categories:
        got = f"{named(choice)}, the category of which is {sizes['category']}"
        raise ModelMisfit(_of_category(role, rule, library), got)
    scale = choice.params.get("scale")
    if scale is None:
        scale = _scale(sizes, rule, place)
    else:
        low, high = _bounds(sizes, rule, place)
        scale = scale if low - 1e-9 <= float(scale) <= high + 1e-9 else None
    if scale is None:
        text = " x ".join(f"{sizes[side]:.3f}" for side in SIDES)
        scaled = f" before it is scaled by {choice.params['scale']:g}" if "scale" in choice.params else ""
        got = f"{named(choice)}, which is {text} m (width x depth x height){scaled}"
        raise ModelMisfit(_of_size(role, rule, place, library, choice.name), got)
    own = {name: float(sizes[name]) * scale for name in SIZES if name in sizes}
    if place.fills and place.most["width"] - own["width"] > MAX_GAP_M:
        width = place.most["width"]
        expected = f"a {role} of {width:.3f} m, to fill {place.name}: leave the width of that unit out"
        raise ModelMisfit(expected, f"{named(choice)}, which is {own['width']:.3f} m wide where its height fits")
    params: dict[str, Any] = {} if scale == 1.0 else {"scale": scale}
    reach = choice.params.get("reach", place.reach)
    if reach is not None and own["sweep"] > reach:
        params["reach"] = reach
    # What would fall or lean if it were free is fixed.
    own_base = str(sizes["base"] if rule.base is None else rule.base.value)
    base = choice.params.get("base") or (own_base if sizes["stands"] else Base.FIXED.value)
    if base != sizes["base"]:
        params["base"] = base
    return PresetChoice(preset=choice.preset, params=params), {**sizes, **own}


def named(choice: PresetChoice) -> str:
    """A choice as files name it."""
    return choice.preset.replace("/", ":", 1) if choice.is_library else choice.preset


def _scale(sizes: Mapping[str, Any], rule: RoleRule, place: Place) -> float | None:
    """The scale nearest to 1, or to the one for its wanted level, with which an asset fits; None if no scale fits."""
    low, high = _bounds(sizes, rule, place)
    if low > high:
        return None
    wanted = 1.0
    if rule.level is not None:
        wanted = min(max(1.0, rule.level[0] / sizes["level"]), rule.level[1] / sizes["level"])
    if place.fills:
        # Rather wide enough than level, as far as the sizes allow.
        wanted = max(wanted, (place.most["width"] - MAX_GAP_M / 2) / sizes["width"])
    scale = min(max(wanted, low), high)
    step = 10.0**SCALE_DIGITS
    rounded = math.floor(scale * step + 1e-6) / step
    return rounded if rounded >= low - 1e-9 else math.ceil(scale * step) / step


def _bounds(sizes: Mapping[str, Any], rule: RoleRule, place: Place) -> tuple[float, float]:
    """Least and greatest scale with which an asset is within the sizes of a role and of its place."""
    low, high = 0.0, math.inf
    for side, (least, greatest) in rule.sizes.items():
        low, high = max(low, least / sizes[side]), min(high, greatest / sizes[side])
    for side, greatest in place.most.items():
        high = min(high, greatest / sizes[side])
    return (low, high) if math.isfinite(high) else (low or 1.0, high)


def _of_category(role: str, rule: RoleRule, library: Mapping[str, Mapping[str, Any]]) -> str:
    of_kind = [name for name in library if category_of(name) in rule.categories]
    return (
        f"an asset of the category {' or '.join(rule.categories)}{_there_are(of_kind)}; "
        f"make it with `--category {rule.categories[0]}`, or add its category to {role} in the project's roles.yaml"
    )


def _of_size(role: str, rule: RoleRule, place: Place, library: Mapping[str, Mapping[str, Any]], but: str) -> str:
    text = ", ".join(
        f"{side} {least:g} to {min(greatest, place.most.get(side, math.inf)):.4g}"
        for side, (least, greatest) in rule.sizes.items()
    )
    of_kind = (name for name in library if name != but and category_of(name) in rule.categories)
    fitting = [name for name in islice(of_kind, MAX_READ) if _scale(library[name], rule, place) is not None]
    return (
        f"a {role} that can be scaled evenly to {text} m{_there_are(fitting)}; make it anew with `--front` or `--up` "
        f"where it is turned the wrong way, or state other sizes for {role} in the project's roles.yaml"
    )


def _there_are(names: Iterable[str]) -> str:
    found = list(islice(names, MAX_NAMED))
    return f", such as {', '.join(f'{LIBRARY}:{name}' for name in found)}" if found else NONE_IN_LIBRARIES
