"""Fragments -> controls: compact things that stand out from a side, such as knobs, buttons and the pulls of fronts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from casa_assets.articulate.pieces import SIDES, Pieces, face_on
from casa_assets.articulate.raster import Picture
from casa_assets.articulate.soup import Floats

# Sizes in diagonals of the thing. Ref: ranges of knobs and buttons over 350 labelled ones, widened.
SMALLEST, LARGEST = 0.006, 0.14
# A disc fills pi/4 of its square; a hull that fills this much of that, either way, is round.
ROUND = 0.09
LONGEST = 5.0
# So much of what is round a control is a surface that it sits on: a cap on an edge stands against the sky.
SITS = 0.6
# Fingers need so much room round a control, by its width; at most this part of it may be taken.
ROUND_IT, HEMMED = 0.3, 0.08
# A pin is so many times longer than wide. Ref: knobs of appliances reach 1.1, push pins start at 1.4.
PIN = 1.3
# A cap faces within 45 degrees of the side that shows it; its faces agree within 2 degrees; it is so much of the front.
TILT, FLAT, CAP = 0.707, 0.9994, 0.4


@dataclass
class Control:
    """Something small on a side.

    Attributes:
        fragments: that it is made of. low, high: (3,) corners in (u, v, w).
        stands: how far it stands out from what is round it. round: its outline is a circle.
    """

    fragments: list[int]
    low: Floats
    high: Floats
    stands: float
    round: bool

    @property
    def across(self) -> Floats:
        """(2,) width and height."""
        found: Floats = (self.high - self.low)[:2]
        return found

    @property
    def middle(self) -> Floats:
        """(2,) of its rectangle."""
        found: Floats = (self.high + self.low)[:2] / 2
        return found

    @property
    def is_pin(self) -> bool:
        """Of one piece, and longer than wide: what is pushed, not turned."""
        return len(self.fragments) == 1 and float((self.high - self.low)[2]) > PIN * float(self.across.max())

    @property
    def long(self) -> float:
        """Longer by shorter side."""
        return float(self.across.max() / max(float(self.across.min()), 1e-9))


def find_controls(pieces: Pieces, side: int, taken: Sequence[int]) -> list[Control]:
    """Compact things on a side, those of fragments in `taken` left out; by place, top down and left to right."""
    low, high = face_on(pieces, side)
    size = high - low
    most = size[:, :2].max(axis=1)
    foot = size[:, 0] * size[:, 1]
    free = np.ones(pieces.count, dtype=bool)
    free[list(taken)] = False
    fits = (most <= LARGEST) & (most >= SMALLEST / 3) & (size[:, 2] <= 0.2) & free
    shown = pieces.seen[:, side] > 0
    rows = np.flatnonzero(fits & (shown | (foot > 0)))
    found = []
    for group in _nested(low, high, rows.tolist(), foot):
        box = low[group].min(axis=0), high[group].max(axis=0)
        seen = float(pieces.seen[group, side].sum())
        across = (box[1] - box[0])[:2]
        if seen < 0.35 * float(np.prod(across)) or across.max() < SMALLEST or across.max() > LARGEST:
            continue
        around, sits = _around(pieces.pictures[side], *box)
        if sits < SITS:
            continue
        stands = around - float(box[0][2] - low[:, 2].min())
        found.append(Control(sorted(group), *box, stands, is_round(pieces, side, group, across)))
    found.sort(key=lambda c: (-round(float(c.middle[1]), 3), round(float(c.middle[0]), 3)))
    return found


def facing(pieces: Pieces, side: int, control: Control) -> Floats:
    """(3,) unit direction that a control faces, in the frame: that of its flat cap, else of the side."""
    outward: Floats = -SIDES[side][2]
    rows = pieces.faces_of(control.fragments)
    normals, areas = pieces.soup.normals[rows], pieces.soup.areas[rows]
    ahead = normals @ outward > TILT
    if not ahead.any():
        return outward
    normals, areas = normals[ahead], areas[ahead]
    share = (normals @ normals.T > FLAT).astype(np.float64) @ areas / max(float(areas.sum()), 1e-18)
    best = int(np.argmax(np.round(share, 9)))
    if share[best] < CAP or float(normals[best] @ outward) > FLAT:
        return outward
    cap = (areas[:, None] * normals)[normals @ normals[best] > FLAT].sum(axis=0)
    found: Floats = cap / np.linalg.norm(cap)
    return found


def is_free(pieces: Pieces, side: int, control: Control) -> bool:
    """Whether fingers get round a control: little of what is near it stands as far out."""
    picture = pieces.pictures[side]
    near = float(face_on(pieces, side)[0][:, 2].min())
    reach = ROUND_IT * control.across
    corners = np.array([control.low[:2] - reach, control.high[:2] + reach, control.low[:2], control.high[:2]])
    row, column = picture.rows_columns(corners)
    ring = np.zeros(picture.face.shape, dtype=bool)
    ring[row[1] : row[0] + 1, column[0] : column[1] + 1] = True
    ring[row[3] : row[2] + 1, column[2] : column[3] + 1] = False
    level = float(control.low[2]) - near + 0.4 * max(control.stands, 0.0)
    return bool((picture.depth[ring] <= level).mean() < HEMMED) if ring.any() else True


def _nested(low: Floats, high: Floats, rows: list[int], foot: Floats) -> list[list[int]]:
    """Groups of pieces whose middles lie within the rectangle of the group's largest, at nearly the same depth."""
    groups: list[list[int]] = []
    for i in sorted(rows, key=lambda r: (-foot[r], r)):
        middle = (low[i] + high[i]) / 2
        for g in groups:
            host = g[0]
            inside = (low[host, :2] <= middle[:2]).all() and (middle[:2] <= high[host, :2]).all()
            if inside and low[i, 2] <= high[host, 2] + 0.02 and high[i, 2] >= low[host, 2] - 0.05:
                g.append(i)
                break
        else:
            groups.append([i])
    return groups


def _around(picture: Picture, low: Floats, high: Floats) -> tuple[float, float]:
    """Depth of what is seen round a rectangle, from the nearest corner of the thing, and on how much of the way."""
    margin = np.maximum(0.25 * (high - low)[:2], 2.5 * picture.pixel)
    corners = np.array([low[:2] - margin, high[:2] + margin, low[:2] - picture.pixel, high[:2] + picture.pixel])
    row, column = picture.rows_columns(corners)
    ring = np.zeros(picture.face.shape, dtype=bool)
    ring[row[1] : row[0] + 1, column[0] : column[1] + 1] = True
    ring[row[3] : row[2] + 1, column[2] : column[3] + 1] = False
    depth = picture.depth[ring]
    seen = depth[np.isfinite(depth)]
    return (float(np.median(seen)), len(seen) / len(depth)) if len(seen) else (0.0, 0.0)


def is_round(pieces: Pieces, side: int, group: Sequence[int], across: Floats) -> bool:
    """Whether the outline is a circle, with a pointer or not."""
    if across.max() > 1.2 * across.min():
        return False
    flat = pieces.points_of(group) @ SIDES[side][:2].T
    try:
        hull = float(ConvexHull(flat).volume)
    except QhullError:
        return False
    share = hull / (np.pi / 4 * float(np.prod(across)))
    return bool(abs(share - 1.0) <= ROUND)
