"""Objects that the 65 atomic tasks of RoboCasa v1.0 draw when they are reset, and which of them are missing in a set.

Ref: robocasa v1.0.1, `_get_obj_cfgs` of the tasks, `create_obj` (env_utils.py) and `sample_kitchen_object`. If no
category suits a draw, the reset fails with "a cannot be empty"; if no object is small enough, it never ends.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from casa_assets.addons.robocasa.writers.casa_objects import GROUPS
from casa_assets.model.record import Vec3
from casa_assets.model.registry.category import Affordance, Category
from casa_assets.model.registry.contract import RobocasaRelease

EVERYTHING = "all"
# Groups that are neither a category nor a type. Ref: robocasa v1.0, OBJ_GROUPS.
CUSTOM_GROUPS: Mapping[str, tuple[str, ...]] = {
    "container": ("plate",),
    "cookware": ("pan", "pot", "saucepan", "kettle_non_electric"),
    "oven_ready": (
        *("corn", "fish", "steak", "tray", "potato", "sweet_potato", "chicken_drumstick", "eggplant", "broccoli"),
    ),
}


@dataclass(frozen=True)
class Draw:
    """One object that a task asks for.

    Attributes:
        groups: categories, types of categories or groups of RoboCasa, to one of which the object belongs.
        uses: required affordances.
        without: groups to which it must not belong.
        max_size: maximum size along x, y and z, metres.
    """

    groups: tuple[str, ...] = (EVERYTHING,)
    uses: tuple[Affordance, ...] = ()
    without: tuple[str, ...] = ()
    max_size: Vec3 = (math.inf, math.inf, math.inf)

    def __str__(self) -> str:
        """Text such as `tool or utensil, graspable, at most 0.1 m high`."""
        parts = [" or ".join(self.groups).replace(EVERYTHING, "anything"), *(use.value for use in self.uses)]
        if self.without:
            parts.append(f"no {' or '.join(self.without)}")
        if self.max_size[0] < math.inf:
            parts.append(f"at most {self.max_size[0]:g} x {self.max_size[1]:g} m")
        if self.max_size[2] < math.inf:
            parts.append(f"at most {self.max_size[2]:g} m high")
        return ", ".join(parts)

    def suits(self, category: Category, size: Vec3) -> bool:
        """True if an object of this category and size (along x, y and z, metres) may be drawn."""
        return (
            any(_is_in(category, group) for group in self.groups)
            and not any(_is_in(category, group) for group in self.without)
            and all(category.can(use) for use in self.uses)
            and all(length <= most for length, most in zip(size, self.max_size, strict=True))
        )


def _is_in(category: Category, group: str) -> bool:
    types = {kind.value for kind in category.types}
    if group == EVERYTHING:  # RoboCasa's own categories, and ours that have a type (`casa_objects.py`)
        return bool(types) or RobocasaRelease.V1_0 in category.runtime
    if group in CUSTOM_GROUPS:
        return category.id in CUSTOM_GROUPS[group]
    return group == category.id or group in types or not types.isdisjoint(GROUPS.get(group, ()))


_GRASPED = (Affordance.GRASPABLE,)
_COLD = (Affordance.GRASPABLE, Affordance.FRIDGABLE)
_HEATED = (Affordance.GRASPABLE, Affordance.MICROWAVABLE)
_COOKED = (Affordance.GRASPABLE, Affordance.COOKABLE)
_WASHED = (Affordance.GRASPABLE, Affordance.WASHABLE)
_ANY, _IN_HAND, _IN_SINK = Draw(), Draw(uses=_GRASPED), Draw(uses=(Affordance.WASHABLE,))
_PLATE, _CONTAINER, _TRAY, _PAN = (Draw((name,)) for name in ("plate", "container", "oven_tray", "pan"))
_MUG, _SANDWICH_BREAD, _COOKWARE = (Draw((name,)) for name in ("mug", "sandwich_bread", "cookware"))
_HOT_CONTAINER = Draw(("container",), (Affordance.MICROWAVABLE,))
_PRODUCE = Draw(("vegetable", "fruit"), _COLD)
_BREAD = Draw(("bread_food",), _GRASPED)
_TOOL = Draw(("tool", "utensil"), _GRASPED, ("reamer", "strainer", "cheese_grater"))
_LOW_TOOL = Draw(("tool", "utensil"), _GRASPED, max_size=(math.inf, math.inf, 0.1))
_COOKED_FOOD = Draw(("food",), _COOKED)

# Task -> what a reset draws; a task that is not here draws nothing. What food is put into is among them: it is drawn
# together with the food.
TASK_DRAWS: Mapping[str, tuple[Draw, ...]] = {
    "CheesyBread": (Draw(("bread_flat",)), Draw(("cutting_board",)), Draw(("cheese",)), _ANY),
    **dict.fromkeys(("OpenCabinet", "CloseCabinet"), (_IN_HAND, _ANY)),
    **dict.fromkeys(("PickPlaceCounterToCabinet", "PickPlaceCabinetToCounter"), (_IN_HAND, _ANY)),
    **dict.fromkeys(("OpenDishwasher", "CloseDishwasher"), (_ANY,)),
    **dict.fromkeys(("OpenDrawer", "CloseDrawer"), (_LOW_TOOL, _ANY)),
    **dict.fromkeys(("OpenFridge", "CloseFridge"), (Draw(uses=_COLD), _ANY)),
    **dict.fromkeys(("OpenFridgeDrawer", "CloseFridgeDrawer"), (_PRODUCE, Draw(uses=_COLD))),
    **dict.fromkeys(("OpenMicrowave", "CloseMicrowave"), (Draw(uses=_HEATED), _ANY)),
    **dict.fromkeys(("OpenOven", "CloseOven"), (Draw(uses=_COOKED), _TRAY, _ANY)),
    **dict.fromkeys(("StartCoffeeMachine", "CoffeeSetupMug", "CoffeeServeMug"), (_MUG,)),
    "LowerHeat": (Draw(("kettle_non_electric",)),),
    "MakeIcedCoffee": (Draw(("bowl",)), Draw(("ice_cube",)), Draw(("glass_cup",))),
    "PackDessert": (
        Draw(("cooked_food",), _GRASPED),
        Draw(("tupperware",)),
        Draw(("sweets",), _GRASPED, ("sugar_cube",)),
    ),
    "PickPlaceCounterToBlender": (Draw(("fruit",), _GRASPED), Draw(without=("fruit", "vegetable"))),
    **dict.fromkeys(
        ("PickPlaceCounterToDrawer", "PickPlaceDrawerToCounter"), (_TOOL, Draw(without=("tool", "utensil")))
    ),
    "PickPlaceCounterToMicrowave": (
        Draw(("food",), _HEATED),
        _CONTAINER,
        Draw(("plate",), (Affordance.MICROWAVABLE,)),
        _ANY,
    ),
    "PickPlaceMicrowaveToCounter": (Draw(("food",), _HEATED), _HOT_CONTAINER, _CONTAINER, _ANY),
    "PickPlaceCounterToOven": (Draw(("oven_ready",), _GRASPED), _PLATE, _TRAY),
    "PickPlaceCounterToSink": (Draw(uses=_WASHED), _ANY, _IN_SINK),
    "PickPlaceSinkToCounter": (Draw(("food",), _WASHED), _CONTAINER, _ANY),
    "PickPlaceCounterToStandMixer": (Draw(("cheese", "bread", "cake"), _GRASPED),),
    "PickPlaceCounterToStove": (_PAN, _COOKED_FOOD, _CONTAINER),
    "PickPlaceStoveToCounter": (
        Draw(("food",), _COOKED, max_size=(0.15, 0.15, math.inf)),
        _PAN,
        Draw(("plate", "bowl")),
    ),
    **dict.fromkeys(("PickPlaceCounterToToasterOven", "PickPlaceToasterOvenToCounter"), (_BREAD, _PLATE)),
    "PickPlaceToasterToCounter": (_SANDWICH_BREAD, _PLATE),
    **dict.fromkeys(
        ("PickPlaceFridgeShelfToDrawer", "PickPlaceFridgeDrawerToShelf"),
        (_PRODUCE, Draw(uses=(Affordance.FRIDGABLE,), without=("vegetable", "fruit"))),
    ),
    **dict.fromkeys(("TurnOnMicrowave", "TurnOffMicrowave"), (Draw(uses=(Affordance.MICROWAVABLE,)), _HOT_CONTAINER)),
    **dict.fromkeys(("TurnOnSinkFaucet", "TurnOffSinkFaucet", "TurnSinkSpout"), (_IN_SINK, _ANY)),
    **dict.fromkeys(("TurnOnStove", "TurnOffStove"), (_COOKWARE,)),
    "TurnOnBlender": (Draw(("fruit",)),),
    "TurnOnToaster": (_SANDWICH_BREAD,),
}


def missing_draws(things: Collection[tuple[Category, Vec3]]) -> dict[str, tuple[Draw, ...]]:
    """Task -> its draws that none of the given objects suits; tasks that can be reset are left out.

    Args:
        things: category and size (along x, y and z, metres) of each object.
    """
    draws = {draw for wanted in TASK_DRAWS.values() for draw in wanted}
    lacking = {draw for draw in draws if not any(draw.suits(*thing) for thing in things)}
    found = {task: tuple(draw for draw in wanted if draw in lacking) for task, wanted in TASK_DRAWS.items()}
    return {task: wanted for task, wanted in sorted(found.items()) if wanted}


def categories_for(missing: Mapping[str, tuple[Draw, ...]], known: Collection[Category]) -> tuple[str, ...]:
    """Choose a few of the known categories whose objects suit all missing draws, sorted.

    Greedy: each choice is the category that suits most of the remaining draws; draws that no category suits are
    ignored.
    """
    left = {draw for draws in missing.values() for draw in draws}
    chosen: list[str] = []
    while left:
        met = {c.id: {draw for draw in left if draw.suits(c, _usual(c))} for c in known}
        best = max(sorted(met), key=lambda name: len(met[name]), default="")
        if not best or not met[best]:
            break
        chosen.append(best)
        left -= met[best]
    return tuple(sorted(chosen))


def _usual(category: Category) -> Vec3:
    x, y, z = (side.typical for side in category.extents)
    return (x, y, z)
