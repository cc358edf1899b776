"""Queries of tasks on a kitchen: reachable fixtures, free worktop, and zones in which boxes are placed."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.checks.design.floor_map import BASE_RADIUS_M, FloorMap, ParkingPlaces, front_of
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.parts import JointKind
from casa_assets.model.kitchen.floor import (
    Fixture,
    FixtureJoint,
    FixtureRegion,
    Footprint,
    KitchenFacts,
    ParkingPlace,
    Role,
)
from casa_assets.model.record import Record, Vec2, Vec3

ARM_REACH_M = 0.8  # from the front of the base, seen from above
MIN_WORK_HEIGHT_M, MAX_WORK_HEIGHT_M = 0.3, 1.9
ROUNDING_M = 1e-9
# Heights below and above a worktop between which the foot of what stands on it is, metres.
SUNK_M, ABOVE_M = 0.1, 0.45
BESIDE_M = 0.6  # beside a fixture, within which its worktop begins


@dataclass(frozen=True)
class WorldBox:
    """An upright box along the axes of the world, metres."""

    x0: float
    y0: float
    x1: float
    y1: float
    z0: float
    z1: float

    @property
    def area(self) -> float:
        """Square metres, seen from above."""
        return max(0.0, self.x1 - self.x0) * max(0.0, self.y1 - self.y0)

    def intersection(self, other: WorldBox) -> WorldBox:
        """Intersection of two boxes; empty where they are apart."""
        x0, y0, z0 = max(self.x0, other.x0), max(self.y0, other.y0), max(self.z0, other.z0)
        return WorldBox(x0, y0, min(self.x1, other.x1), min(self.y1, other.y1), z0, min(self.z1, other.z1))


@dataclass(frozen=True)
class BoxSizes:
    """Range of the width and depth of boxes that are placed, and range of their height, metres."""

    min_width: float
    max_width: float
    min_height: float
    max_height: float


@dataclass(frozen=True)
class PlacingZone:
    """Zone of a fixture's region that boxes are placed in, with boxes around what is there already.

    `shoulders`: (N, 2) points from which an arm reaches into it. `center_only`: the middle of a box alone has to lie
    inside, as for a pan on a burner.
    """

    fixture: str
    region: str
    bounds: WorldBox
    obstacles: tuple[WorldBox, ...]
    shoulders: Floats
    center_only: bool = False


def box_around(foot: Footprint, low: float, high: float) -> WorldBox:
    """The box around a foot."""
    xs, ys = zip(*foot.corners, strict=True)
    return WorldBox(min(xs), min(ys), max(xs), max(ys), low, high)


def shoulders(places: Iterable[ParkingPlace]) -> Floats:
    """(N, 2) front of the base at each place: where a mobile manipulator carries its arm."""
    rows = ((*p.position, math.cos(p.yaw), math.sin(p.yaw)) for p in places)
    points = [(x + BASE_RADIUS_M * cosine, y + BASE_RADIUS_M * sine) for x, y, cosine, sine in rows]
    return np.array(points, dtype=np.float64).reshape(-1, 2)


def worktop_regions(facts: KitchenFacts) -> list[tuple[Fixture, FixtureRegion]]:
    """Regions of worktops on which things can be placed."""
    tops = facts.with_role(Role.WORKTOP)
    return [(f, v) for f in tops for v in f.regions if v.name == "top" or v.name.startswith("top_")]


def on_worktops(facts: KitchenFacts) -> list[WorldBox]:
    """Boxes of objects that are on worktops or let into them."""
    standing = facts.with_role(Role.THING, Role.COFFEE_MACHINE, Role.TOASTER, Role.MICROWAVE)
    heights = [row.height for row in facts.runs]
    found = (f for f in standing if any(h - SUNK_M < f.bottom < h + ABOVE_M for h in heights))
    return [box_around(f.footprint, f.bottom, f.top) for f in found]


def worktops_near(facts: KitchenFacts, fixture: Fixture, reach: float) -> list[tuple[str, str, WorldBox]]:
    """Worktops in front of and next to a fixture, up to `reach` metres to its left and right."""
    w, d = fixture.footprint.size
    window = Footprint(center=fixture.footprint.center, size=(w + 2 * reach, d + 1.0), yaw=fixture.footprint.yaw)
    box = box_around(window, -1.0, 9.0)
    found = []
    for top, volume in worktop_regions(facts):
        shared = box_around(volume.footprint, volume.bottom, volume.top).intersection(box)
        if shared.x1 - shared.x0 > 0.05 and shared.y1 - shared.y0 > 0.05:
            found.append((top.name, volume.name, shared))
    return found


def free_area(zones: Sequence[PlacingZone], cell: float = 0.02) -> float:
    """Area of zones that is not covered by obstacles, m^2."""
    total = 0.0
    for zone in zones:
        s = zone.bounds
        xs, ys = np.arange(s.x0 + cell / 2, s.x1, cell), np.arange(s.y0 + cell / 2, s.y1, cell)
        free = np.ones((len(ys), len(xs)), dtype=bool)
        for t in zone.obstacles:
            free &= ~(((xs > t.x0) & (xs < t.x1))[None, :] & ((ys > t.y0) & (ys < t.y1))[:, None])
        total += float(free.sum()) * cell**2
    return total


def acceptance(zones: Sequence[PlacingZone], size: BoxSizes, count: int, rng: np.random.Generator) -> float:
    """Share of `count` boxes, drawn into zones by their area, that fit, touch nothing and are in reach."""
    # Samplers look for a place that is large enough before they draw.
    zones = [
        z for z in zones if z.center_only or min(z.bounds.x1 - z.bounds.x0, z.bounds.y1 - z.bounds.y0) >= size.min_width
    ]
    areas = np.array([z.bounds.area for z in zones])
    if not zones or areas.sum() <= 0:
        return 0.0
    which = rng.choice(len(zones), size=count, p=areas / areas.sum())
    wide, deep = rng.uniform(size.min_width, size.max_width, (2, count))
    high = rng.uniform(size.min_height, size.max_height, count)
    at = rng.random((count, 2))
    accepted = 0
    for k in range(count):
        zone = zones[int(which[k])]
        box = _random_box(zone, (float(wide[k]), float(deep[k]), float(high[k])), (float(at[k, 0]), float(at[k, 1])))
        accepted += _is_placed_well(box, zone)
    return accepted / count


def _random_box(zone: PlacingZone, size: Vec3, at: Vec2) -> WorldBox:
    """A box somewhere in a zone; as samplers of tasks do it, only where it does not reach out, if there is room."""
    s, (w, d, h) = zone.bounds, size
    mx, my = (0.0, 0.0) if zone.center_only else (w / 2, d / 2)
    x = s.x0 + mx + at[0] * max(0.0, s.x1 - s.x0 - 2 * mx)
    y = s.y0 + my + at[1] * max(0.0, s.y1 - s.y0 - 2 * my)
    return WorldBox(x - w / 2, y - d / 2, x + w / 2, y + d / 2, s.z0, s.z0 + h)


def _is_placed_well(box: WorldBox, zone: PlacingZone) -> bool:
    s, middle = zone.bounds, ((box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2)
    inside = box.x1 <= s.x1 + ROUNDING_M and box.y1 <= s.y1 + ROUNDING_M
    if not (inside or zone.center_only) or box.z1 > s.z1:
        return False
    if not MIN_WORK_HEIGHT_M <= (box.z0 + box.z1) / 2 <= MAX_WORK_HEIGHT_M:
        return False
    if any(m.x1 > m.x0 and m.y1 > m.y0 for m in (box.intersection(t) for t in zone.obstacles)):
        return False
    reach = np.hypot(zone.shoulders[:, 0] - middle[0], zone.shoulders[:, 1] - middle[1])
    return bool(len(reach)) and float(reach.min()) <= ARM_REACH_M


class Afforded(Record):
    """Fixtures, joints, sites and regions that a kitchen offers for a task.

    Attributes:
        number, task: of the table. fixtures, joints, sites, regions: that it can be done with, `<fixture>__<name>`.
        counter_m2: free worktop next to them. floor_m2: floor around their parking places that the base can reach.
        rate: share of random boxes that could be placed, the least over all that the task places; None if it places
            nothing.
        tightest: regions with that least share.
        wants: what is missing, empty if nothing is.
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
    """Fixtures with which a task of RoboCasa v1.0 can be done; `wants`: what is missing, empty where nothing is."""

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
    """Result for a task before boxes are sampled; `wants`: what is missing. `counter`: worktops beside the fixtures."""

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
        """Free worktops next to fixtures, each once for each of them."""
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


def doors(fixture: Fixture) -> tuple[FixtureJoint, ...]:
    """Upright doors of a fixture."""
    hinged = (j for j in fixture.joints if j.kind is JointKind.HINGE)
    return tuple(j for j in hinged if j.swept_area is not None and not j.swept_area.sweeps_front)
