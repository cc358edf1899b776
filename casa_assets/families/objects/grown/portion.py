"""Halves, wedges, slices and pieces of what grew in one piece: where they are cut, and how they lie."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.families.kit.solids.solid import Solid
from casa_assets.families.objects.cutting import Plane, across, along, cut, sector, shell
from casa_assets.geometry.mesh.measure import solid_moments
from casa_assets.model.registry.category import Portion

# How far the lining of a hollow reaches to either side of it, by the distance from its middle.
LINING = 0.015
# A round side of flat faces is rolled over if the next is lower; half degrees from one to the next.
FACET = 16


class Face(StrEnum):
    """Where the cut face of a half or a wedge looks."""

    UP = "up"  # it lies on its skin
    DOWN = "down"  # it lies on a cut face
    SIDE = "side"  # it lies on the side of its skin, where it comes to rest, and a face across the axis looks to +x


@dataclass(frozen=True)
class Cutting:
    """How a body about the z axis is cut.

    Attributes:
        portion: what is left. crosswise: a half is cut across the axis rather than along it.
        at: height of a cut across the axis, or of the middle of a slice, m.
        thick, slant: thickness of a slice, m, and how far it is from square, rad. angle: of a wedge, rad.
        heart: height about which the pictures of faces along the axis lie, m.
        hollow: size of the hollow by that of the body; 0 for none.
        face: where the cut face looks.
    """

    portion: Portion
    crosswise: bool
    at: float
    thick: float
    slant: float
    angle: float
    heart: float
    hollow: float
    face: Face

    @property
    def planes(self) -> list[Plane]:
        """The planes that cut."""
        middle = np.array([0.0, 0.0, self.heart])
        match self.portion:
            case Portion.SLICE:
                at = self.at * math.cos(self.slant)
                low, high = at - self.thick / 2, at + self.thick / 2
                return [across(high, below=True, slant=self.slant), across(low, below=False, slant=self.slant)]
            case Portion.WEDGE:
                return sector(self.angle, middle)
            case Portion.HALF if not self.crosswise:
                return [along(0.0, middle)]
        return [across(self.at, below=True)]

    def laid(self, points: Floats) -> Floats:
        """Points as the portion rests."""
        x, y, z = points.T
        if self.portion is Portion.WEDGE:
            # On its skin; or turned about the axis until one of its faces lies below.
            turn = 0.0 if self.face is Face.UP else (self.angle + math.pi) / 2
            c, s = math.cos(turn), math.sin(turn)
            return np.column_stack([z, c * y + s * x, s * y - c * x])
        if self.portion is Portion.SLICE:
            c, s = math.cos(self.slant), math.sin(self.slant)
            return np.column_stack([c * x - s * z, y, s * x + c * z])
        if self.portion is Portion.HALF and not self.crosswise:
            return np.column_stack([z, x, y] if self.face is Face.UP else [z, -x, -y])
        if self.face is Face.SIDE:
            return np.column_stack([z, x, y])
        return points if self.face is Face.UP else points * (1.0, -1.0, -1.0)


def rest_tilt(body: Solid) -> float:
    """Angle about the y axis by which a body has to be turned from how it lies until it is at rest, rad.

    It rolls downhill: to where the middle of its mass is lowest above the ground of all tilts on the way.
    """
    _, middle, _ = solid_moments(body.points, body.faces)
    tilts = np.radians(np.arange(-90.0, 90.5, 0.5))
    # Height of the middle of mass above the lowest point, at each tilt.
    x, z = body.points[:, 0] - middle[0], body.points[:, 2] - middle[2]
    heights = np.array([-float((z * math.cos(t) - x * math.sin(t)).min()) for t in tilts])
    place = len(tilts) // 2
    while True:
        near = range(max(0, place - FACET), min(len(tilts), place + FACET + 1))
        lower = min(near, key=lambda k: heights[k])
        if heights[lower] >= heights[place] - 1e-9:
            return float(tilts[place])
        place = lower


def portion_of(body: Solid, cutting: Cutting) -> tuple[Solid, list[Solid], Solid | None]:
    """Cut a body about the z axis; return the rest, the plates on its cut faces, and its hollow's lining or None."""
    if not cutting.hollow:
        return *cut(body, cutting.planes), None
    middle = (body.points.min(axis=0) + body.points.max(axis=0)) / 2

    def scaled(share: float) -> Solid:
        return replace(body, points=middle + (body.points - middle) * share, picture_uv=None)

    kept, faces = cut(body, cutting.planes, scaled(cutting.hollow))
    inside, outside = scaled(cutting.hollow - LINING), scaled(cutting.hollow + LINING)
    return kept, faces, shell(outside, inside, cutting.planes)
