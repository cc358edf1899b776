"""What the six sides of a thing look like, as numbers: evidence for which of them is the front and which the top."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.pieces import SIDES, Pieces, face_on
from casa_assets.articulate.raster import Picture
from casa_assets.articulate.soup import Bools, Floats

# A step in depth between neighbouring pixels that counts as an edge, diagonals; a bend, cosine of 25 degrees.
STEP, BEND = 0.004, 0.906

FEATURES = (
    "front_detail",
    "back_detail",
    "top_detail",
    "bottom_detail",
    "front_panels",
    "back_panels",
    "front_stands",
    "back_stands",
    "top_stands",
    "front_mirror",
    "top_mirror",
    "side_mirror",
    "height",
    "width",
    "bottom_flat",
    "top_flat",
    "low_mass",
    "bottom_wide",
    "front_flat",
    "level_bars",
    "inside_level",
    "inside_upright",
)


@dataclass(frozen=True)
class Side:
    """One side, in its own picture.

    Attributes:
        detail: share of its pixels that are edges of depth, bend or piece.
        panels: share of its rectangle that thin pieces near it cover.
        stands: share of its pixels that stand out before most of it.
        mirror: (2,) how alike it is to its mirror image, left to right and top to bottom, 0..1.
        flat: share of its rectangle that lies within a fiftieth of the depth from its nearest.
        wide: least extent of what is nearest, as a part of the rectangle's.
        bars: long things that stand out: those along right less those along up, -1..1.
    """

    detail: float
    panels: float
    stands: float
    mirror: tuple[float, float]
    flat: float
    wide: float
    bars: float


def look(pieces: Pieces, side: int) -> Side:
    """Measure one side; the thing has a diagonal of 1."""
    picture = pieces.pictures[side]
    seen = np.isfinite(picture.depth)
    depth = np.where(seen, picture.depth, 1.0)
    edges = _edges(pieces, picture, seen, depth)
    low, high = face_on(pieces, side)
    size = high - low
    whole = high.max(axis=0) - low.min(axis=0)
    thin = (size[:, 2] < 0.2 * size[:, :2].min(axis=1)) & (low[:, 2] - low[:, 2].min() < 0.15 * whole[2])
    thin &= size[:, :2].max(axis=1) > 0.05
    panels = float(pieces.seen[thin, side].sum() / max(whole[0] * whole[1], 1e-12))
    near = seen & (depth < 0.02 * max(float(whole[2]), 1e-9))
    middle = float(np.median(depth[seen])) if seen.any() else 0.0
    out = seen & (depth < middle - 0.008)
    return Side(
        detail=float(edges.sum() / max(int(seen.sum()), 1)),
        panels=panels,
        stands=float(out.sum() / max(int(seen.sum()), 1)) if middle > 0.008 else 0.0,
        mirror=(_alike(depth, edges, 1), _alike(depth, edges, 0)),
        flat=float(near.mean()),
        wide=_spread(near),
        bars=_bars(size, low, whole),
    )


def _edges(pieces: Pieces, picture: Picture, seen: Bools, depth: Floats) -> Bools:
    """(H, W) pixels that differ from the one to the right or below in depth, direction or piece."""
    normals = pieces.soup.normals[np.maximum(picture.face, 0)]
    label = np.where(seen, pieces.label[np.maximum(picture.face, 0)], -1)
    out: Bools = np.zeros(picture.face.shape, dtype=bool)
    for axis in (0, 1):
        a: list[slice] = [slice(None), slice(None)]
        b: list[slice] = [slice(None), slice(None)]
        a[axis], b[axis] = slice(None, -1), slice(1, None)
        here, there = tuple(a), tuple(b)
        bend = np.abs((normals[here] * normals[there]).sum(axis=2)) < BEND
        step = np.abs(depth[here] - depth[there]) > STEP
        piece = (label[here] != label[there]) & (bend | step | (np.abs(depth[here] - depth[there]) > STEP / 8))
        out[here] |= (bend | step | piece) & (seen[here] | seen[there])
    return out


def _alike(depth: Floats, edges: Bools, axis: int) -> float:
    """How alike a picture is to its mirror image: of depth and of edges, which may be a pixel off."""
    other = np.flip(depth, axis=axis)
    same = float((np.abs(depth - other) < 0.01).mean())
    thick = edges.copy()
    for k in (0, 1):
        thick |= np.roll(edges, 1, axis=k) | np.roll(edges, -1, axis=k)
    hit = float((edges & np.flip(thick, axis=axis)).sum() / max(int(edges.sum()), 1))
    return 0.5 * same + 0.5 * hit


def _spread(near: Bools) -> float:
    """The lesser of the extents of some pixels along the two sides of the picture, 0..1."""
    rows, columns = np.flatnonzero(near.any(axis=1)), np.flatnonzero(near.any(axis=0))
    if not len(rows):
        return 0.0
    height, width = near.shape
    return float(min((rows[-1] - rows[0] + 1) / height, (columns[-1] - columns[0] + 1) / width))


def _bars(size: Floats, low: Floats, whole: Floats) -> float:
    """Balance of long thin things near a side: along right, less those along up."""
    near = low[:, 2] - low[:, 2].min() < 0.08 * whole[2] + 0.02
    level = near & (size[:, 0] > 4 * size[:, 1]) & (size[:, 0] > 0.08) & (size[:, 2] < 0.12)
    upright = near & (size[:, 1] > 4 * size[:, 0]) & (size[:, 1] > 0.08) & (size[:, 2] < 0.12)
    a, b = float(size[level, 0].sum()), float(size[upright, 1].sum())
    return (a - b) / max(a + b, 0.2)


def evidence(pieces: Pieces, sides: list[Side], front: int, top: int) -> Floats:
    """(len(FEATURES),) numbers that speak for these sides being front and top.

    Args:
        sides: of all six, as `look` measures them.
    """
    back, bottom = front ^ 1, top ^ 1
    up, into = -SIDES[top][2], SIDES[front][2]
    across = np.abs(np.cross(into, up))
    low, high = pieces.low.min(axis=0), pieces.high.max(axis=0)
    extent = high - low
    height, width, depth = (float(np.abs(a) @ extent) for a in (up, across, into))
    flipped = 1 if abs(float(SIDES[front][1] @ up)) > 0.5 else 0
    over = 1 if abs(float(SIDES[top][0] @ across)) > 0.5 else 0
    left = _side_of(np.cross(up, into))
    edge = 1 if abs(float(SIDES[left][0] @ into)) > 0.5 else 0
    centers = (pieces.low + pieces.high) / 2
    level = ((centers - (low + high) / 2) @ up) / max(height, 1e-9)
    inside = hidden_area(pieces)
    total = max(sum(s.detail for s in sides), 1e-9)
    a, t = sides[front], sides[top]
    return np.array(
        [
            a.detail / total,
            sides[back].detail / total,
            t.detail / total,
            sides[bottom].detail / total,
            a.panels,
            sides[back].panels,
            a.stands,
            sides[back].stands,
            t.stands,
            a.mirror[0 if flipped else 1],
            t.mirror[0 if over else 1],
            sides[left].mirror[0 if edge else 1],
            np.log(max(height, 1e-3) / max(width, depth, 1e-3)),
            np.log(max(width, 1e-3) / max(depth, 1e-3)),
            sides[bottom].flat,
            t.flat,
            float((level * pieces.area).sum() / max(float(pieces.area.sum()), 1e-12)),
            sides[bottom].wide,
            a.flat,
            a.bars if flipped else -a.bars,
            float(inside @ np.abs(up)),
            float(inside @ np.abs(into)),
        ]
    )


def hidden_area(pieces: Pieces) -> Floats:
    """(3,) share of the surface that no side shows, by the axis that it faces: shelves and racks lie level."""
    shown = np.zeros(len(pieces.label), dtype=bool)
    for picture in pieces.pictures:
        shown[picture.face[picture.face >= 0]] = True
    weight = np.where(shown, 0.0, pieces.soup.areas)
    aligned = np.abs(pieces.soup.normals) > 0.9
    found: Floats = (aligned * weight[:, None]).sum(axis=0) / max(float(pieces.soup.areas.sum()), 1e-12)
    return found


def _side_of(into: Floats) -> int:
    """The side that one sees looking along a direction."""
    return int(np.argmax(SIDES[:, 2] @ into))
