"""Queries of tasks on a kitchen: reachable fixtures, free worktop beside them, zones to put things."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from casa_assets.checks.design.robot.floor_map import BASE_RADIUS_M, FloorMap
from casa_assets.checks.design.robot.parking import ParkingPlaces, front_of
from casa_assets.checks.design.robot.placing import (
    BoxSizes,
    PlacingZone,
    WorldBox,
    box_around,
    on_worktops,
    shoulders,
    worktops_near,
)
from casa_assets.model.asset.joint import JointKind
from casa_assets.model.kitchen.floor import Fixture, FixtureJoint, KitchenFacts, Role
from casa_assets.model.record import Record

BESIDE_M = 0.6  # beside a fixture, within which its worktop begins


class Afforded(Record):
    """Fixtures, joints, sites and regions that a kitchen offers for a task.

    Attributes:
        number, task: of the table. fixtures, joints, sites, regions: that it can be done with, `<fixture>__<name>`.
        counter_m2: free worktop beside them. floor_m2: floor around their parking places that the base gets to.
        rate: share of drawn boxes that could be put, the least of all that the task puts; None where nothing is put.
        tightest: where that is.
        wants: what is missing, empty where nothing is.
    """

    number: int
    task: str
    fixtures: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    sites: tuple[str, ...] = ()
    regions: tuple[str, ...] = ()
    counter_m2: float = 0.0
    floor_m2: float = 0.0
    rate: float | None = None
    tightest: str = ""
    wants: str = ""


class AtomicTask(Record):
    """Whether a task of RoboCasa v1.0 can be done in a kitchen.

    Attributes:
        task: name of its class. fixtures: with which it can be done. wants: what is missing, empty where nothing is.
    """

    task: str
    fixtures: tuple[str, ...] = ()
    wants: str = ""


@dataclass(frozen=True)
class Placing:
    """Boxes that a task puts into zones."""

    zones: tuple[PlacingZone, ...]
    size: BoxSizes


@dataclass(frozen=True)
class TaskFinding:
    """Intermediate result for a task, before boxes are sampled.

    Attributes:
        fixtures: with which it can be done. joints, sites, regions: names. puts: what is put where.
        counter: worktops beside them. wants: what is missing.
    """

    fixtures: tuple[Fixture, ...]
    joints: tuple[str, ...] = ()
    sites: tuple[str, ...] = ()
    regions: tuple[str, ...] = ()
    puts: tuple[Placing, ...] = ()
    counter: tuple[PlacingZone, ...] = ()
    wants: str = ""


class TaskView:
    """A kitchen with the queries that tasks make."""

    def __init__(self, facts: KitchenFacts, floor: FloorMap, parking: ParkingPlaces) -> None:
        self.facts, self.floor, self.parking = facts, floor, parking
        self.obstacles = tuple(on_worktops(facts))
        self.everywhere = shoulders(p for p in parking.shut.values() if p is not None)

    def reached(self, *roles: Role) -> tuple[Fixture, ...]:
        """Fixtures of these roles before which the base parks."""
        return tuple(f for f in self.facts.with_role(*roles) if self.parking.shut.get(f.name) is not None)

    def counter(self, fixtures: Sequence[Fixture], reach: float = BESIDE_M) -> tuple[PlacingZone, ...]:
        """Free worktops beside fixtures, each once for each of them."""
        return tuple(
            PlacingZone(top, region, span, self.obstacles, self.everywhere)
            for f in fixtures
            for top, region, span in worktops_near(self.facts, f, reach)
        )

    def inside(self, fixture: Fixture, pattern: str) -> tuple[PlacingZone, ...]:
        """Regions of a fixture, as an arm reaches them from where the base parks for it."""
        place = self.parking.shut.get(fixture.name)
        points = shoulders([place] if place is not None else [])
        return tuple(
            PlacingZone(fixture.name, v.name, box_around(v.footprint, v.bottom, v.top), (), points)
            for v in fixture.regions
            if re.fullmatch(pattern, v.name)
        )

    def at(self, fixture: Fixture, site: str, side: float) -> PlacingZone:
        """A square around a site, in which the middle of a thing has to lie."""
        x, y, z = next(m.position for m in fixture.sites if m.name == site)
        place = self.parking.shut.get(fixture.name)
        points = shoulders([place] if place is not None else [])
        span = WorldBox(x - side / 2, y - side / 2, x + side / 2, y + side / 2, z, z + 0.5)
        return PlacingZone(fixture.name, site, span, (), points, center_only=True)

    def stands_beside(self, fixture: Fixture, joint: FixtureJoint) -> bool:
        """True if the base gets to the left or right of a fixture while its drawer is open."""
        if joint.swept_area is None:
            return False
        reached = self.floor.connected(self.floor.beside(joint.swept_area.open_outline))
        before = front_of(self.facts, fixture) + 0.2 + BASE_RADIUS_M
        aside = fixture.footprint.size[0] / 2 + BASE_RADIUS_M + 0.05
        return any(self.floor.holds(reached, fixture.footprint.at(s * aside, before)) for s in (1.0, -1.0))


def names(fixture: Fixture, found: Sequence[str]) -> tuple[str, ...]:
    """Names as scene files have them."""
    return tuple(f"{fixture.name}__{n}" for n in found)


def doors(fixture: Fixture) -> tuple[FixtureJoint, ...]:
    """Upright doors of a fixture."""
    return tuple(
        j
        for j in fixture.joints
        if j.kind is JointKind.HINGE and j.swept_area is not None and not j.swept_area.sweeps_front
    )
