"""Draw a kitchen from above: the fixtures, the floor that a mobile base can reach, and where it parks."""

from __future__ import annotations

import math

import numpy as np
from PIL import Image, ImageDraw

from casa_assets.checks.design.robot.floor_map import BASE_RADIUS_M, row_parts, stands
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.model.kitchen.floor import Corners, Fixture, ParkingPlace, ParkingSide, Role
from casa_assets.model.record import Vec2

PIXELS_PER_M = 120
MARGIN_M = 0.35  # of floor around the outline of the room
DASH_M = 0.1  # from the start of one dash to the next
WHITE, BLACK = (255, 255, 255), (40, 40, 44)
REACHED, FREE, FLOOR = (214, 234, 214), (250, 226, 190), (238, 238, 236)
SOLID, APPLIANCE, WALL_UNIT, SWEPT_AREA, PARKED, PARKED_AT_OPEN_DOOR = (
    (196, 190, 182),
    (150, 170, 200),
    (120, 110, 100),
    (214, 120, 90),
    (30, 110, 60),
    (60, 90, 190),
)
APPLIANCES = (Role.SINK, Role.RANGE, Role.HOB, Role.FRIDGE, Role.DISHWASHER, Role.OVEN, Role.MICROWAVE)


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
        x, y = self._pixel(place.position)
        r = 0.05 * PIXELS_PER_M
        self.draw.ellipse([x - r, y - r, x + r, y + r], outline=color, width=2)
        tip = (
            place.position[0] + BASE_RADIUS_M * math.cos(place.yaw),
            place.position[1] + BASE_RADIUS_M * math.sin(place.yaw),
        )
        self.line((place.position, tip), color, 2)

    def name(self, fixture: Fixture) -> None:
        """Write what a fixture is at its center."""
        x, y = self._pixel(fixture.footprint.center)
        self.draw.text((x, y), fixture.role.value.replace("_", " "), fill=BLACK, anchor="mm")
