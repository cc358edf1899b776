"""Look up the member of a family, or the asset of a library, that a plan or its style has for a role.

An asset of a library is fitted to its role: whether its category suits, and by which factor it is scaled to its place.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

from casa_assets.errors import CasaError, PlanConflict, StyleConflict, UnknownId
from casa_assets.layouts.plan import standard_sizes
from casa_assets.model.asset.asset import Base
from casa_assets.model.kitchen.plan import BaseKind, BaseUnit, Plan, UpperKind, UpperUnit, WorktopItem
from casa_assets.model.kitchen.style import LIBRARY, PresetChoice, Style
from casa_assets.model.registry.rows import RoleRule

SIDES = ("width", "depth", "height")
SCALE_DIGITS = 4
# Of the libraries' assets whose category suits a role, this many are read, and this many named where one doesn't fit.
MAX_READ, MAX_NAMED = 20, 4
# A place of a stated width that would stay emptier than this beside its appliance is refused, metres.
MAX_GAP_M = 0.03
SIZES = ("width", "depth", "height", "level", "size", "sweep", "drop")  # lengths of an asset, all scaled alike
NONE_IN_LIBRARIES = ", of which the libraries have none"
# family -> preset -> its parameters, as JSON has them.
FamilyPresets = Mapping[str, Mapping[str, Mapping[str, Any]]]
# Kinds of units with an appliance, and its role in styles.
APPLIANCE_ROLES: Mapping[BaseKind | UpperKind, str] = {
    BaseKind.RANGE: "range",
    BaseKind.DISHWASHER: "dishwasher",
    BaseKind.FRIDGE: "fridge",
    BaseKind.OVEN: "oven",
    BaseKind.MICROWAVE: "microwave_built_in",
    BaseKind.SINK: "sink",
    BaseKind.HOB: "hob",
    UpperKind.HOOD: "hood",
    UpperKind.MICROWAVE: "microwave_built_in",
}
# Appliances between which and the cabinets beside them there are joints of some millimetres alone.
FILLING = (BaseKind.RANGE, BaseKind.DISHWASHER, BaseKind.OVEN)
ON_WORKTOP = "on_worktop"  # role of what a plan puts on a worktop under another name than that of a role
# What to do where an asset of a library is asked for and no library is in use.
NO_LIBRARY = (
    "no library is in use; name its folder under `libraries:` in casa.yaml of a project (`casa-assets init FOLDER` "
    "writes one), and run the command in that folder, or with --project FOLDER"
)


@dataclass(frozen=True)
class Place:
    """Place of a model in a kitchen.

    Attributes:
        most: maximum size of a model by dimension, metres.
        fills: whether the plan states the width of the unit, which the model then has to fill. name: of the unit.
        reach: how far doors may swing out to the side of the model, metres; None: as far as they do.
    """

    most: Mapping[str, float]
    fills: bool = False
    name: str = ""
    reach: float | None = None


ANYWHERE = Place({})


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
        f"a {role} that can be scaled evenly to {text} m{_there_are(fitting)}; make it again with `--front` or `--up` "
        f"where it is turned the wrong way, or state other sizes for {role} in the project's roles.yaml"
    )


def _there_are(names: Iterable[str]) -> str:
    found = list(islice(names, MAX_NAMED))
    return f", such as {', '.join(f'{LIBRARY}:{name}' for name in found)}" if found else NONE_IN_LIBRARIES


@dataclass(frozen=True)
class StyleModel:
    """A chosen member of a family or asset of a library, with the scale and base of that, and its sizes as params."""

    choice: PresetChoice
    params: Mapping[str, Any]

    def length(self, name: str) -> float:
        """A parameter that is a length, metres. Raises CasaError where the member has none of that name."""
        if name not in self.params:
            raise CasaError(f"{self.choice.preset} has no {name}, which its place in the kitchen asks for")
        return float(self.params[name])

    def with_params(self, **params: Any) -> PresetChoice:
        """The choice with some numbers of the family changed; an asset of a library stays as it is."""
        if self.choice.is_library:
            return self.choice
        return PresetChoice(preset=self.choice.preset, params={**self.choice.params, **params})


@dataclass(frozen=True)
class StyleModels:
    """The models of a kitchen: those of its style, and those that its plan names itself.

    Attributes:
        style: the style. presets: parameters of all presets of all families, and sizes of all assets of libraries.
        roles: which assets of libraries suit which role; a role without a rule takes any, as it is.
        ceiling: height of the room, metres.
    """

    style: Style
    presets: FamilyPresets
    roles: Mapping[str, RoleRule] = field(default_factory=dict)
    ceiling: float = 2.7

    def for_role(self, role: str) -> StyleModel:
        """The style's model for a role.

        Raises UnknownId: there is none, or it names none that exists; StyleConflict: the model does not suit the role.
        """
        return self._of_style(role, ANYWHERE)

    def for_unit(self, unit: BaseUnit | UpperUnit) -> StyleModel:
        """The model of the appliance of a unit: that which the plan names, else the style's.

        Raises as `for_role`, and ModelMisfit: what the plan names does not suit.
        """
        role = APPLIANCE_ROLES.get(unit.kind)
        if role is None:
            raise ModelMisfit(f"no model for {unit.kind.value}, which has no appliance", repr(unit.id))
        place = self._place(unit)
        return self._of_style(role, place) if unit.model is None else self.fitted(unit.model, role, place)

    def for_item(self, item: WorktopItem) -> StyleModel:
        """The model of an item on a worktop. Raises as `for_unit`."""
        role = self.role_of(item)
        return self.for_role(item.id) if item.model is None else self.fitted(item.model, role, ANYWHERE)

    def role_of(self, item: WorktopItem) -> str:
        """Role of an item on a worktop: its id, or the family or category of a model that the plan names freely."""
        if item.model is None or item.id in self.style.models:
            return item.id
        if not item.model.is_library:
            return item.model.family
        category = str(self.resolve(item.model).params["category"])
        return category if category in self.style.models else ON_WORKTOP

    def has(self, role: str) -> bool:
        """True if the style has a model for the role."""
        return role in self.style.models

    def resolve(self, choice: PresetChoice) -> StyleModel:
        """A choice with all parameters of its preset, fitted to no role. Raises UnknownId."""
        if choice.family not in self.presets:
            raise UnknownId("family", choice.family, self.presets)
        presets = self.presets[choice.family]
        if choice.name not in presets:
            if choice.is_library:
                raise UnknownId("library asset", choice.name, presets, "" if presets else NO_LIBRARY)
            raise UnknownId(f"preset of {choice.family}", choice.name, presets)
        return StyleModel(choice, {**presets[choice.name], **choice.params})

    def fitted(self, choice: PresetChoice, role: str, place: Place) -> StyleModel:
        """A choice fitted to a role. Raises UnknownId; ModelMisfit if it does not suit."""
        model = self.resolve(choice)
        if not choice.is_library or role not in self.roles:
            return model
        fitted, params = fitted_choice(choice, role, self.roles[role], self.presets[choice.family], place)
        return StyleModel(fitted, params)

    def _of_style(self, role: str, place: Place) -> StyleModel:
        if role not in self.style.models:
            raise UnknownId(f"model of style {self.style.id}", role, self.style.models)
        try:
            return self.fitted(self.style.models[role], role, place)
        except ModelMisfit as error:
            raise StyleConflict(self.style.id, ("models", role), error.expected, error.got) from error

    def _place(self, unit: BaseUnit | UpperUnit) -> Place:
        """Greatest sizes of the appliance of a unit, whether it fills the unit, and how far its doors may reach."""
        most: dict[str, float] = {}
        if isinstance(unit.width, float):
            most["width"] = round(unit.width - standard_sizes.room_beside(unit, is_library=True), 4)
        if unit.kind is BaseKind.DISHWASHER:
            most["height"] = standard_sizes.WORKTOP_HEIGHT - self.style.counter.thickness - standard_sizes.TOP_PLAY
        elif unit.kind is UpperKind.HOOD:
            most["height"] = round(self.ceiling - standard_sizes.HOOD_FROM, 4)
        reach = standard_sizes.MAX_DOOR_REACH if unit.kind is BaseKind.FRIDGE else None
        return Place(most, fills="width" in most and unit.kind in FILLING, name=unit.id, reach=reach)


def check_plan_models(plan: Plan, models: StyleModels) -> None:
    """Raise PlanConflict if a plan names a model that does not suit, or does not exist."""
    for pointer, named in _named_models(plan):
        try:
            if isinstance(named, WorktopItem):
                models.for_item(named)
            else:
                models.for_unit(named)
        except ModelMisfit as error:
            raise PlanConflict(plan.id, pointer, error.expected, error.got) from error
        except UnknownId as error:
            near = ", ".join(error.nearest)
            expected = f"{near}, or another {error.kind}" if near else f"{error.kind}, such as family/preset"
            raise PlanConflict(plan.id, pointer, expected, repr(error.wanted)) from error


def _named_models(plan: Plan) -> Iterator[tuple[tuple[str | int, ...], BaseUnit | UpperUnit | WorktopItem]]:
    """Units and worktop items for which the plan names a model, each with its place in the plan's file."""
    for run in plan.runs:
        rows: tuple[tuple[str, tuple[BaseUnit | UpperUnit, ...]], ...] = (("base", run.base), ("upper", run.upper))
        for row, units in rows:
            for k, unit in enumerate(units):
                if unit.model is not None:
                    yield ("runs", run.id, row, k, "model"), unit
    for item in plan.worktop_items:
        if item.model is not None:
            yield ("worktop_items", item.id, "model"), item
