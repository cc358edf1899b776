"""The 65 atomic tasks of RoboCasa v1.0: the fixtures of a kitchen with which each can be done.

Ref: robocasa v1.0.1, ATOMIC_TASK_DATASETS and the tasks' own classes: what each asks for before it can be reset.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

from casa_assets.checks.design.robot import tasks
from casa_assets.checks.design.robot.placing import ABOVE_M, worktop_regions
from casa_assets.checks.design.robot.task_view import AtomicTask, TaskFinding, TaskView
from casa_assets.core.robocasa import MIN_SURFACE_M, PLATE_DEPTH_M, SHELF_HEIGHTS_M
from casa_assets.model.kitchen.floor import Fixture, FixtureRegion, Footprint, Role

BOARD_M = 0.6  # width and depth of the worktop that a cutting board and what lies around it want
_SLOTS = "(side[LR]_)?slot[LR]"  # regions of a toaster

Found = tuple[Fixture, ...]
Finding = Callable[[TaskView], tuple[Found, str]]


def _having(roles: Sequence[Role], joint: str, region: str, wants: str) -> Finding:
    """Fixtures of some roles with a joint and a region whose names match; an empty pattern asks for none."""

    def find(view: TaskView) -> tuple[Found, str]:
        return tuple(
            f
            for f in view.reached(*roles)
            if (not joint or any(re.fullmatch(joint, j.name) for j in f.joints))
            and (not region or any(re.fullmatch(region, r.name) for r in f.regions))
        ), wants

    return find


def _of_category(category: str, joint: str, wants: str) -> Finding:
    """Things on worktops of a category, with a joint whose name matches."""

    def find(view: TaskView) -> tuple[Found, str]:
        return tuple(
            f
            for f in view.facts.fixtures
            if f.category == category and (not joint or any(re.fullmatch(joint, j.name) for j in f.joints))
        ), wants

    return find


def _as_before(finding: Callable[[TaskView], TaskFinding]) -> Finding:
    """What a task of v0.2 looks for."""

    def find(view: TaskView) -> tuple[Found, str]:
        found = finding(view)
        return (() if found.wants else found.fixtures), found.wants

    return find


def _cabinets(view: TaskView) -> tuple[Found, str]:
    low, high = SHELF_HEIGHTS_M
    return tuple(
        f
        for f in tasks.uppers(view, (1, 2))
        if any(low <= r.bottom <= high for r in f.regions if re.fullmatch(r"level\d+|int", r.name))
    ), "a wall cabinet with doors and a shelf between 1.0 and 1.5 m"


def _worktops(side: float) -> Finding:
    """Worktops with a free rectangle of this width and depth, metres."""

    def find(view: TaskView) -> tuple[Found, str]:
        found = (f for f, region in worktop_regions(view.facts) if min(region.footprint.size) >= side)
        return tuple(dict.fromkeys(found)), f"a worktop of {side} x {side} m"

    return find


def _microwaves_with_worktop(view: TaskView) -> tuple[Found, str]:
    """Microwaves; where one stands on a worktop, RoboCasa has to find room for a plate before or beside it."""
    found, wants = _as_before(tasks.microwaves)(view)
    tops = [region for _, region in worktop_regions(view.facts)]
    roomy = tuple(f for f in found if all(_has_room(f, top.footprint) for top in tops if _is_on(f, top)))
    room = f"{MIN_SURFACE_M[0]} m of worktop beside a microwave, or {PLATE_DEPTH_M} m before it"
    return roomy, room if found else wants


def _is_on(fixture: Fixture, top: FixtureRegion) -> bool:
    across, before = top.footprint.to_local(fixture.footprint.center)
    width, depth = top.footprint.size
    return abs(fixture.bottom - top.bottom) < ABOVE_M / 2 and abs(across) < width / 2 and -depth < before < 0


def _has_room(fixture: Fixture, top: Footprint) -> bool:
    corners = [top.to_local(corner) for corner in fixture.footprint.corners]
    left, right = min(c[0] for c in corners), max(c[0] for c in corners)
    half = top.size[0] / 2
    return max(left + half, half - right) >= MIN_SURFACE_M[0] or -max(c[1] for c in corners) >= PLATE_DEPTH_M


def _toasters_for_bread(view: TaskView) -> tuple[Found, str]:
    """Toasters whose slots run from front to back, as RoboCasa turns bread that it puts into them."""
    found, wants = _TOASTER(view)
    slots = {f.name: [r.footprint.size for r in f.regions if re.fullmatch(_SLOTS, r.name)] for f in found}
    fitting = tuple(f for f in found if all(width < depth for width, depth in slots[f.name]))
    return fitting, "a toaster whose slots run from front to back" if found else wants


def _lidded_blenders(view: TaskView) -> tuple[Found, str]:
    """Blenders, where their lid is there: without it they are not turned on."""
    found, wants = _BLENDER(view)
    return (found if any(f.category == "blender_lid" for f in view.facts.fixtures) else ()), wants


_MICROWAVE = _having([Role.MICROWAVE], "microjoint", "tray", "a microwave with a door and a tray")
_FRIDGE = _having([Role.FRIDGE], ".*fridge.*door.*|.*door.*fridge.*", "", "a refrigerator with a door")
_FRIDGE_DRAWER = _having(
    [Role.FRIDGE], ".*fridge.*drawer.*|.*drawer.*fridge.*", ".*fridge.*drawer.*", "a drawer in the refrigerator"
)
_OVEN = _having([Role.OVEN], ".*door_joint", "rack[01]", "an oven beside a hob, with a rack")
_DISHWASHER = _having([Role.DISHWASHER], "door_joint", "rack1", "a dishwasher with an upper rack")
_TOASTER = _having([Role.TOASTER], ".*lever.*", _SLOTS, "a toaster with a lever and slots")
_TOASTER_OVEN = _of_category("toaster_oven", ".*door_joint", "a toaster oven")
_KETTLE = _of_category("kettle", "lid_joint", "an electric kettle with a lid")
_MIXER = _of_category("stand_mixer", "head_joint", "a stand mixer whose head tilts")
_BLENDER = _of_category("blender", "", "a blender with a lid")
_DRAWER = _as_before(tasks.drawers)
_STOVE = _as_before(lambda view: tasks.stove(view, False))
_STOVE_AND_COUNTER = _as_before(lambda view: tasks.stove(view, True))
_SINK = _as_before(lambda view: tasks.sink(view, tasks.GRASPED))
_COFFEE = _as_before(lambda view: tasks.coffee(view, True))

ATOMIC_TASKS: dict[str, Finding] = {
    **dict.fromkeys(("OpenCabinet", "CloseCabinet"), _cabinets),
    **dict.fromkeys(("OpenDrawer", "CloseDrawer", "PickPlaceCounterToDrawer", "PickPlaceDrawerToCounter"), _DRAWER),
    **dict.fromkeys(("OpenFridge", "CloseFridge"), _FRIDGE),
    **dict.fromkeys(("OpenFridgeDrawer", "CloseFridgeDrawer"), _FRIDGE_DRAWER),
    **dict.fromkeys(("PickPlaceFridgeShelfToDrawer", "PickPlaceFridgeDrawerToShelf"), _FRIDGE_DRAWER),
    **dict.fromkeys(("OpenOven", "CloseOven", "SlideOvenRack", "PickPlaceCounterToOven"), _OVEN),
    "PreheatOven": _having([Role.OVEN], "knob_temp_joint", "rack[01]", "an oven with a knob of its temperature"),
    **dict.fromkeys(("OpenDishwasher", "CloseDishwasher", "SlideDishwasherRack"), _DISHWASHER),
    **dict.fromkeys(("OpenMicrowave", "CloseMicrowave"), _MICROWAVE),
    "TurnOnMicrowave": _as_before(lambda view: tasks.heated(view, "start_button")),
    "TurnOffMicrowave": _as_before(lambda view: tasks.heated(view, "stop_button")),
    **dict.fromkeys(("PickPlaceCounterToMicrowave", "PickPlaceMicrowaveToCounter"), _microwaves_with_worktop),
    **dict.fromkeys(("TurnOnStove", "TurnOffStove", "LowerHeat"), _STOVE),
    **dict.fromkeys(("PickPlaceCounterToStove", "PickPlaceStoveToCounter"), _STOVE_AND_COUNTER),
    **dict.fromkeys(
        ("TurnOnSinkFaucet", "TurnOffSinkFaucet"), _as_before(lambda view: tasks.faucet(view, "handle_joint"))
    ),
    "TurnSinkSpout": _as_before(lambda view: tasks.faucet(view, "spout_joint")),
    "AdjustWaterTemperature": _as_before(lambda view: tasks.faucet(view, "handle_temp_joint")),
    **dict.fromkeys(("PickPlaceCounterToSink", "PickPlaceSinkToCounter"), _SINK),
    **dict.fromkeys(("StartCoffeeMachine", "CoffeeSetupMug", "CoffeeServeMug"), _COFFEE),
    "TurnOnToaster": _TOASTER,
    "PickPlaceToasterToCounter": _toasters_for_bread,
    **dict.fromkeys(("OpenToasterOvenDoor", "CloseToasterOvenDoor", "SlideToasterOvenRack"), _TOASTER_OVEN),
    **dict.fromkeys(("AdjustToasterOvenTemperature", "TurnOnToasterOven"), _TOASTER_OVEN),
    **dict.fromkeys(("PickPlaceCounterToToasterOven", "PickPlaceToasterOvenToCounter"), _TOASTER_OVEN),
    **dict.fromkeys(("TurnOnElectricKettle", "OpenElectricKettleLid", "CloseElectricKettleLid"), _KETTLE),
    **dict.fromkeys(("OpenStandMixerHead", "CloseStandMixerHead", "PickPlaceCounterToStandMixer"), _MIXER),
    **dict.fromkeys(("OpenBlenderLid", "CloseBlenderLid", "TurnOnBlender"), _lidded_blenders),
    "PickPlaceCounterToBlender": _BLENDER,
    **dict.fromkeys(("PickPlaceCounterToCabinet", "PickPlaceCabinetToCounter", "MakeIcedCoffee"), _cabinets),
    "CheesyBread": _worktops(BOARD_M),
    "PackDessert": _worktops(0.3),
    "NavigateKitchen": _as_before(tasks.drive),
}


def atomic_tasks(view: TaskView) -> tuple[AtomicTask, ...]:
    """Each task by its name in RoboCasa, in the order of their names."""
    out = []
    for name in sorted(ATOMIC_TASKS):
        fixtures, wants = ATOMIC_TASKS[name](view)
        out.append(AtomicTask(task=name, fixtures=tuple(f.name for f in fixtures), wants="" if fixtures else wants))
    return tuple(out)
