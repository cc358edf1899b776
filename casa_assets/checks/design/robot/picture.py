"""A picture of the floor: where the base can be, where it parks, and what stands there."""

from __future__ import annotations

import math

import numpy as np
from PIL import Image, ImageDraw

from casa_assets.checks.design.robot.floor_map import BASE_RADIUS_M, row_parts, stands
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.model.kitchen.floor import Corners, Fixture, ParkingPlace, ParkingSide, Role
from casa_assets.model.record import Vec2

PIXELS = 120  # per metre
MARGIN = 0.35
WHITE, BLACK = (255, 255, 255), (40, 40, 44)
REACHED, FREE, FLOOR = (214, 234, 214), (250, 226, 190), (238, 238, 236)
SOLID, APPLIANCE, UPPER, LEAF, POSE, BESIDE = (
    (196, 190, 182),
    (150, 170, 200),
    (120, 110, 100),
    (214, 120, 90),
    (30, 110, 60),
    (60, 90, 190),
)
APPLIANCES = (Role.SINK, Role.RANGE, Role.HOB, Role.FRIDGE, Role.DISHWASHER, Role.OVEN, Role.MICROWAVE)


def floor_picture(subject: DesignSubject) -> Image.Image:
    """Green: floor that the middle of the base gets to; yellow: where it could be but does not get to.

    Poses with all shut are green, those with a leaf open blue; ways of leaves are drawn in red, wall units dashed.
    """
    facts = subject.facts
    points = np.array(facts.outline)
    sheet = _Sheet(points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN)
    sheet.fill(facts.outline, FLOOR)
    sheet.cells(subject)
    for row in facts.runs:
        for part in row_parts(row):
            sheet.fill(part, SOLID, BLACK)
    for fixture in facts.fixtures:
        if fixture.role in APPLIANCES:
            sheet.fill(fixture.footprint.corners, APPLIANCE, BLACK)
        elif fixture.role is Role.SEAT or (stands(fixture) and not fixture.run):
            sheet.fill(fixture.footprint.corners, SOLID, BLACK)
        elif fixture.role in (Role.UPPER, Role.SHELF, Role.HOOD):
            sheet.dashes(fixture.footprint.corners)
    for fixture in facts.fixtures:
        for joint in fixture.joints:
            if joint.swept_area is not None and joint.behind is None:
                sheet.line((*joint.swept_area.outline, joint.swept_area.outline[0]), LEAF)
    for wall in facts.walls:
        sheet.line((wall.start, wall.end), (200, 200, 200) if wall.is_open else BLACK, 2 if wall.is_open else 9)
    for way in facts.openings:
        sheet.line((way.start, way.end), WHITE, 5)
    for place in subject.parking.every:
        sheet.pose(place)
    for fixture in facts.with_role(*APPLIANCES, Role.COFFEE_MACHINE, Role.TOASTER):
        sheet.word(fixture)
    return sheet.image


class _Sheet:
    """A drawing in metres, y upwards."""

    def __init__(self, low: np.ndarray, high: np.ndarray) -> None:
        self.low, self.high = low, high
        width, height = np.ceil((high - low) * PIXELS).astype(int)
        self.image = Image.new("RGB", (int(width), int(height)), WHITE)
        self.pen = ImageDraw.Draw(self.image)

    def _to(self, point: Vec2) -> tuple[float, float]:
        return (float((point[0] - self.low[0]) * PIXELS), float((self.high[1] - point[1]) * PIXELS))

    def fill(self, corners: Corners, colour: tuple[int, int, int], edge: tuple[int, int, int] | None = None) -> None:
        self.pen.polygon([self._to(p) for p in corners], fill=colour, outline=edge)

    def line(self, points: Corners, colour: tuple[int, int, int], width: int = 1) -> None:
        self.pen.line([self._to(p) for p in points], fill=colour, width=width)

    def dashes(self, corners: Corners) -> None:
        for a, b in zip(corners, (*corners[1:], corners[0]), strict=True):
            count = max(1, int(math.dist(a, b) / 0.1))
            for k in range(count):
                ends = [(a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t) for t in (k / count, (k + 0.5) / count)]
                self.line((ends[0], ends[1]), UPPER)

    def cells(self, subject: DesignSubject) -> None:
        floor = subject.floor
        colours = np.full((*floor.shape, 3), 255, dtype=np.uint8)
        colours[floor.room] = FLOOR
        colours[floor.free] = FREE
        colours[floor.reached] = REACHED
        low, high = np.array([floor.xs[0], floor.ys[0]]), np.array([floor.xs[-1], floor.ys[-1]])
        (x0, y1), (x1, y0) = self._to((low[0], low[1])), self._to((high[0], high[1]))
        grid = Image.fromarray(colours[::-1]).resize((round(x1 - x0), round(y1 - y0)), Image.Resampling.NEAREST)
        mask = Image.fromarray(floor.room[::-1].astype(np.uint8) * 255).resize(grid.size, Image.Resampling.NEAREST)
        self.image.paste(grid, (round(x0), round(y0)), mask)

    def pose(self, place: ParkingPlace) -> None:
        colour = POSE if not place.open_joint else BESIDE
        if place.open_joint and place.side is ParkingSide.FRONT:
            return
        x, y = self._to(place.position)
        r = 0.05 * PIXELS
        self.pen.ellipse([x - r, y - r, x + r, y + r], outline=colour, width=2)
        tip = (
            place.position[0] + BASE_RADIUS_M * math.cos(place.yaw),
            place.position[1] + BASE_RADIUS_M * math.sin(place.yaw),
        )
        self.line((place.position, tip), colour, 2)

    def word(self, fixture: Fixture) -> None:
        x, y = self._to(fixture.footprint.center)
        self.pen.text((x, y), fixture.role.value.replace("_", " "), fill=BLACK, anchor="mm")
