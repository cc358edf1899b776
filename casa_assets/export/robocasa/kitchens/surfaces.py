"""Free surfaces of a worktop on which RoboCasa may put objects, without shallow areas in front of deep appliances.

RoboCasa v1.0 puts a task's plate in front of the microwave, as near to the front edge as it can, and gives up if there
is no room. An area that is too shallow there is left out, so that RoboCasa uses the area next to it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from casa_assets.core.numeric import decimals
from casa_assets.core.robocasa import MIN_SURFACE_M, PLATE_DEPTH_M
from casa_assets.model.asset.asset import Asset, Region
from casa_assets.model.record import Vec3

Corner = tuple[float, float]
Footprint = tuple[Corner, Corner]
PREFIX = "top"


@dataclass(frozen=True)
class Surface:
    """A rectangle of a worktop: its middle and full size in the frame of the worktop, metres."""

    position: Vec3
    size: Vec3


def free(counter: Asset, things: Iterable[Footprint]) -> tuple[Surface, ...]:
    """Return the free surfaces of a worktop, whose front is at its minimum y.

    Args:
        counter: the worktop, centred.
        things: footprints of the objects on it, in its frame.
    """
    things = sorted(things)
    out: list[Surface] = []
    for region in counter.regions:
        if region.name.startswith(PREFIX):
            out += _without(region, things)
    return tuple(out)


def _without(region: Region, things: Iterable[Footprint]) -> list[Surface]:
    """Cut a region at footprints that leave too little room; uncut if no large enough part would remain."""
    (x, y, z), (width, depth, height) = region.pose.position, region.size
    left, right, front, back = x - width / 2, x + width / 2, y - depth / 2, y + depth / 2
    spans = [(left, right)]
    for low, high in things:
        if low[1] < back and high[1] > front and low[1] - front < PLATE_DEPTH_M:
            spans = [part for span in spans for part in _outside(span, low[0], high[0])]
    kept = [(a, b) for a, b in spans if b - a >= MIN_SURFACE_M[0] and depth >= MIN_SURFACE_M[1]] or [(left, right)]
    return [
        Surface((decimals((a + b) / 2, 9), decimals(y, 9), decimals(z, 9)), (decimals(b - a, 9), depth, height))
        for a, b in kept
    ]


def _outside(span: Corner, low: float, high: float) -> list[Corner]:
    """Parts of a span that are outside `low` to `high`."""
    return [(a, b) for a, b in ((span[0], min(span[1], low)), (max(span[0], high), span[1])) if b > a]
