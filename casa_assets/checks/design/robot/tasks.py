"""The 25 atomic tasks of RoboCasa: what of a kitchen affords each, and how often things can be put for it.

Ref: robocasa/environments/kitchen/single_stage, v0.2: the tasks, what each looks for, and the sizes of what it puts.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from casa_assets.checks.design.robot.floor_map import FloorMap
from casa_assets.checks.design.robot.parking import ParkingPlaces
from casa_assets.checks.design.robot.placing import BoxSizes, PlacingZone, acceptance, free_area
from casa_assets.checks.design.robot.task_view import Afforded, Placing, TaskFinding, TaskView, doors, names
from casa_assets.core.sampling import rng_for
from casa_assets.model.asset.joint import JointKind
from casa_assets.model.kitchen.floor import Fixture, KitchenFacts, Role

SAMPLES = 200
FLOOR_RADIUS_M = 1.0  # around a parking place, in which floor is measured
GRASPED = BoxSizes(0.05, 0.12, 0.05, 0.18)
PLATE = BoxSizes(0.22, 0.26, 0.02, 0.03)
FOOD = BoxSizes(0.05, 0.15, 0.04, 0.10)
PAN = BoxSizes(0.18, 0.26, 0.05, 0.08)
MUG = BoxSizes(0.08, 0.11, 0.08, 0.11)
FLAT = BoxSizes(0.05, 0.10, 0.04, 0.10)
TOP_DRAWER_M = (0.7, 0.9)  # heights between which the middle of a top drawer lies
UPPER_BOTTOM_M = (1.0, 1.6)  # heights between which the underside of a wall cabinet lies
SPOUT_RAD = 0.52  # that a spout has to turn to either side: 30 degrees
MIN_DRIVE_M = 1.0  # between the start and the goal of a drive
# Roles of fixtures that a drive may lead to, where a kitchen has one of them.
DRIVE_GOALS = (
    Role.COFFEE_MACHINE,
    Role.TOASTER,
    Role.RANGE,
    Role.HOB,
    Role.SHELF,
    Role.MICROWAVE,
    Role.SINK,
    Role.HOOD,
    Role.OVEN,
    Role.FRIDGE,
    Role.DISHWASHER,
)


def uppers(view: TaskView, count: tuple[int, ...]) -> tuple[Fixture, ...]:
    """Wall cabinets of so many doors, at a height that an arm reaches."""
    found = view.reached(Role.UPPER)
    return tuple(f for f in found if UPPER_BOTTOM_M[0] <= f.bottom <= UPPER_BOTTOM_M[1] and len(doors(f)) in count)


def _cabinet(view: TaskView) -> TaskFinding:
    cabinets = uppers(view, (1, 2))
    zones = tuple(z for f in cabinets for z in view.inside(f, r"level\d+|int"))
    counter = view.counter(cabinets, 0.1)
    return TaskFinding(
        cabinets,
        joints=tuple(n for f in cabinets for n in names(f, [j.name for j in doors(f)])),
        regions=tuple(f"{z.fixture}__{z.region}" for z in zones),
        puts=(Placing(counter, GRASPED), Placing(zones, GRASPED)),
        counter=counter,
        wants="" if cabinets and zones else "a wall cabinet with doors and room inside, before which the base parks",
    )


def sink(view: TaskView, size: BoxSizes) -> TaskFinding:
    """Sinks with a basin, and the worktop beside them."""
    sinks = view.reached(Role.SINK)
    zones = tuple(z for f in sinks for z in view.inside(f, r"basin.*|int"))
    counter = view.counter(sinks)
    return TaskFinding(
        sinks,
        regions=tuple(f"{z.fixture}__{z.region}" for z in zones),
        puts=(Placing(counter, size), Placing(zones, GRASPED)),
        counter=counter,
        wants="" if zones else "a sink with a basin",
    )


def microwaves(view: TaskView) -> TaskFinding:
    """Microwaves with a door and a tray."""
    ovens = tuple(f for f in view.reached(Role.MICROWAVE) if f.joint("microjoint"))
    zones = tuple(z for f in ovens for z in view.inside(f, r"tray|int"))
    counter = view.counter(ovens)
    return TaskFinding(
        ovens,
        joints=tuple(f"{f.name}__microjoint" for f in ovens),
        regions=tuple(f"{z.fixture}__{z.region}" for z in zones),
        puts=(Placing(counter, PLATE), Placing(zones, PLATE)),
        counter=counter,
        wants="" if zones else "a microwave with a door and a tray",
    )


def _burners(fixture: Fixture) -> list[tuple[str, str, str]]:
    """Joint of the knob, site of the flame and place of the pan for each burner that has all three."""
    marks = {m.name for m in fixture.sites}
    found = []
    for joint in fixture.joints:
        match = re.fullmatch(r"knob_(.+)_joint", joint.name)
        if match and {f"burner_on_{match[1]}", f"burner_{match[1]}_place_site"} <= marks:
            found.append((joint.name, f"burner_on_{match[1]}", f"burner_{match[1]}_place_site"))
    return found


def stove(view: TaskView, counter_wanted: bool) -> TaskFinding:
    """Ranges and hobs with a knob, a flame and a place for a pan."""
    stoves = tuple(f for f in view.reached(Role.RANGE, Role.HOB) if _burners(f))
    pans = tuple(view.at(f, place, 0.10) for f in stoves for _, _, place in _burners(f))
    counter = view.counter(stoves) if counter_wanted else ()
    return TaskFinding(
        stoves,
        joints=tuple(n for f in stoves for n in names(f, [b[0] for b in _burners(f)])),
        sites=tuple(n for f in stoves for b in _burners(f) for n in names(f, b[1:])),
        puts=(*((Placing(counter, PLATE),) if counter_wanted else ()), Placing(pans, PAN)),
        counter=counter,
        wants="" if stoves else "a range or hob with a knob, a flame and a place for a pan",
    )


def _doors(view: TaskView, count: int) -> TaskFinding:
    cabinets = uppers(view, (count,))
    ovens = tuple(f for f in view.reached(Role.MICROWAVE) if f.joint("microjoint")) if count == 1 else ()
    every = (*cabinets, *ovens)
    zones = tuple(z for f in cabinets for z in view.inside(f, r"level\d+|int"))
    zones += tuple(z for f in ovens for z in view.inside(f, r"tray|int"))
    return TaskFinding(
        every,
        joints=tuple(n for f in every for n in names(f, [j.name for j in doors(f)])),
        regions=tuple(f"{z.fixture}__{z.region}" for z in zones),
        puts=(Placing(zones, GRASPED),),
        wants="" if every else f"a wall cabinet with {'one door' if count == 1 else 'two doors'}",
    )


def drawers(view: TaskView) -> TaskFinding:
    """Top drawers with free floor beside them."""
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
                joints += names(fixture, [joint.name])
                zones += inner
    return TaskFinding(
        tuple(dict.fromkeys(found)),
        joints=tuple(joints),
        regions=tuple(f"{z.fixture}__{z.region}" for z in zones),
        puts=(Placing(tuple(zones), FLAT),),
        wants="" if joints else "a top drawer with free floor to its left or right",
    )


def faucet(view: TaskView, joint: str) -> TaskFinding:
    """Sinks whose tap has a joint of that name."""
    sinks = tuple(
        f for f in view.reached(Role.SINK) if f.joint(joint) is not None and "water" in {m.name for m in f.sites}
    )
    if joint == "spout_joint":
        sinks = tuple(f for f in sinks if all(abs(end) >= SPOUT_RAD for end in _range(f, joint)))
    counter = view.counter(sinks)
    return TaskFinding(
        sinks,
        joints=tuple(f"{f.name}__{joint}" for f in sinks),
        sites=tuple(f"{f.name}__water" for f in sinks),
        puts=(Placing(counter, GRASPED),),
        counter=counter,
        wants="" if sinks else f"a sink with {joint} and a stream of water",
    )


def _range(fixture: Fixture, name: str) -> tuple[float, float]:
    joint = fixture.joint(name)
    return (0.0, 0.0) if joint is None else joint.range


def _pressed(view: TaskView, role: Role, button: str) -> TaskFinding:
    found = tuple(f for f in view.reached(role) if any(button in b.name for b in f.buttons))
    joints = tuple(n for f in found for n in names(f, [j.name for j in f.joints if button in j.name]))
    return TaskFinding(found, joints=joints, wants="" if found else f"a {role.value.replace('_', ' ')} with a {button}")


def coffee(view: TaskView, put_down: bool) -> TaskFinding:
    """Coffee machines with a start button and a place for a mug."""
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


def heated(view: TaskView, button: str) -> TaskFinding:
    """Microwaves with a button of that name."""
    pressed, ovens = _pressed(view, Role.MICROWAVE, button), microwaves(view)
    return TaskFinding(
        pressed.fixtures, pressed.joints, regions=ovens.regions, puts=ovens.puts[1:], wants=pressed.wants or ovens.wants
    )


def drive(view: TaskView) -> TaskFinding:
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


TASKS: tuple[tuple[str, Callable[[TaskView], TaskFinding]], ...] = (
    ("pnp_counter_to_cab", _cabinet),
    ("pnp_cab_to_counter", _cabinet),
    ("pnp_counter_to_sink", lambda view: sink(view, GRASPED)),
    ("pnp_sink_to_counter", lambda view: sink(view, PLATE)),
    ("pnp_counter_to_microwave", microwaves),
    ("pnp_microwave_to_counter", microwaves),
    ("pnp_counter_to_stove", lambda view: stove(view, True)),
    ("pnp_stove_to_counter", lambda view: stove(view, True)),
    ("open_single_door", lambda view: _doors(view, 1)),
    ("close_single_door", lambda view: _doors(view, 1)),
    ("open_double_door", lambda view: _doors(view, 2)),
    ("close_double_door", lambda view: _doors(view, 2)),
    ("open_drawer", drawers),
    ("close_drawer", drawers),
    ("turn_on_stove", lambda view: stove(view, False)),
    ("turn_off_stove", lambda view: stove(view, False)),
    ("turn_on_sink_faucet", lambda view: faucet(view, "handle_joint")),
    ("turn_off_sink_faucet", lambda view: faucet(view, "handle_joint")),
    ("turn_sink_spout", lambda view: faucet(view, "spout_joint")),
    ("coffee_press_button", lambda view: coffee(view, False)),
    ("turn_on_microwave", lambda view: heated(view, "start_button")),
    ("turn_off_microwave", lambda view: heated(view, "stop_button")),
    ("coffee_setup_mug", lambda view: coffee(view, True)),
    ("coffee_serve_mug", lambda view: coffee(view, True)),
    ("navigate_kitchen", drive),
)


def afforded(facts: KitchenFacts, floor: FloorMap, parking: ParkingPlaces, seed: int) -> tuple[Afforded, ...]:
    """Result for each of the tasks, in order."""
    view = TaskView(facts, floor, parking)
    return tuple(_afforded(view, k + 1, name, find(view), seed) for k, (name, find) in enumerate(TASKS))


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
        joints=found.joints,
        sites=found.sites,
        regions=found.regions,
        counter_m2=round(free_area(found.counter), 3),
        floor_m2=round(max((view.floor.area(p.position, FLOOR_RADIUS_M) for p in places), default=0.0), 3),
        rate=None if found.wants or not rates else round(min(rates), 4),
        tightest=", ".join(dict.fromkeys(f"{z.fixture}__{z.region}" for z in zones)),
        wants=found.wants,
    )
