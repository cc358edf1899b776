"""The atomic tasks of RoboCasa, 65 of v1.0 and 25 of v0.2: what of a kitchen affords each.

For those of v0.2 also how often things can be put for it.

Ref: robocasa v1.0.1, ATOMIC_TASK_DATASETS and the tasks' own classes: what each asks for before it can be reset.
Ref: robocasa/environments/kitchen/single_stage, v0.2: the tasks, what each looks for, and the sizes of what it puts.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from casa_assets.checks.design.floor_map import FloorMap, ParkingPlaces
from casa_assets.checks.design.task_view import (
    ABOVE_M,
    Afforded,
    AtomicTask,
    BoxSizes,
    Placing,
    PlacingZone,
    TaskFinding,
    TaskView,
    acceptance,
    doors,
    free_area,
    worktop_regions,
)
from casa_assets.core.numeric import rng_for
from casa_assets.model.asset.parts import JointKind
from casa_assets.model.kitchen.floor import Fixture, FixtureRegion, KitchenFacts, Role
from casa_assets.model.registry.contract import MIN_SURFACE_M, PLATE_DEPTH_M, SHELF_HEIGHTS_M

SAMPLES = 200
FLOOR_RADIUS_M = 1.0  # around a parking place, in which floor is measured
GRASPED = BoxSizes(0.05, 0.12, 0.05, 0.18)
PLATE = BoxSizes(0.22, 0.26, 0.02, 0.03)
PAN = BoxSizes(0.18, 0.26, 0.05, 0.08)
MUG = BoxSizes(0.08, 0.11, 0.08, 0.11)
FLAT = BoxSizes(0.05, 0.10, 0.04, 0.10)
TOP_DRAWER_M = (0.7, 0.9)  # heights between which the middle of a top drawer lies
UPPER_BOTTOM_M = (1.0, 1.6)  # heights between which the underside of a wall cabinet lies
SPOUT_RAD = 0.52  # that a spout has to turn to either side: 30 degrees
MIN_DRIVE_M = 1.0  # between the start and the goal of a drive
BOARD_M = 0.6  # width and depth of the worktop that a cutting board and what lies around it want
_SLOTS = "(side[LR]_)?slot[LR]"  # regions of a toaster
# Roles of fixtures that a drive may lead to, where a kitchen has one of them.
DRIVE_GOALS = (
    *(Role.COFFEE_MACHINE, Role.TOASTER, Role.RANGE, Role.HOB, Role.SHELF, Role.MICROWAVE, Role.SINK, Role.HOOD),
    *(Role.OVEN, Role.FRIDGE, Role.DISHWASHER),
)
Finding = Callable[[TaskView], TaskFinding]


def _uppers(view: TaskView, count: tuple[int, ...]) -> tuple[Fixture, ...]:
    """Wall cabinets with one of the given numbers of doors, at a height that an arm reaches."""
    found = view.reached(Role.UPPER)
    return tuple(f for f in found if UPPER_BOTTOM_M[0] <= f.bottom <= UPPER_BOTTOM_M[1] and len(doors(f)) in count)


def _regions(zones: Sequence[PlacingZone]) -> tuple[str, ...]:
    return tuple(f"{zone.fixture}__{zone.region}" for zone in zones)


def _door_names(fixtures: Sequence[Fixture]) -> tuple[str, ...]:
    return tuple(f"{f.name}__{joint.name}" for f in fixtures for joint in doors(f))


def _held_inside(
    view: TaskView, fixtures: tuple[Fixture, ...], pattern: str, sizes: tuple[BoxSizes, BoxSizes], wants: str
) -> TaskFinding:
    """Fixtures with regions that match, where things are put, from and to the worktop next to them."""
    zones = tuple(z for f in fixtures for z in view.inside(f, pattern))
    counter = view.counter(fixtures)
    puts = (Placing(counter, sizes[0]), Placing(zones, sizes[1]))
    return TaskFinding(fixtures, regions=_regions(zones), puts=puts, counter=counter, wants="" if zones else wants)


def _cabinet(view: TaskView) -> TaskFinding:
    cabinets = _uppers(view, (1, 2))
    zones = tuple(z for f in cabinets for z in view.inside(f, r"level\d+|int"))
    counter = view.counter(cabinets, 0.1)
    return TaskFinding(
        cabinets,
        joints=_door_names(cabinets),
        regions=_regions(zones),
        puts=(Placing(counter, GRASPED), Placing(zones, GRASPED)),
        counter=counter,
        wants="" if cabinets and zones else "a wall cabinet with doors and room inside, before which the base parks",
    )


def _sink(view: TaskView, size: BoxSizes) -> TaskFinding:
    return _held_inside(view, view.reached(Role.SINK), r"basin.*|int", (size, GRASPED), "a sink with a basin")


def _microwaves(view: TaskView) -> TaskFinding:
    ovens = tuple(f for f in view.reached(Role.MICROWAVE) if f.joint("microjoint"))
    found = _held_inside(view, ovens, r"tray|int", (PLATE, PLATE), "a microwave with a door and a tray")
    return replace(found, joints=tuple(f"{f.name}__microjoint" for f in ovens))


def _burners(fixture: Fixture) -> list[tuple[str, str, str]]:
    """Joint of the knob, site of the flame and place of the pan for each burner that has all three."""
    marks = {m.name for m in fixture.sites}
    found = []
    for joint in fixture.joints:
        match = re.fullmatch(r"knob_(.+)_joint", joint.name)
        if match and {f"burner_on_{match[1]}", f"burner_{match[1]}_place_site"} <= marks:
            found.append((joint.name, f"burner_on_{match[1]}", f"burner_{match[1]}_place_site"))
    return found


def _stove(view: TaskView, counter_wanted: bool) -> TaskFinding:
    stoves = tuple(f for f in view.reached(Role.RANGE, Role.HOB) if _burners(f))
    burners = [(f, *burner) for f in stoves for burner in _burners(f)]
    pans = tuple(view.at(f, place, 0.10) for f, _, _, place in burners)
    counter = view.counter(stoves) if counter_wanted else ()
    return TaskFinding(
        stoves,
        joints=tuple(f"{f.name}__{knob}" for f, knob, _, _ in burners),
        sites=tuple(f"{f.name}__{site}" for f, _, *sites in burners for site in sites),
        puts=(*((Placing(counter, PLATE),) if counter_wanted else ()), Placing(pans, PAN)),
        counter=counter,
        wants="" if stoves else "a range or hob with a knob, a flame and a place for a pan",
    )


def _doors(view: TaskView, count: int) -> TaskFinding:
    cabinets = _uppers(view, (count,))
    ovens = tuple(f for f in view.reached(Role.MICROWAVE) if f.joint("microjoint")) if count == 1 else ()
    every = (*cabinets, *ovens)
    zones = tuple(z for f in cabinets for z in view.inside(f, r"level\d+|int"))
    zones += tuple(z for f in ovens for z in view.inside(f, r"tray|int"))
    return TaskFinding(
        every,
        joints=_door_names(every),
        regions=_regions(zones),
        puts=(Placing(zones, GRASPED),),
        wants="" if every else f"a wall cabinet with {'one door' if count == 1 else 'two doors'}",
    )


def _drawers(view: TaskView) -> TaskFinding:
    """Top drawers with free floor next to them."""
    found: list[Fixture] = []
    joints: list[str] = []
    zones: list[PlacingZone] = []
    for fixture in view.reached(Role.DRAWERS, Role.CABINET, Role.ISLAND):
        for joint in fixture.joints:
            height = None if joint.grip_point is None else joint.grip_point[2]
            if joint.kind is not JointKind.SLIDE or height is None or not TOP_DRAWER_M[0] <= height <= TOP_DRAWER_M[1]:
                continue
            if not view.stands_beside(fixture, joint):
                continue
            inner = view.inside(fixture, re.sub(r"_?slidejoint$|_joint$", "", joint.name) + r"(_int)?|int")
            if inner:
                found.append(fixture)
                joints.append(f"{fixture.name}__{joint.name}")
                zones += inner
    return TaskFinding(
        tuple(dict.fromkeys(found)),
        joints=tuple(joints),
        regions=_regions(zones),
        puts=(Placing(tuple(zones), FLAT),),
        wants="" if joints else "a top drawer with free floor to its left or right",
    )


def _faucet(view: TaskView, joint: str) -> TaskFinding:
    sinks = tuple(
        f for f in view.reached(Role.SINK) if f.joint(joint) is not None and "water" in {m.name for m in f.sites}
    )
    if joint == "spout_joint":
        ranges = {f.name: j.range for f in sinks if (j := f.joint(joint)) is not None}
        sinks = tuple(f for f in sinks if all(abs(end) >= SPOUT_RAD for end in ranges[f.name]))
    counter = view.counter(sinks)
    return TaskFinding(
        sinks,
        joints=tuple(f"{f.name}__{joint}" for f in sinks),
        sites=tuple(f"{f.name}__water" for f in sinks),
        puts=(Placing(counter, GRASPED),),
        counter=counter,
        wants="" if sinks else f"a sink with {joint} and a stream of water",
    )


def _pressed(view: TaskView, role: Role, button: str) -> TaskFinding:
    found = tuple(f for f in view.reached(role) if any(button in b.name for b in f.buttons))
    joints = tuple(f"{f.name}__{j.name}" for f in found for j in f.joints if button in j.name)
    return TaskFinding(found, joints=joints, wants="" if found else f"a {role.value.replace('_', ' ')} with a {button}")


def _coffee(view: TaskView, put_down: bool) -> TaskFinding:
    place = "receptacle_place_site"
    pressed = _pressed(view, Role.COFFEE_MACHINE, "start_button")
    found = tuple(f for f in pressed.fixtures if place in {m.name for m in f.sites})
    counter = view.counter(found, 0.35)
    zones = tuple(view.at(f, place, 0.02) for f in found)
    return TaskFinding(
        found,
        joints=pressed.joints,
        sites=tuple(f"{f.name}__{place}" for f in found),
        puts=(Placing(zones, MUG), *((Placing(counter, MUG),) if put_down else ())),
        counter=counter,
        wants="" if found else "a coffee machine with a start button and a place for a mug",
    )


def _heated(view: TaskView, button: str) -> TaskFinding:
    pressed, ovens = _pressed(view, Role.MICROWAVE, button), _microwaves(view)
    return TaskFinding(
        pressed.fixtures, pressed.joints, regions=ovens.regions, puts=ovens.puts[1:], wants=pressed.wants or ovens.wants
    )


def _drive(view: TaskView) -> TaskFinding:
    """Fixtures that there are once, and far enough from another to drive there."""
    once = [f for role in DRIVE_GOALS if len(found := view.facts.with_role(role)) == 1 for f in found]
    places = [p for p in view.parking.shut.values() if p is not None]
    aims = []
    for f in once:
        aim = view.parking.shut.get(f.name)
        far = [p for p in places if aim and abs(complex(*p.position) - complex(*aim.position)) > MIN_DRIVE_M]
        if far:
            aims.append(f)
    return TaskFinding(tuple(aims), wants="" if aims else "a thing that there is once, more than 1 m from another")


def _with(found: tuple[Fixture, ...], wants: str) -> TaskFinding:
    """Fixtures with which a task can be done, or, if there are no such fixtures, what it wants."""
    return TaskFinding(found, wants="" if found else wants)


@dataclass(frozen=True)
class _Having:
    """Fixtures of a role or a category with a joint and a region whose names match; an empty pattern asks for none."""

    kind: Role | str
    joint: str
    region: str
    wants: str

    def __call__(self, view: TaskView) -> TaskFinding:
        of_kind = view.reached(self.kind) if isinstance(self.kind, Role) else view.facts.fixtures
        found = [f for f in of_kind if self.kind in (f.role, f.category)]
        jointed = [f for f in found if not self.joint or any(re.fullmatch(self.joint, j.name) for j in f.joints)]
        return _with(
            tuple(f for f in jointed if not self.region or any(re.fullmatch(self.region, r.name) for r in f.regions)),
            self.wants,
        )


def _cabinets_with_shelves(view: TaskView) -> TaskFinding:
    """Wall cabinets with a shelf where RoboCasa v1.0 looks for one."""
    low, high = SHELF_HEIGHTS_M
    cabinets = _uppers(view, (1, 2))
    levels = {f.name: [r for r in f.regions if re.fullmatch(r"level\d+|int", r.name)] for f in cabinets}
    found = tuple(f for f in cabinets if any(low <= level.bottom <= high for level in levels[f.name]))
    return _with(found, "a wall cabinet with doors and a shelf between 1.0 and 1.5 m")


def _worktops(view: TaskView, side: float) -> TaskFinding:
    """Worktops with a free rectangle of this width and depth, metres."""
    found = (f for f, region in worktop_regions(view.facts) if min(region.footprint.size) >= side)
    return _with(tuple(dict.fromkeys(found)), f"a worktop of {side} x {side} m")


def _microwaves_with_worktop(view: TaskView) -> TaskFinding:
    """Microwaves; if one is on a worktop, RoboCasa has to find room for a plate in front of or next to it."""
    if (found := _microwaves(view)).wants:
        return found
    tops = [region for _, region in worktop_regions(view.facts)]
    roomy = tuple(f for f in found.fixtures if all(_has_room(f, top) for top in tops))
    return _with(roomy, f"{MIN_SURFACE_M[0]} m of worktop beside a microwave, or {PLATE_DEPTH_M} m before it")


def _has_room(fixture: Fixture, worktop: FixtureRegion) -> bool:
    """True if there is room beside or before a fixture on a worktop, or it is not on it."""
    top = worktop.footprint
    across, before = top.to_local(fixture.footprint.center)
    half = top.size[0] / 2
    if abs(fixture.bottom - worktop.bottom) >= ABOVE_M / 2 or abs(across) >= half or not -top.size[1] < before < 0:
        return True
    corners = [top.to_local(corner) for corner in fixture.footprint.corners]
    left, right = min(c[0] for c in corners), max(c[0] for c in corners)
    return max(left + half, half - right) >= MIN_SURFACE_M[0] or -max(c[1] for c in corners) >= PLATE_DEPTH_M


_TOASTER = _Having(Role.TOASTER, ".*lever.*", _SLOTS, "a toaster with a lever and slots")
_BLENDER = _Having("blender", "", "", "a blender with a lid")


def _toasters_for_bread(view: TaskView) -> TaskFinding:
    """Toasters whose slots run from front to back, as RoboCasa turns bread that it puts into them."""
    if (found := _TOASTER(view)).wants:
        return found
    slots = {f.name: [r.footprint.size for r in f.regions if re.fullmatch(_SLOTS, r.name)] for f in found.fixtures}
    fitting = tuple(f for f in found.fixtures if all(width < depth for width, depth in slots[f.name]))
    return _with(fitting, "a toaster whose slots run from front to back")


def _lidded_blenders(view: TaskView) -> TaskFinding:
    """Blenders, where their lid is there: without it they are not turned on."""
    has_lid = any(f.category == "blender_lid" for f in view.facts.fixtures)
    return _with(_BLENDER(view).fixtures if has_lid else (), "a blender with a lid")


@dataclass(frozen=True)
class Task:
    """Tasks of RoboCasa with the same requirements: classes of v1.0, and number -> name of those of v0.2."""

    find: Finding
    names: str = ""
    before: Mapping[int, str] = field(default_factory=dict)


# fmt: off
TASKS = (
    Task(_cabinet, before={1: "pnp_counter_to_cab", 2: "pnp_cab_to_counter"}),
    Task(_cabinets_with_shelves,
         "OpenCabinet CloseCabinet PickPlaceCounterToCabinet PickPlaceCabinetToCounter MakeIcedCoffee"),
    Task(lambda view: _doors(view, 1), before={9: "open_single_door", 10: "close_single_door"}),
    Task(lambda view: _doors(view, 2), before={11: "open_double_door", 12: "close_double_door"}),
    Task(_drawers, "OpenDrawer CloseDrawer PickPlaceCounterToDrawer PickPlaceDrawerToCounter",
         {13: "open_drawer", 14: "close_drawer"}),
    Task(lambda view: _sink(view, GRASPED), "PickPlaceCounterToSink PickPlaceSinkToCounter",
         {3: "pnp_counter_to_sink"}),
    Task(lambda view: _sink(view, PLATE), before={4: "pnp_sink_to_counter"}),
    Task(lambda view: _faucet(view, "handle_joint"), "TurnOnSinkFaucet TurnOffSinkFaucet",
         {17: "turn_on_sink_faucet", 18: "turn_off_sink_faucet"}),
    Task(lambda view: _faucet(view, "spout_joint"), "TurnSinkSpout", {19: "turn_sink_spout"}),
    Task(lambda view: _faucet(view, "handle_temp_joint"), "AdjustWaterTemperature"),
    Task(_Having(Role.MICROWAVE, "microjoint", "tray", "a microwave with a door and a tray"),
         "OpenMicrowave CloseMicrowave"),
    Task(_microwaves, before={5: "pnp_counter_to_microwave", 6: "pnp_microwave_to_counter"}),
    Task(_microwaves_with_worktop, "PickPlaceCounterToMicrowave PickPlaceMicrowaveToCounter"),
    Task(lambda view: _heated(view, "start_button"), "TurnOnMicrowave", {21: "turn_on_microwave"}),
    Task(lambda view: _heated(view, "stop_button"), "TurnOffMicrowave", {22: "turn_off_microwave"}),
    Task(lambda view: _stove(view, True), "PickPlaceCounterToStove PickPlaceStoveToCounter",
         {7: "pnp_counter_to_stove", 8: "pnp_stove_to_counter"}),
    Task(lambda view: _stove(view, False), "TurnOnStove TurnOffStove LowerHeat",
         {15: "turn_on_stove", 16: "turn_off_stove"}),
    Task(_Having(Role.OVEN, ".*door_joint", "rack[01]", "an oven beside a hob, with a rack"),
         "OpenOven CloseOven SlideOvenRack PickPlaceCounterToOven"),
    Task(_Having(Role.OVEN, "knob_temp_joint", "rack[01]", "an oven with a knob of its temperature"), "PreheatOven"),
    Task(_Having(Role.FRIDGE, ".*fridge.*door.*|.*door.*fridge.*", "", "a refrigerator with a door"),
         "OpenFridge CloseFridge"),
    Task(_Having(Role.FRIDGE, ".*fridge.*drawer.*|.*drawer.*fridge.*", ".*fridge.*drawer.*",
                 "a drawer in the refrigerator"),
         "OpenFridgeDrawer CloseFridgeDrawer PickPlaceFridgeShelfToDrawer PickPlaceFridgeDrawerToShelf"),
    Task(_Having(Role.DISHWASHER, "door_joint", "rack1", "a dishwasher with an upper rack"),
         "OpenDishwasher CloseDishwasher SlideDishwasherRack"),
    Task(lambda view: _coffee(view, False), before={20: "coffee_press_button"}),
    Task(lambda view: _coffee(view, True), "StartCoffeeMachine CoffeeSetupMug CoffeeServeMug",
         {23: "coffee_setup_mug", 24: "coffee_serve_mug"}),
    Task(_TOASTER, "TurnOnToaster"),
    Task(_toasters_for_bread, "PickPlaceToasterToCounter"),
    Task(_Having("toaster_oven", ".*door_joint", "", "a toaster oven"),
         "OpenToasterOvenDoor CloseToasterOvenDoor SlideToasterOvenRack AdjustToasterOvenTemperature "
         "TurnOnToasterOven PickPlaceCounterToToasterOven PickPlaceToasterOvenToCounter"),
    Task(_Having("kettle", "lid_joint", "", "an electric kettle with a lid"),
         "TurnOnElectricKettle OpenElectricKettleLid CloseElectricKettleLid"),
    Task(_Having("stand_mixer", "head_joint", "", "a stand mixer whose head tilts"),
         "OpenStandMixerHead CloseStandMixerHead PickPlaceCounterToStandMixer"),
    Task(_lidded_blenders, "OpenBlenderLid CloseBlenderLid TurnOnBlender"),
    Task(_BLENDER, "PickPlaceCounterToBlender"),
    Task(lambda view: _worktops(view, BOARD_M), "CheesyBread"),
    Task(lambda view: _worktops(view, 0.3), "PackDessert"),
    Task(_drive, "NavigateKitchen", {25: "navigate_kitchen"}),
)
# fmt: on
ATOMIC_TASKS = tuple(sorted(name for task in TASKS for name in task.names.split()))  # of v1.0


def afforded(facts: KitchenFacts, floor: FloorMap, parking: ParkingPlaces, seed: int) -> tuple[Afforded, ...]:
    """Result for each of the tasks of v0.2, in the order of their numbers."""
    view = TaskView(facts, floor, parking)
    found = {k: (name, row.find) for row in TASKS for k, name in row.before.items()}
    return tuple(_afforded(view, k, found[k][0], found[k][1](view), seed) for k in sorted(found))


def atomic_tasks(view: TaskView) -> tuple[AtomicTask, ...]:
    """Result for each of the tasks of v1.0, in the order of their names."""
    out: dict[str, AtomicTask] = {}
    for row in TASKS:
        found = row.find(view) if row.names else TaskFinding(())
        fixtures = () if found.wants else tuple(f.name for f in found.fixtures)
        out |= {name: AtomicTask(task=name, fixtures=fixtures, wants=found.wants) for name in row.names.split()}
    return tuple(out[name] for name in ATOMIC_TASKS)


def _afforded(view: TaskView, number: int, name: str, found: TaskFinding, seed: int) -> Afforded:
    rates = [
        acceptance(put.zones, put.size, SAMPLES, rng_for(seed, f"tasks/{view.facts.id}/{name}/{k}"))
        for k, put in enumerate(found.puts)
    ]
    tightest = min(range(len(rates)), key=rates.__getitem__, default=None)
    zones = () if tightest is None else found.puts[tightest].zones
    places = [p for f in found.fixtures if (p := view.parking.shut.get(f.name)) is not None]
    return Afforded(
        number=number,
        task=name,
        fixtures=tuple(f.name for f in found.fixtures),
        **{name: getattr(found, name) for name in ("joints", "sites", "regions", "wants")},
        counter_m2=round(free_area(found.counter), 3),
        floor_m2=round(max((view.floor.area(p.position, FLOOR_RADIUS_M) for p in places), default=0.0), 3),
        rate=None if found.wants or not rates else round(min(rates), 4),
        tightest=", ".join(dict.fromkeys(_regions(zones))),
    )
