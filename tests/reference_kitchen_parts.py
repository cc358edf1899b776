"""Pieces of kitchens of plain facts: feet in rows, doors, flaps and regions."""

from __future__ import annotations

import math

from casa_assets.geometry.planar import outline_of
from casa_assets.model.asset.parts import JointKind
from casa_assets.model.kitchen.floor import (
    Corners,
    FixtureJoint,
    FixtureRegion,
    Footprint,
    PlacedRun,
    PlacedUnit,
    SweptArea,
)


def unit(name: str, kind: str, left: float, right: float, high: float = 0.89, front: float = 0.65) -> PlacedUnit:
    """A unit of a row; tall ones and ranges carry no worktop."""
    carries = kind not in ("range", "gap") and high < 1.5
    return PlacedUnit(name=name, kind=kind, left=left, right=right, front=front, height=high, has_worktop=carries)


def foot_in(row: PlacedRun, left: float, right: float, front: float, back: float = 0.0) -> Footprint:
    """The foot of what stands there in a row, facing as its fronts do."""
    middle = row.at((left + right) / 2, (front + back) / 2)
    return Footprint(center=middle, size=(right - left, front - back), yaw=row.yaw)


def box(foot: Footprint, left: float, right: float, back: float, front: float) -> Corners:
    """Corners of a rectangle before a foot's front: to the right of its middle, and before it; counter-clockwise."""
    return (foot.at(left, front), foot.at(right, front), foot.at(right, back), foot.at(left, back))


def flap(foot: Footprint, name: str, out: float, low: float, high: float, slides: bool = False) -> FixtureJoint:
    """A flap or drawer as wide as its foot, that comes out so far."""
    w = foot.size[0] / 2 - 0.01
    outline = box(foot, -w, w, 0.0, out)
    return FixtureJoint(
        name=name,
        kind=JointKind.SLIDE if slides else JointKind.HINGE,
        range=(-out, 0.0) if slides else (0.0, 1.5),
        grip_point=(*foot.at(0.0, 0.03), high - 0.05),
        swept_area=SweptArea(outline=outline, open_outline=outline, bottom=low, top=high, sweeps_front=True),
    )


def door(
    foot: Footprint, name: str, left: float, right: float, low: float, high: float, hung_left: bool = True
) -> FixtureJoint:
    """An upright door between two places along a foot's front, that opens by 90 degrees."""
    wide, at = right - left, left if hung_left else right
    way = 1.0 if hung_left else -1.0
    arc = [(at + way * wide * math.cos(a), wide * math.sin(a)) for a in (0.0, 0.4, 0.8, 1.2, math.pi / 2)]
    swept = outline_of([foot.at(at, 0.0), *(foot.at(*p) for p in arc)])
    opened = box(foot, min(at, at + 0.02 * way), max(at, at + 0.02 * way), 0.0, wide)
    return FixtureJoint(
        name=name,
        kind=JointKind.HINGE,
        range=(0.0, 1.57),
        grip_point=(*foot.at(at + way * 0.9 * wide, 0.03), low + 0.1),
        swept_area=SweptArea(
            outline=tuple((float(x), float(y)) for x, y in swept),
            open_outline=opened,
            bottom=low,
            top=high,
            sweeps_front=False,
        ),
    )


def volume(foot: Footprint, name: str, low: float, high: float, moves: bool = False) -> FixtureRegion:
    """A region that fills a foot."""
    return FixtureRegion(name=name, footprint=foot, bottom=low, top=high, is_moving=moves)
