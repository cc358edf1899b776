"""Find parking places of a robot's base for each fixture, doors shut and each door open."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from casa_assets.checks.design.robot.floor_map import BASE_RADIUS_M, HANGING_M, OVERHEAD_M, FloorMap, toward
from casa_assets.core.rounding import decimals
from casa_assets.core.typing import Mask
from casa_assets.model.kitchen.floor import Fixture, FixtureJoint, KitchenFacts, ParkingPlace, ParkingSide, Role
from casa_assets.model.record import Vec2

# Ref: RoboCasa (robocasa/utils/env_utils.py) parks 0.20 m before fixtures and 0.30 m before housings and fridges.
GAP_M, TALL_GAP_M = 0.20, 0.30
TALL_UNIT_M = 1.5  # height from which a unit on the floor is a tall one
STEP_M = 0.05  # between the places that are tried to the left and right
ASIDE_M = 0.3  # that the base may stand beside the width of a fixture
LEAF_GAP_M = 0.04  # between the base and the side of an open leaf
PARKED_ROLES = (
    Role.SINK,
    Role.RANGE,
    Role.HOB,
    Role.OVEN,
    Role.MICROWAVE,
    Role.HOOD,
    Role.FRIDGE,
    Role.DISHWASHER,
    Role.COFFEE_MACHINE,
    Role.TOASTER,
    Role.CABINET,
    Role.DRAWERS,
    Role.SINK_BASE,
    Role.CORNER,
    Role.ISLAND,
    Role.PANTRY,
    Role.HOUSING,
    Role.UPPER,
    Role.SHELF,
)


@dataclass(frozen=True)
class ParkingPlaces:
    """Parking places of a kitchen.

    Attributes:
        shut: fixture -> its place while all is shut; None where it cannot be reached.
        open: (fixture, joint) -> its place while that joint's leaf stands open; None likewise.
    """

    shut: dict[str, ParkingPlace | None]
    open: dict[tuple[str, str], ParkingPlace | None]

    @property
    def every(self) -> tuple[ParkingPlace, ...]:
        """All places that there are, by fixture."""
        places = [*self.shut.values(), *self.open.values()]
        return tuple(p for p in places if p is not None)


def find_parking(facts: KitchenFacts, floor: FloorMap) -> ParkingPlaces:
    """Places for all fixtures that a robot works at."""
    shut: dict[str, ParkingPlace | None] = {}
    opened: dict[tuple[str, str], ParkingPlace | None] = {}
    for fixture in facts.with_role(*PARKED_ROLES):
        edge = front_of(facts, fixture) + (TALL_GAP_M if is_tall(facts, fixture) else GAP_M)
        shut[fixture.name] = _first(_in_front(fixture, edge), floor, floor.reached)
        for joint in fixture.joints:
            if joint.swept_area is None or joint.behind is not None:
                continue
            if joint.swept_area.bottom > OVERHEAD_M:
                place = shut[fixture.name]
                opened[fixture.name, joint.name] = place and place.replace(open_joint=joint.name)
                continue
            reached = floor.connected(floor.beside(joint.swept_area.open_outline))
            found = _first(_around(fixture, joint, edge), floor, reached)
            opened[fixture.name, joint.name] = found and found.replace(open_joint=joint.name)
    return ParkingPlaces(shut, opened)


def is_tall(facts: KitchenFacts, fixture: Fixture) -> bool:
    """True if a fixture stands in a unit that is higher than worktops."""
    run = facts.run(fixture.run)
    high = max((u.height for u in run.units if u.name == fixture.unit), default=0.0) if run else 0.0
    on_floor = fixture.bottom < HANGING_M and fixture.top > TALL_UNIT_M
    return fixture.role in (Role.FRIDGE, Role.PANTRY) or high > TALL_UNIT_M or on_floor


def front_of(facts: KitchenFacts, fixture: Fixture) -> float:
    """Distance before a fixture's own front at which the base has to stop: the edge of a worktop, say."""
    run = facts.run(fixture.run)
    if run is None:
        return 0.0
    u, v = run.to_local(fixture.footprint.at(0.0, 0.0))
    half = 0.45 * fixture.footprint.size[0]
    below = [n.front for n in run.units if n.left < u + half and n.right > u - half and n.kind != "gap"]
    return max([*below, v] if below else [run.depth_before, v]) - v


def _in_front(fixture: Fixture, edge: float) -> Iterator[ParkingPlace]:
    """Places where the base's rim is at `edge` metres before a fixture's front, the middle one first."""
    reach = fixture.footprint.size[0] / 2 + ASIDE_M
    for k in range(int(reach / STEP_M) + 1):
        for aside in (k * STEP_M, -k * STEP_M)[: 1 if k == 0 else 2]:
            yield _place(fixture, aside, edge + BASE_RADIUS_M, ParkingSide.FRONT)


def _place(
    fixture: Fixture, aside: float, before: float, stance: ParkingSide, look: Vec2 | None = None
) -> ParkingPlace:
    at = fixture.footprint.at(aside, before)
    x, y = fixture.footprint.front_axis
    yaw = math.atan2(-y, -x) if look is None else toward(at, look)
    return ParkingPlace(
        fixture=fixture.name,
        position=(round(at[0], 4), round(at[1], 4)),
        yaw=decimals(yaw, 4),
        side=stance,
        offset=round(aside, 4),
    )


def _around(fixture: Fixture, joint: FixtureJoint, edge: float) -> Iterator[ParkingPlace]:
    """Places before a fixture, then beside the open leaf, then behind it."""
    assert joint.swept_area is not None
    if not joint.swept_area.sweeps_front:
        yield from _in_front(fixture, edge)
    points = [fixture.footprint.to_local(p) for p in joint.swept_area.open_outline]
    left, right = min(p[0] for p in points), max(p[0] for p in points)
    out = max(p[1] for p in points)
    look = fixture.footprint.at((left + right) / 2, 0.0)
    for k in range(5):
        more = BASE_RADIUS_M + LEAF_GAP_M + k * STEP_M
        for aside, stance in ((right + more, ParkingSide.RIGHT), (left - more, ParkingSide.LEFT)):
            yield _place(fixture, aside, edge + BASE_RADIUS_M, stance, look)
    for k in range(5):
        yield _place(
            fixture, (left + right) / 2, max(out + GAP_M / 2, edge) + BASE_RADIUS_M + k * STEP_M, ParkingSide.BEHIND
        )


def _first(places: Iterator[ParkingPlace], floor: FloorMap, reached: Mask) -> ParkingPlace | None:
    return next((p for p in places if floor.holds(reached, p.position)), None)
