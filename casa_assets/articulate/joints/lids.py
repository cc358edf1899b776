"""Find the hinged lid of a vessel: a round cover with a knob in its middle, or one over an open vessel."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from casa_assets.articulate.controls.controls import has_round_outline
from casa_assets.articulate.interior.hollow_parts import view_from_above
from casa_assets.articulate.segment.fragment_measures import FRONT, LEFT, TOP, MeasuredFragments, corners_from_side
from casa_assets.core.typing import Floats
from casa_assets.geometry.solid.coverage import surface_samples

# Least width of a lid, diagonals, its thickness by its width, and its share of all surface.
MIN_LID_WIDTH, MAX_THICKNESS_BY_WIDTH, MAX_AREA_SHARE = 0.12, 0.5, 0.3
# Share of its square that is visible from above; less under a bail, if it has a knob.
MIN_VISIBLE_SHARE, MIN_VISIBLE_SHARE_UNDER_BAIL = 0.6, 0.2
# Offset of its knob from the middle and size of the knob, by the width of the lid.
MAX_KNOB_OFFSET, MAX_KNOB_WIDTH = 0.12, 0.4
# A vessel has something in the upper quarter of its height over at most this share of its plan.
MAX_COVERED_MOUTH = 0.35
# Directions from a lid to its hinge in order of preference: backwards as of jugs, sides, front.
HINGE_DIRECTIONS = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
# Protrusion of a vessel's handle, diagonals, and its height over that of what protrudes elsewhere.
MIN_HANDLE_REACH, MIN_HANDLE_HEIGHT_RATIO = 0.04, 1.3
# A lid that opens so far is open; clearance to other fragments, diagonals; samples of its surface.
OPEN_ANGLE_RAD, CLEARANCE, SAMPLES = 1.2, 0.012, 1500
# Widest gap between a lid and what it lies on, diagonals.
MAX_GAP = 0.015


@dataclass(frozen=True)
class Lid:
    """A lid with its hinge.

    Attributes:
        fragments: all of it. knob: those of its knob. lower, upper: corners in the frame.
        way: (3,) level unit direction from its middle to its hinge. opening_angle: how far it opens, rad.
    """

    fragments: list[int]
    knob: list[int]
    lower: Floats
    upper: Floats
    way: Floats
    opening_angle: float

    @property
    def hinge(self) -> tuple[Floats, Floats]:
        """Return the (3,) axis about which a positive rotation lifts it, and a point of it."""
        middle = (self.lower + self.upper) / 2
        return np.cross([0.0, 0.0, 1.0], self.way), middle + self.way * (self.upper - self.lower) / 2


def find_lids(measured: MeasuredFragments, taken: set[int]) -> list[Lid]:
    """Return the lid of an object; none where several things look like one, as burners do."""
    lower, upper = corners_from_side(measured, TOP)
    size = upper - lower
    across = size[:, :2].max(axis=1)
    fits = (
        (across >= MIN_LID_WIDTH)
        & (size[:, :2].min(axis=1) >= across / 1.2)
        & (size[:, 2] <= MAX_THICKNESS_BY_WIDTH * across)
    )
    fits &= measured.area <= MAX_AREA_SHARE * float(measured.area.sum())
    bare = measured.visible_area[:, TOP] / np.maximum(size[:, 0] * size[:, 1], 1e-12)
    fits &= bare >= MIN_VISIBLE_SHARE_UNDER_BAIL
    fits[sorted(taken)] = False
    discs = [i for i in np.flatnonzero(fits).tolist() if has_round_outline(measured, TOP, [i], size[i, :2])]
    if len(discs) != 1:
        return []
    disc = discs[0]
    knob = _knob(lower, upper, disc, across)
    host = _host(lower, upper, disc)
    if host is None or not (knob or (bare[disc] >= MIN_VISIBLE_SHARE and _is_vessel(measured, host))):
        return []
    fragments = [disc, *knob]
    corners = measured.box(fragments)
    held = _handle_side(measured, host, fragments)
    ways = sorted(range(len(HINGE_DIRECTIONS)), key=lambda k: (k != held, k))
    lids = [_opened(measured, Lid(fragments, knob, *corners, HINGE_DIRECTIONS[k], 0.0)) for k in ways]
    wide = [lid for lid in lids if lid.opening_angle >= OPEN_ANGLE_RAD]
    return [wide[0] if wide else max(lids, key=lambda lid: lid.opening_angle)]


def _handle_side(measured: MeasuredFragments, host: int, lid: list[int]) -> int:
    """Return the index of the direction to a vessel's handle, or away from its spout; backwards by default.

    Of what sticks out at the sides the tallest is the handle; under a bail what sticks out alone is the spout.
    """
    own = [host, *lid]
    reach = []
    for way in HINGE_DIRECTIONS:
        out = measured.lower @ np.minimum(way, 0.0) + measured.upper @ np.maximum(way, 0.0)
        out = out - out[host]
        out[own] = 0.0
        rows = np.flatnonzero(out > MIN_HANDLE_REACH)
        reach.append(float(measured.upper[rows, 2].max() - measured.lower[rows, 2].min()) if len(rows) else 0.0)
    best = int(np.argmax(reach))
    others = max(r for k, r in enumerate(reach) if k != best)
    if reach[best] <= MIN_HANDLE_HEIGHT_RATIO * others:
        return 0
    lower, upper = measured.box(lid)
    over = (measured.lower[:, :2] < upper[:2]).all(axis=1) & (measured.upper[:, :2] > lower[:2]).all(axis=1)
    over &= measured.upper[:, 2] > upper[2] + MIN_HANDLE_REACH
    over[own] = False
    spout = others == 0.0 and bool(over.any())
    return (
        next(k for k, way in enumerate(HINGE_DIRECTIONS) if float(way @ HINGE_DIRECTIONS[best]) < -0.5)
        if spout
        else best
    )


def _opened(measured: MeasuredFragments, lid: Lid) -> Lid:
    """Return the lid with the angle to which it opens before it meets what it does not touch when shut."""
    rows = np.zeros(len(measured.label), dtype=bool)
    rows[measured.faces_of(lid.fragments)] = True
    others = ~rows & (measured.label >= 0)
    points, faces = measured.mesh.points, measured.mesh.faces
    own = surface_samples(points, faces[rows], SAMPLES)
    tree = cKDTree(surface_samples(points, faces[others], 8 * SAMPLES))
    own = own[tree.query(own)[0] > CLEARANCE]
    axis, anchor = lid.hinge
    own = own[(anchor - own) @ lid.way > CLEARANCE]
    far = 0.0
    for angle in np.radians(np.arange(5.0, 90.1, 5.0)):
        moved = Rotation.from_rotvec(axis * angle).apply(own - anchor) + anchor
        if len(own) and float(tree.query(moved)[0].min()) < CLEARANCE:
            break
        far = float(angle)
    return replace(lid, opening_angle=far)


def _is_vessel(measured: MeasuredFragments, host: int) -> bool:
    """Return whether a fragment is open at the top and closed all around."""
    size = measured.upper[host] - measured.lower[host]
    closed = all(measured.visible_area[host, s] >= 0.6 * size[a] * size[2] for s, a in ((FRONT, 0), (LEFT, 1)))
    return closed and view_from_above(measured, [host]).lid <= MAX_COVERED_MOUTH


def _knob(lower: Floats, upper: Floats, disc: int, across: Floats) -> list[int]:
    """Return the small fragments in the middle of a disc that stand up from it."""
    off = np.linalg.norm((lower + upper)[:, :2] / 2 - (lower + upper)[disc, :2] / 2, axis=1)
    stands = (
        (lower[:, 2] < lower[disc, 2] - 0.01)
        & (upper[:, 2] >= lower[disc, 2] - MAX_GAP)
        & (upper[:, 2] <= upper[disc, 2] + MAX_GAP)
    )
    found = stands & (off <= MAX_KNOB_OFFSET * across[disc]) & (across <= MAX_KNOB_WIDTH * across[disc])
    found[disc] = False
    return [int(i) for i in np.flatnonzero(found)]


def _host(lower: Floats, upper: Floats, disc: int) -> int | None:
    """Return the largest fragment that a disc lies on."""
    under = (lower[:, 2] <= upper[disc, 2] + MAX_GAP) & (upper[:, 2] > upper[disc, 2] + MAX_GAP)
    middle = (lower[disc, :2] + upper[disc, :2]) / 2
    under &= (lower[:, :2] <= middle).all(axis=1) & (upper[:, :2] >= middle).all(axis=1)
    under[disc] = False
    rows = np.flatnonzero(under)
    if not len(rows):
        return None
    footprint = np.prod((upper - lower)[rows, :2], axis=1)
    return int(rows[int(np.argmax(footprint))])
