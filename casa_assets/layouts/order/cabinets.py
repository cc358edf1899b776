"""Order the cabinets and appliances for the slots of a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from casa_assets.layouts.order.build_order import BuildOrder, DepthReference, HeightReference, Spot
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.runs import CornerPart, UnitSlot
from casa_assets.layouts.plan.style_models import StyleModel, StyleModels
from casa_assets.model.kitchen.plan import BaseKind, BaseUnit, UpperKind, UpperUnit
from casa_assets.model.kitchen.style import FrontStyle, PresetChoice

NICHE_PLAY_M = 0.004  # gap over an appliance in a niche
OVEN_NICHE_FROM_M, MICROWAVE_NICHE_FROM_M = 0.74, 1.08  # heights of the niches in tall units
OVEN_LIFT_M = 0.005  # gap between an oven and its board: the handle of the open door clears the drawer below
FRONT_THICKNESS_M = 0.02
UNDER_DOORS_M = 0.005  # between a hood and the cabinet over it, whose doors reach below it
HOODS_UNDER_CABINETS = ("under_cabinet", "downlight")  # forms of hoods with a cabinet over them
HOUSING_FLOOR_M = 0.0062  # upper face of the board under a built-in refrigerator
MICROWAVE_SETBACK_M = 0.0025  # distance of a built-in microwave behind the fronts beside it
MICROWAVE_FRAME_M = 0.04  # of the frame round a microwave, above and below
AIR_OVER_M = 0.02  # over an asset of a library in a niche, which has no frame that covers it
# A hood of a library that is less high hangs under a cabinet; a higher one is a chimney.
MIN_CHIMNEY_M, CEILING_PLAY_M = 0.37, 0.001
# Greatest height of the foot of a library's chimney that hangs right under the ceiling; shorter ones leave a gap there.
MAX_CHIMNEY_FOOT_M = 1.85
# Relative heights of the fronts of a drawer stack, from the floor up.
DRAWER_RATIOS: dict[int, tuple[float, ...]] = {
    1: (1.0,),
    2: (1.0, 1.0),
    3: (2.0, 2.0, 1.0),
    4: (1.5, 1.5, 1.2, 0.95),
    5: (1.2, 1.2, 1.0, 1.0, 1.0),
}


def order_unit(order: BuildOrder, slot: UnitSlot, models: StyleModels, ceiling: float) -> None:
    """Order the cabinet and the appliance of one slot. Raises UnknownId where the style has no model for it."""
    kind = slot.kind
    if isinstance(kind, CornerPart):
        _corner(order, slot, models)
    elif isinstance(kind, UpperKind):
        _upper(order, slot, models, ceiling)
    elif kind in (BaseKind.PANTRY, BaseKind.OVEN, BaseKind.MICROWAVE, BaseKind.FRIDGE):
        _tall(order, slot, models)
    elif kind is not BaseKind.GAP:
        _base(order, slot, models)


def front_look(models: StyleModels, group: str) -> dict[str, Any]:
    """Parameter `look` of the cabinets of a group."""
    cabinets = models.style.cabinets
    base, groups = cabinets.base, ("upper", "tall", "island")
    fronts = base if group not in groups else getattr(cabinets, group).filled_from(base)
    return {name: getattr(fronts, name) for name in FrontStyle.model_fields}


def group_of(slot: UnitSlot) -> str:
    """Group of fronts that a unit on the floor belongs to."""
    return "island" if slot.line.is_island else "base"


def _add(
    order: BuildOrder,
    slot: UnitSlot,
    role: str,
    choice: PresetChoice | str,
    params: Mapping[str, Any] | None = None,
    *,
    name: str = "",
    v: float = 0.0,
    z: float | None = None,
    **at: Any,
) -> None:
    """Order a choice, or a preset with some numbers changed, for a slot; at a `Spot` in it."""
    spot = Spot(slot.line.frame, slot.middle, v - slot.recess, slot.bottom if z is None else z, **at)
    order.add(name or slot.name, role, choice, spot, params, unit=slot.name, run=slot.line.id)


def _base(order: BuildOrder, slot: UnitSlot, models: StyleModels) -> None:
    unit, group = slot.unit, group_of(slot)
    assert isinstance(unit, BaseUnit)
    common = {"width": slot.width, "depth": slot.depth, "height": slot.top, "look": front_look(models, group)}
    side = slot.hinge.value if slot.hinge else "left"
    if unit.kind is BaseKind.DRAWERS:
        shares = DRAWER_RATIOS[unit.drawers or 3]
        _add(order, slot, "base", "drawer_stack/shaker_white_three", {**common, "shares": shares})
    elif unit.kind in (BaseKind.DOORS, BaseKind.HOB):
        doors = {"doors": _door_count(slot.width), "hinge": side}
        drawer = 0.17 if unit.drawers and unit.kind is BaseKind.DOORS else 0.0
        shelves = {"shelves": 1, "open_top": True} if unit.kind is BaseKind.HOB else {}
        _add(order, slot, "base", "base_cabinet/shaker_white", {**common, **doors, "drawer": drawer, **shelves})
    elif unit.kind is BaseKind.SINK:
        _add(order, slot, "sink_base", "sink_base/shaker_white", {**common, "hinge": side})
    elif unit.kind is BaseKind.ISLAND:
        columns = {"columns": standard_sizes.island_columns(slot.width)}
        _add(order, slot, "base", "island_base/shaker_white", {**common, **columns})
    elif unit.kind is BaseKind.SHELF:
        face = models.style.cabinets.shelf
        shelf = {"width": slot.width, "depth": 0.58, "height": slot.top, "plinth": 0.1, "face": face, "inside": face}
        _add(order, slot, "shelf", "open_shelf/pine_floor", shelf)
    elif unit.kind is BaseKind.FILLER:
        _filler(order, slot, models)
    elif unit.kind is BaseKind.PANEL:
        panel: dict[str, Any] = {"width": slot.depth, "height": slot.top, "thick": standard_sizes.END_PANEL}
        panel |= {"front": "slab", "face": face_of(models, group)}
        spot = Spot(slot.line.frame, slot.middle, slot.depth / 2, 0.0, 90.0, DepthReference.MIDDLE)
        order.add(slot.name, "panel", "cabinet_panel/slab_oak", spot, panel, unit=slot.name, run=slot.line.id)
    elif unit.kind is BaseKind.RANGE:
        _add(order, slot, "range", models.for_unit(unit).choice, v=0.012)
    elif unit.kind is BaseKind.DISHWASHER:
        model = models.for_unit(unit)
        height = min(model.length("height"), slot.top - standard_sizes.TOP_PLAY)
        _add(order, slot, "dishwasher", model.with_params(height=round(height, 4)), v=0.002)


def _door_count(width: float) -> int:
    return 1 if width <= standard_sizes.WIDEST_SINGLE_DOOR else 2


def face_of(models: StyleModels, group: str) -> str:
    """Finish of the fronts of a group."""
    return str(front_look(models, group)["face"])


def _filler(order: BuildOrder, slot: UnitSlot, models: StyleModels) -> None:
    upper = slot.is_upper
    # A strip between tall units is as high as they are, and has their finish.
    group = "upper" if upper else "tall" if slot.top > standard_sizes.UPPER_FROM else group_of(slot)
    low = slot.bottom if upper else 0.1
    strip = {"width": slot.width, "height": round(slot.top - low, 4), "face": face_of(models, group), "kind": "plain"}
    spot = Spot(slot.line.frame, slot.middle, slot.depth, low, depth_reference=DepthReference.FRONT)
    order.add(slot.name, "filler", "filler/white", spot, strip, unit=slot.name, run=slot.line.id)


def _corner(order: BuildOrder, slot: UnitSlot, models: StyleModels) -> None:
    upper = slot.is_upper
    group = "upper" if upper else group_of(slot)
    if slot.kind is CornerPart.FILLER:
        _filler(order, slot, models)
        return
    assert slot.corner is not None
    assert slot.hinge is not None
    common = {
        "height": round(slot.top - slot.bottom, 4),
        "depth": slot.depth,
        "plinth": 0.0 if upper else 0.1,
        "corner": slot.corner.value,
        "hinge": slot.hinge.value,
        "look": front_look(models, group),
    }
    if slot.kind is CornerPart.DIAGONAL:
        _add(order, slot, "corner", "corner_cabinet_diagonal/shaker_white", {**common, "leg": slot.width})
        return
    blind = (standard_sizes.UPPER_CORNER_CLEARANCE if upper else standard_sizes.CORNER_CLEARANCE) - 0.05
    wide = {"width": slot.width, "blind": blind}
    _add(order, slot, "corner", "corner_cabinet_blind/shaker_white", {**common, **wide})


def _upper(order: BuildOrder, slot: UnitSlot, models: StyleModels, ceiling: float) -> None:
    height = round(slot.top - slot.bottom, 4)
    size = {"width": slot.width, "depth": slot.depth, "height": height}
    side = slot.hinge.value if slot.hinge else "left"
    face = models.style.cabinets.shelf
    if slot.kind in (UpperKind.DOORS, UpperKind.GLASS):
        fronts = front_look(models, "upper")
        if slot.kind is UpperKind.GLASS:
            fronts["front"] = models.style.cabinets.glass
        params = {**size, "doors": _door_count(slot.width), "hinge": side, "look": fronts}
        _add(order, slot, "upper", "wall_cabinet/shaker_white", params)
    elif slot.kind is UpperKind.SHELF:
        _add(order, slot, "shelf", "open_shelf/white_wall", {**size, "face": face, "inside": face})
    elif slot.kind is UpperKind.BOARDS:
        boards = {"width": slot.width, "depth": 0.25, "boards": 2, "spacing": 0.36, "face": face}
        preset = models.for_role("boards").choice.preset if models.has("boards") else "floating_shelf/oak_floating"
        _add(order, slot, "shelf", preset, boards, z=1.42)
    elif slot.kind is UpperKind.FILLER:
        _filler(order, slot, models)
    elif slot.kind is UpperKind.MICROWAVE:
        _hung_microwave(order, slot, models)
    elif slot.kind is UpperKind.HOOD:
        _hood(order, slot, models, ceiling)


def _hung_microwave(order: BuildOrder, slot: UnitSlot, models: StyleModels) -> None:
    assert isinstance(slot.unit, UpperUnit)
    model = models.for_unit(slot.unit)
    depth = max(0.42, round(model.length("depth") + 0.05, 3))
    housing = {
        "width": slot.width,
        "depth": depth,
        "height": round(slot.top - slot.bottom, 4),
        "plinth": 0.0,
        "niche_from": 0.0,
        "niche": _microwave_niche(model),
        "over": "doors" if slot.width >= 0.5 else "door",
        "look": front_look(models, "upper"),
    }
    _add(order, slot, "housing", "housing_microwave/graphite_hanging", housing)
    # The frame of a family's stands on the cabinet; an asset of a library stands on the board in it.
    foot = slot.bottom + (HOUSING_FLOOR_M if model.choice.is_library else NICHE_PLAY_M / 2)
    _microwave(order, slot, model, depth, foot)


def _microwave_niche(model: StyleModel) -> float:
    """Height of the niche of a built-in microwave, from the middle of a board to that of the other, metres."""
    if model.choice.is_library:
        return round(max(0.3, model.length("height") + standard_sizes.BOARD_THICKNESS + AIR_OVER_M), 4)
    return round(model.length("height") + 2 * MICROWAVE_FRAME_M + NICHE_PLAY_M, 4)


def _microwave(order: BuildOrder, slot: UnitSlot, model: StyleModel, front: float, foot: float) -> None:
    """Order a built-in microwave. front: of the cabinet, from the wall. foot: height of its underside. Metres."""
    at, front_side = front - MICROWAVE_SETBACK_M, DepthReference.FRONT
    _add(order, slot, "microwave", model.choice, name=f"{slot.name}_oven", v=at, z=foot, depth_reference=front_side)


def is_under_cabinet(hood: StyleModel) -> bool:
    """True if a hood hangs under a cabinet; otherwise it reaches up to the ceiling, or towards it."""
    if hood.choice.is_library:
        return hood.length("height") < MIN_CHIMNEY_M
    return hood.params.get("form") in HOODS_UNDER_CABINETS


def _hood(order: BuildOrder, slot: UnitSlot, models: StyleModels, ceiling: float) -> None:
    """A hood, as wide as the plan says or else as its model is; with a cabinet over it where it hangs under one."""
    assert isinstance(slot.unit, UpperUnit)
    model = models.for_unit(slot.unit)
    if slot.unit.width is not None and not model.choice.is_library:
        ledge = standard_sizes.CANOPY_LEDGE if model.params.get("form") == "canopy" else 0.0
        model = models.resolve(model.with_params(width=round(slot.width - 2 * ledge, 4)))
    low = standard_sizes.HOOD_FROM
    if is_under_cabinet(model):
        _add(order, slot, "hood", model.choice, z=low)
        top = round(low + model.length("height") + UNDER_DOORS_M, 4)
        doors = {
            "width": slot.width,
            "depth": standard_sizes.UPPER_DEPTH,
            "height": round(standard_sizes.UPPER_TO - top, 4),
            "doors": _door_count(slot.width),
            "look": front_look(models, "upper"),
        }
        _add(order, slot, "upper", "wall_cabinet/shaker_white", doors, name=f"{slot.name}_cabinet", z=top)
        return
    if model.choice.is_library:
        under_ceiling = round(ceiling - model.length("height") - CEILING_PLAY_M, 4)
        is_near = low <= under_ceiling <= MAX_CHIMNEY_FOOT_M
        _add(order, slot, "hood", model.choice, z=under_ceiling if is_near else low)
        return
    choice = model.with_params(height=round(min(1.2, ceiling - low), 3))
    _add(order, slot, "hood", choice, z=ceiling, height_reference=HeightReference.HEAD)


def _tall(order: BuildOrder, slot: UnitSlot, models: StyleModels) -> None:
    unit = slot.unit
    assert isinstance(unit, BaseUnit)
    common = {"width": slot.width, "height": slot.top, "look": front_look(models, "tall")}
    side = slot.hinge.value if slot.hinge else "left"
    if unit.kind is BaseKind.PANTRY:
        doors = {"doors": _door_count(slot.width), "hinge": side, "split": 1.38, "depth": slot.depth}
        _add(order, slot, "pantry", "tall_cabinet/shaker_white_split", {**common, **doors})
    elif unit.kind is BaseKind.OVEN:
        _oven(order, slot, models.for_unit(unit), common)
    elif unit.kind is BaseKind.MICROWAVE:
        model = models.for_unit(unit)
        niche = {"niche_from": MICROWAVE_NICHE_FROM_M, "niche": _microwave_niche(model), "depth": slot.depth}
        _add(order, slot, "housing", "housing_microwave/shaker_white_tall", {**common, **niche})
        board = standard_sizes.BOARD_THICKNESS / 2 + OVEN_LIFT_M
        foot = MICROWAVE_NICHE_FROM_M + (board if model.choice.is_library else NICHE_PLAY_M / 2)
        _microwave(order, slot, model, slot.depth, foot)
    elif unit.kind is BaseKind.FRIDGE:
        _fridge(order, slot, unit, models, common)


def _oven(order: BuildOrder, slot: UnitSlot, model: StyleModel, common: dict[str, Any]) -> None:
    board = standard_sizes.BOARD_THICKNESS
    lift, air, behind = OVEN_LIFT_M, NICHE_PLAY_M, FRONT_THICKNESS_M + 0.001
    if model.choice.is_library:
        # Its front is between the sides of the cabinet, which hold it, where that of a family's covers them; and it is
        # so high over the board that the handle of its open door clears the drawer below.
        lift, air, behind = max(lift, model.length("drop") + OVEN_LIFT_M), AIR_OVER_M, 0.001
    niche: dict[str, Any] = {
        "niche_from": OVEN_NICHE_FROM_M,
        "niche": round(model.length("height") + board + lift + air, 4),
        "depth": slot.depth,
        "over": "doors" if slot.width >= 0.5 else "door",
    }
    _add(order, slot, "housing", "housing_oven/shaker_white", {**common, **niche})
    back = round(slot.depth - behind - model.length("depth"), 4)
    foot = round(OVEN_NICHE_FROM_M + board / 2 + lift, 4)
    _add(order, slot, "oven", model.choice, name=f"{slot.name}_oven", v=back, z=foot)


def _fridge(order: BuildOrder, slot: UnitSlot, unit: BaseUnit, models: StyleModels, common: dict[str, Any]) -> None:
    model = models.for_unit(unit)
    name = slot.name
    if unit.housing:
        niche = {"niche": round(model.length("height") + 0.03, 3), "depth": slot.depth, "over": "doors"}
        _add(order, slot, "housing", "housing_fridge/shaker_white", {**common, **niche}, name=f"{name}_housing")
    # In a housing it stands on the board at the bottom.
    _add(order, slot, "fridge", model.choice, name=name, v=0.03, z=HOUSING_FLOOR_M if unit.housing else 0.0)
