"""A kitchen as checks of design and ways see it: its summary, its picture, and what a robot does not reach."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from casa_assets.checks.check import Measurement, count, not_applicable, worst_below
from casa_assets.checks.design.floor_map import BASE_RADIUS_M, FloorMap, ParkingPlaces, find_parking, row_parts, stands
from casa_assets.checks.design.task_view import Afforded, AtomicTask, TaskView
from casa_assets.checks.design.tasks import afforded, atomic_tasks
from casa_assets.model.kitchen.floor import Corners, Fixture, KitchenFacts, ParkingPlace, ParkingSide, Role
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.record import Vec2

PIXELS_PER_M = 120
MARGIN_M = 0.35  # of floor around the outline of the room
DASH_M = 0.1  # from the start of one dash to the next
WHITE, BLACK = (255, 255, 255), (40, 40, 44)
REACHED, FREE, FLOOR = (214, 234, 214), (250, 226, 190), (238, 238, 236)
SOLID = (196, 190, 182)
APPLIANCE = (150, 170, 200)
WALL_UNIT = (120, 110, 100)
SWEPT_AREA, PARKED, PARKED_AT_OPEN_DOOR = (214, 120, 90), (30, 110, 60), (60, 90, 190)
APPLIANCES = (Role.SINK, Role.RANGE, Role.HOB, Role.FRIDGE, Role.DISHWASHER, Role.OVEN, Role.MICROWAVE)


@dataclass(frozen=True, eq=False)
class DesignSubject:
    """A kitchen's facts, and a seed of the samples with which tasks are tried; a subject is equal to itself alone."""

    facts: KitchenFacts
    seed: int = 0

    @cached_property
    def floor(self) -> FloorMap:
        """The floor as a grid."""
        return FloorMap(self.facts)

    @cached_property
    def parking(self) -> ParkingPlaces:
        """Parking places of a robot's base."""
        return find_parking(self.facts, self.floor)

    @cached_property
    def tasks(self) -> tuple[Afforded, ...]:
        """Fixtures, joints, sites and regions that the kitchen offers for each task."""
        return afforded(self.facts, self.floor, self.parking, self.seed)

    @cached_property
    def atomic_tasks(self) -> tuple[AtomicTask, ...]:
        """With what the tasks of RoboCasa v1.0 can be done."""
        return atomic_tasks(TaskView(self.facts, self.floor, self.parking))


def whereabouts(subject: DesignSubject) -> dict[str, Any]:
    """JSON data about the floor of a kitchen for scene files; all numbers are rounded.

    Returns:
        base_radius: of the robot, metres.
        parking: fixture -> `shut`, and `open` by joint: `x`, `y`, `yaw` of the middle of the base (yaw: radians to the
            left of the x axis) and the `side` of the fixture that it is at; None if the base cannot get there.
        robocasa_v1: each of the 65 atomic tasks of RoboCasa v1.0, by its name there -> whether it is `afforded`, with
            which fixtures; else what it `wants`. Objects to put are the library's.
        tasks: each of the 25 atomic tasks of v0.2 -> whether it is `afforded`, with which fixtures, joints, sites and
            regions, how much free worktop and floor there is, and at which rate things can be put; else what it
            `wants`.
    """
    places: dict[str, dict[str, Any]] = {
        name: {"shut": _place(place), "open": {}} for name, place in subject.parking.shut.items()
    }
    for (name, joint), place in subject.parking.open.items():
        places[name]["open"][joint] = _place(place)
    return {
        "base_radius": BASE_RADIUS_M,
        "parking": places,
        "tasks": {t.task: _task(t) for t in subject.tasks},
        "robocasa_v1": {t.task: _task(t) for t in subject.atomic_tasks},
    }


def _task(task: Afforded | AtomicTask) -> dict[str, Any]:
    if task.wants:
        return {"afforded": False, "wants": task.wants}
    return {"afforded": True, **task.model_dump(mode="json", exclude={"number", "task", "tightest", "wants"})}


def _place(place: ParkingPlace | None) -> dict[str, Any] | None:
    if place is None:
        return None
    return {"x": place.position[0], "y": place.position[1], "yaw": place.yaw, "side": place.side.value}


def fixtures_are_reachable(subject: DesignSubject, limit: float) -> Measurement:
    """NAV001: number of fixtures that a base cannot park before, coming from a doorway or an open side."""
    places = subject.parking.shut
    if not places:
        return not_applicable("it has no fixture to park before")
    message = "no base of 0.30 m radius can park before it: leave floor free there, and a way to it"
    return count(((f"fixtures/{name}", message) for name, place in places.items() if place is None), allowed=limit)


def opened_fixtures_are_reachable(subject: DesignSubject, limit: float) -> Measurement:
    """NAV002: number of fixtures that a base cannot park before while one of their doors or drawers is open.

    `fixtures_are_reachable` reports fixtures that are not reached with all shut.
    """
    parking = subject.parking
    if not parking.open:
        return not_applicable("nothing in it opens")
    message = "no base of 0.30 m radius can stand before, beside or behind it once it is open"
    problems = (
        (f"fixtures/{name}/{joint}", message)
        for (name, joint), place in parking.open.items()
        if place is None and parking.shut[name] is not None
    )
    return count(problems, allowed=limit)


def entries_lead_in(subject: DesignSubject, limit: float) -> Measurement:
    """NAV003: number of doors and passages from which a base does not get on to the kitchen's floor."""
    entries = [o for o in subject.facts.openings if o.kind is not OpeningKind.WINDOW]
    if not entries:
        return not_applicable("it has no door and no passage")
    message = "what stands before it leaves no way for a base of 0.30 m radius"
    blocked = (o.id for o in entries if not subject.floor.leads_in(o.start, o.end))
    return count(((f"openings/{name}", message) for name in blocked), allowed=limit)


def tasks_are_supported(subject: DesignSubject, limit: float) -> Measurement:
    """TSK001: number of the 25 tasks that lack fixtures, joints or sites that a base gets to.

    Only a plan that says so has to support them all: a kitchen without a microwave is no fault of a kitchen.
    """
    if not subject.facts.all_tasks:
        return not_applicable("its plan does not say `all_tasks: true`")
    return count(((f"tasks/{t.task}", f"it wants {t.wants}") for t in subject.tasks if t.wants), allowed=limit)


def task_objects_find_room(subject: DesignSubject, limit: float) -> Measurement:
    """TSK002: least share, over the tasks, of sampled objects that can be placed.

    `tasks_are_supported` reports tasks that lack something else.
    """
    message = "of 200 things only {:.1%} found room within reach at {}; {:.0%} wanted: clear it, or make it larger"
    rates = ((t, t.rate) for t in subject.tasks if t.rate is not None)
    rows = ((f"tasks/{t.task}", rate, message.format(rate, t.tightest, limit)) for t, rate in rates)
    return worst_below(rows, limit, "it has what it takes for no task (TSK001)")


def floor_picture(subject: DesignSubject) -> Image.Image:
    """Return the floor of a kitchen from above, `PIXELS_PER_M` pixels per metre, y upwards.

    Floor that the middle of the base reaches is green, floor that is free but out of reach yellow. Parking places with
    all doors shut are green circles, those with one door open blue. Areas that doors sweep are red, wall units dashed.
    """
    facts = subject.facts
    points = np.array(facts.outline)
    drawing = _Drawing(points.min(axis=0) - MARGIN_M, points.max(axis=0) + MARGIN_M)
    drawing.fill(facts.outline, FLOOR)
    drawing.reach(subject)
    for row in facts.runs:
        for part in row_parts(row):
            drawing.fill(part, SOLID, BLACK)
    for fixture in facts.fixtures:
        if fixture.role in APPLIANCES:
            drawing.fill(fixture.footprint.corners, APPLIANCE, BLACK)
        elif fixture.role is Role.SEAT or (stands(fixture) and not fixture.run):
            drawing.fill(fixture.footprint.corners, SOLID, BLACK)
        elif fixture.role in (Role.UPPER, Role.SHELF, Role.HOOD):
            drawing.dashed(fixture.footprint.corners)
    for fixture in facts.fixtures:
        for joint in fixture.joints:
            if joint.swept_area is not None and joint.behind is None:
                drawing.line((*joint.swept_area.outline, joint.swept_area.outline[0]), SWEPT_AREA)
    for wall in facts.walls:
        drawing.line((wall.start, wall.end), (200, 200, 200) if wall.is_open else BLACK, 2 if wall.is_open else 9)
    for way in facts.openings:
        drawing.line((way.start, way.end), WHITE, 5)
    for place in subject.parking.every:
        drawing.parking(place)
    for fixture in facts.with_role(*APPLIANCES, Role.COFFEE_MACHINE, Role.TOASTER):
        drawing.name(fixture)
    return drawing.image


class _Drawing:
    """Image that is drawn on in metres, y upwards."""

    def __init__(self, lower: np.ndarray, upper: np.ndarray) -> None:
        self.lower, self.upper = lower, upper
        width, height = np.ceil((upper - lower) * PIXELS_PER_M).astype(int)
        self.image = Image.new("RGB", (int(width), int(height)), WHITE)
        self.draw = ImageDraw.Draw(self.image)

    def _pixel(self, point: Vec2) -> tuple[float, float]:
        """Return column and row of a point in metres."""
        return (float((point[0] - self.lower[0]) * PIXELS_PER_M), float((self.upper[1] - point[1]) * PIXELS_PER_M))

    def fill(self, corners: Corners, color: tuple[int, int, int], edge: tuple[int, int, int] | None = None) -> None:
        """Fill a polygon, with an outline where its color is given."""
        self.draw.polygon([self._pixel(p) for p in corners], fill=color, outline=edge)

    def line(self, points: Corners, color: tuple[int, int, int], width: int = 1) -> None:
        """Draw a line through points; width in pixels."""
        self.draw.line([self._pixel(p) for p in points], fill=color, width=width)

    def dashed(self, corners: Corners) -> None:
        """Draw the outline of a polygon in dashes."""
        for a, b in zip(corners, (*corners[1:], corners[0]), strict=True):
            count = max(1, int(math.dist(a, b) / DASH_M))
            for k in range(count):
                ends = [(a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t) for t in (k / count, (k + 0.5) / count)]
                self.line((ends[0], ends[1]), WALL_UNIT)

    def reach(self, subject: DesignSubject) -> None:
        """Paint the cells of the floor grid: in the room, free, and reached by the base."""
        floor = subject.floor
        colors = np.full((*floor.shape, 3), 255, dtype=np.uint8)
        colors[floor.room] = FLOOR
        colors[floor.free] = FREE
        colors[floor.reached] = REACHED
        (x0, y1), (x1, y0) = self._pixel((floor.xs[0], floor.ys[0])), self._pixel((floor.xs[-1], floor.ys[-1]))
        grid = Image.fromarray(colors[::-1]).resize((round(x1 - x0), round(y1 - y0)), Image.Resampling.NEAREST)
        mask = Image.fromarray(floor.room[::-1].astype(np.uint8) * 255).resize(grid.size, Image.Resampling.NEAREST)
        self.image.paste(grid, (round(x0), round(y0)), mask)

    def parking(self, place: ParkingPlace) -> None:
        """Draw a parking place as a circle with a line of the base's radius to where it faces."""
        color = PARKED_AT_OPEN_DOOR if place.open_joint else PARKED
        if place.open_joint and place.side is ParkingSide.FRONT:
            return
        (x, y), (a, b), r = self._pixel(place.position), place.position, 0.05 * PIXELS_PER_M
        self.draw.ellipse([x - r, y - r, x + r, y + r], outline=color, width=2)
        tip = (a + BASE_RADIUS_M * math.cos(place.yaw), b + BASE_RADIUS_M * math.sin(place.yaw))
        self.line((place.position, tip), color, 2)

    def name(self, fixture: Fixture) -> None:
        """Write what a fixture is at its center."""
        x, y = self._pixel(fixture.footprint.center)
        self.draw.text((x, y), fixture.role.value.replace("_", " "), fill=BLACK, anchor="mm")
