"""Things that teach the frame guess.

Members of the own families as others might have left them, and plain tables and boxes of buttons. Each is one mesh that
stands upright (z up) and whose front faces -y.

Used by `benchmarks/train/frame.py`.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from casa_assets.articulate.frame import FRAME_IMAGE_PX, given_frame
from casa_assets.articulate.segment.fragments import MeasuredFragments, measure_fragments
from casa_assets.articulate.segment.welded_mesh import weld_triangles
from casa_assets.mesh.grid.voxels import boundary, voxelise
from casa_assets.mesh.topology import weld
from casa_assets.model.asset.asset import Asset

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]
Mesh = tuple[Floats, Ints]

# Files of others are not like ours: a member is stretched along its axes by so much (a spread of logarithms); some have
# lost what is inside, some the borders of their pieces, some are one shell of cubes; some stand on feet or legs, have
# slits in their back, or more on their front.
STRETCH, WITHOUT_INSIDE, IN_ONE, FUSED, WELDED = 0.13, 0.25, 0.15, 0.12, 0.5
FEET, LEGS, SLITS, KEYS = 0.25, 0.08, 0.3, 0.25
# Cubes along the longest side of a shell; vertices within this of the diagonal become one.
CELLS, WELD = 96, 1e-4
_QUADS = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


def merged(asset: Asset) -> Mesh:
    """All that is seen of an asset as one mesh: vertices and faces."""
    parts = []
    for link in asset.links:
        pose = asset.asset_from_link(link.name)
        parts += [(pose.apply(v.mesh.vertices), v.mesh.faces.astype(np.int64)) for v in link.visuals]
    return together(parts)


def together(parts: list[Mesh]) -> Mesh:
    """Several meshes as one."""
    starts = np.cumsum([0, *(len(p) for p, _ in parts[:-1])])
    return np.concatenate([p for p, _ in parts]), np.concatenate(
        [f + s for (_, f), s in zip(parts, starts.tolist(), strict=True)]
    )


def box(low: Floats, high: Floats) -> Mesh:
    """A box between two corners."""
    ends = (low, high)
    corners = [(ends[x][0], ends[y][1], ends[z][2]) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    faces = [f for a, b, c, d in _QUADS for f in ((a, b, c), (a, c, d))]
    return np.array(corners, dtype=np.float64), np.array(faces, dtype=np.int64)


def rod(low: Floats, high: Floats, axis: int, sides: int = 20) -> Mesh:
    """A cylinder that fills a box, along one of its axes."""
    angle = np.arange(sides) / sides * 2 * np.pi
    a, b = [k for k in range(3) if k != axis]
    ring = np.zeros((sides, 3))
    ring[:, a], ring[:, b] = np.cos(angle), np.sin(angle)
    middle, half = (low + high) / 2, (high - low) / 2
    ends = np.zeros((2, 3))
    ends[:, axis] = -1.0, 1.0
    points = np.concatenate([ring + ends[0], ring + ends[1], ends]) * half + middle
    one, two = np.arange(sides), (np.arange(sides) + 1) % sides
    cap = np.full(sides, 2 * sides)
    faces = np.concatenate(
        [
            np.stack([one, two, two + sides], axis=1),
            np.stack([one, two + sides, one + sides], axis=1),
            np.stack([two, one, cap], axis=1),
            np.stack([one + sides, two + sides, cap + 1], axis=1),
        ]
    )
    return points, (faces[:, ::-1] if axis == 1 else faces).astype(np.int64)


def seen(mesh: Mesh, one: bool = False) -> MeasuredFragments:
    """The pieces of a mesh that stands upright; `one` takes it all for one piece."""
    soup = weld_triangles(*mesh)
    frame = given_frame(soup, (0, 0, 1), (0, -1, 0))
    placed = soup.in_frame(frame)
    label = placed.fragment_labels
    return measure_fragments(placed, np.minimum(label, 0) if one else label, FRAME_IMAGE_PX)


def changed(mesh: Mesh, rng: np.random.Generator) -> MeasuredFragments:
    """The pieces of a mesh as another modeller might have left it."""
    points, faces = mesh
    points = points * np.exp(rng.normal(0.0, STRETCH, 3))
    points, faces = together([(points, faces), *_added(points, rng)])
    if rng.random() < WELDED:
        span = np.ptp(points, axis=0)
        points, place = weld(points, WELD * float(np.linalg.norm(span)) / float(span.max()))
        faces = place[faces]
    lot = float(rng.random())
    if lot < FUSED:
        points, faces = boundary(voxelise(points, faces, CELLS))
    elif lot < FUSED + WITHOUT_INSIDE:
        shown = seen((points, faces)).depth_images
        faces = faces[np.unique(np.concatenate([p.face[p.face >= 0] for p in shown]))]
    return seen((points, faces), one=bool(FUSED + WITHOUT_INSIDE < lot < FUSED + WITHOUT_INSIDE + IN_ONE))


def _added(points: Floats, rng: np.random.Generator) -> list[Mesh]:
    """Feet or legs, slits of the back, keys or a sign on the front."""
    low, high = points.min(axis=0), points.max(axis=0)
    size, diagonal = high - low, float(np.linalg.norm(high - low))
    out: list[Mesh] = []
    lot = float(rng.random())
    if lot < FEET + LEGS:
        tall = diagonal * float(rng.uniform(0.01, 0.03) if lot < FEET else rng.uniform(0.06, 0.3))
        wide, inset = diagonal * float(rng.uniform(0.02, 0.05)), float(rng.uniform(0.0, 0.08))
        shape = rod if rng.random() < 0.5 else box
        for x in (low[0] + inset * size[0], high[0] - inset * size[0] - wide):
            for y in (low[1] + inset * size[1], high[1] - inset * size[1] - wide):
                corners = np.array([x, y, low[2] - tall]), np.array([x + wide, y + wide, low[2]])
                out.append(rod(*corners, 2) if shape is rod else box(*corners))
    if rng.random() < SLITS:
        count, upright = int(rng.integers(3, 14)), rng.random() < 0.5
        begin, span = rng.uniform(0.1, 0.5, 2), rng.uniform(0.15, 0.4, 2)
        for k in range(count):
            share = (k + np.array([0.0, 0.5])) / count
            ends = np.array([[0.0, 1.0], share] if upright else [share, [0.0, 1.0]])
            flat = low[[0, 2]] + (begin[:, None] + span[:, None] * ends).T * size[[0, 2]]
            out.append(
                box(
                    np.array([flat[0, 0], high[1] - 1e-3 * diagonal, flat[0, 1]]),
                    np.array([flat[1, 0], high[1] + 6e-3 * diagonal, flat[1, 1]]),
                )
            )
    if rng.random() < KEYS:
        out += _keys(points, rng, diagonal)
    return out


def _keys(points: Floats, rng: np.random.Generator, diagonal: float) -> list[Mesh]:
    """Rows of keys on the front, where a keypad may be: beside or above the middle."""
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    beside = rng.random() < 0.5
    place = np.array([rng.uniform(0.7, 0.85), rng.uniform(0.2, 0.6)] if beside else [rng.uniform(0.1, 0.7), 0.88])
    step = diagonal * float(rng.uniform(0.02, 0.035))
    rows, columns = (int(rng.integers(2, 6)), 3) if beside else (1, int(rng.integers(2, 7)))
    near = float(np.quantile(points[:, 1], 0.02))
    begin = low[[0, 2]] + place * size[[0, 2]]
    return [
        box(
            np.array([begin[0] + c * step, near - 4e-3 * diagonal, begin[1] + r * step]),
            np.array([begin[0] + (c + 0.7) * step, near + 2e-2 * diagonal, begin[1] + (r + 0.6) * step]),
        )
        for r in range(rows)
        for c in range(columns)
    ]


def table(rng: np.random.Generator) -> Mesh:
    """A table with drawers under its top."""
    wide, deep, tall = float(rng.uniform(0.6, 1.8)), float(rng.uniform(0.4, 0.8)), float(rng.uniform(0.5, 0.95))
    leg, top, high = float(rng.uniform(0.03, 0.08)), float(rng.uniform(0.02, 0.05)), float(rng.uniform(0.08, 0.2))
    under = tall - top - high
    parts = [box(np.array([0.0, 0.0, tall - top]), np.array([wide, deep, tall]))]
    for x in (0.02, wide - leg - 0.02):
        for y in (0.02, deep - leg - 0.02):
            parts.append(box(np.array([x, y, 0.0]), np.array([x + leg, y + leg, tall - top])))
    parts.append(box(np.array([0.03, deep - 0.05, under]), np.array([wide - 0.03, deep - 0.03, tall - top])))
    for x in (0.03, wide - 0.05):
        parts.append(box(np.array([x, 0.04, under]), np.array([x + 0.02, deep - 0.05, tall - top])))
    count = int(rng.integers(1, 4))
    step = (wide - 0.1) / count
    for k in range(count):
        left, right = 0.05 + k * step + 0.003, 0.05 + (k + 1) * step - 0.003
        parts += drawer(np.array([left, 0.02, under + 0.003]), np.array([right, deep - 0.1, tall - top - 0.003]), rng)
    if rng.random() < 0.4:
        parts.append(box(np.array([0.04, 0.04, 0.12]), np.array([wide - 0.04, deep - 0.04, 0.14])))
    return together(parts)


def drawer(low: Floats, high: Floats, rng: np.random.Generator) -> list[Mesh]:
    """A front with a knob or a bar, and a tub behind it, in a box of which the front is the near end."""
    x0, y0, z0 = low.tolist()
    x1, y1, z1 = high.tolist()
    top = z0 + 0.8 * (z1 - z0)
    middle, level = (x0 + x1) / 2, z0 + float(rng.uniform(0.45, 0.75)) * (z1 - z0)
    grip = 0.4 * (x1 - x0) if rng.random() < 0.5 else 0.03
    slabs = [
        ((x0, y0, z0), (x1, y0 + 0.02, z1)),
        ((x0 + 0.01, y0 + 0.02, z0 + 0.01), (x1 - 0.01, y1, z0 + 0.02)),
        ((x0 + 0.01, y0 + 0.02, z0 + 0.02), (x0 + 0.02, y1, top)),
        ((x1 - 0.02, y0 + 0.02, z0 + 0.02), (x1 - 0.01, y1, top)),
        ((x0 + 0.02, y1 - 0.01, z0 + 0.02), (x1 - 0.02, y1, top)),
        ((middle - grip / 2, y0 - 0.035, level - 0.01), (middle + grip / 2, y0, level + 0.01)),
    ]
    return [box(np.array(a), np.array(b)) for a, b in slabs]


def panel(rng: np.random.Generator, on_top: bool) -> Mesh:
    """A box of buttons or knobs, on its top or on its front."""
    size = np.array([rng.uniform(0.1, 0.6), rng.uniform(0.08, 0.4), rng.uniform(0.03, 0.12)])
    parts = [box(np.zeros(3), size)]
    if not on_top:
        size = size[[0, 2, 1]]
        parts = [box(np.zeros(3), size)]
    face = size[:2] if on_top else size[[0, 2]]
    wide = float(face.min()) * float(rng.uniform(0.12, 0.3))
    tall = wide * float(rng.uniform(0.2, 1.0))
    columns = int(rng.integers(1, max(2, int(face[0] / (1.6 * wide)) + 1)))
    rows = int(rng.integers(1, max(2, int(face[1] / (1.6 * wide)) + 1)))
    for c in range(columns):
        for r in range(rows):
            u, v = face * (np.array([c, r]) + 0.5) / np.array([columns, rows])
            if on_top:
                ends = (
                    np.array([u - wide / 2, v - wide / 2, size[2]]),
                    np.array([u + wide / 2, v + wide / 2, size[2] + tall]),
                )
            else:
                ends = np.array([u - wide / 2, -tall, v - wide / 2]), np.array([u + wide / 2, 0.0, v + wide / 2])
            parts.append(rod(*ends, 2 if on_top else 1))
    return together(parts)
