"""Changes of how parts are modelled: what they touch, what stands on them and what is behind them.

Each takes a labelled mesh and a random generator and returns a labelled mesh in which the motion of the parts is the
same; lengths are shares of the diagonal.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import manifold3d
import numpy as np

from benchmarks.articulate.cases.labelled import CONTROLS, FRONTS, LabelledMesh
from casa_assets.articulate.segment.orthographic import render_depth
from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.surface import face_normals
from casa_assets.mesh.topology import face_components, weld

# A direction that is nearer to an axis than this cosine is along it.
SNAP_COSINE = 0.94
# Pixels along the longer side of the picture of a part, and the share of its pixels that a level of a front has.
LOOK_PX, LEVEL_SHARE = 128, 0.12
# How far a sheet reaches beyond the parts in it.
MARGIN = 0.02
# Parts whose backs lie within this of each other share a sheet.
SAME_PLANE = 0.004
# What of a part lies deeper than this behind the deepest level that is seen of it is its back.
BACK = 0.002
# A sheet lies this much above the surface that it stands for.
ABOVE = 1e-4
# Thickness of a control that is printed on a surface.
PRINTED = 0.001
# A piece of a front is a handle where so much of its area stands before the front, and it is no more than that share
# of the part's.
BEFORE, HANDLE_SHARE = 0.9, 0.3
# Points nearer than this are the same corner of an outline.
SAME_POINT = 1e-6


@dataclass(frozen=True)
class Facing:
    """A part as it is seen from where it opens or is pressed.

    Attributes:
        part: identifier. axes: (3, 3) rows: right, up, out of the surface.
        level: height of the front along the outward axis. deepest: height of the lowest spot that is seen of it.
        bottom: height of its lowest point. handles and what else stands before the front lie above `level`.
    """

    part: int
    axes: Floats
    level: float
    deepest: float
    bottom: float


def outward(mesh: LabelledMesh, row: dict[str, Any]) -> Floats | None:
    """Unit vector out of the surface that a part sits in, None where its kind has none."""
    joint, kind = row["joint"], row["type"]
    axis = np.asarray(joint["axis"], dtype=np.float64)
    axis /= np.linalg.norm(axis)
    low, high = joint["range"] or (0.0, 1.0)
    opening = axis * (1.0 if abs(high) >= abs(low) else -1.0)
    used = mesh.points[mesh.faces].reshape(-1, 3)
    cloud = mesh.points[mesh.faces[mesh.part == row["id"]]].reshape(-1, 3)
    middle = (used.min(axis=0) + used.max(axis=0)) / 2
    center = (cloud.min(axis=0) + cloud.max(axis=0)) / 2
    if kind == "drawer":
        found = opening
    elif kind == "button":
        found = -opening if (center - middle) @ -opening > 0 else opening
    elif kind == "knob":
        found = axis if (center - middle) @ axis > 0 else -axis
    elif kind in FRONTS and joint["type"] != "prismatic":
        found = _across_leaf(cloud, np.cross(opening, center - np.asarray(joint["origin"], dtype=np.float64)))
    elif kind in FRONTS and mesh.direction("front") is not None:
        found = mesh.direction("front")
    else:
        return None
    length = float(np.linalg.norm(found))
    if length < 1e-9:
        return None
    found = found / length
    up, front = mesh.direction("up"), mesh.direction("front")
    if kind in CONTROLS and up is not None and found @ up < -SNAP_COSINE:
        found = -found
    if kind == "door" and front is not None and found @ front < -SNAP_COSINE:
        found = -found
    nearest = int(np.abs(found).argmax())
    return np.eye(3)[nearest] * np.sign(found[nearest]) if abs(found[nearest]) > SNAP_COSINE else found


def _across_leaf(cloud: Floats, way: Floats) -> Floats:
    """The direction in which a leaf moves at first, along its thinnest side where it is thin."""
    size = np.ptp(cloud, axis=0)
    order = np.argsort(size)
    if size[order[0]] < 0.4 * size[order[1]] and abs(way[order[0]]) > 0.02 * np.linalg.norm(way):
        return np.eye(3)[order[0]] * np.sign(way[order[0]])
    return way


def facing(mesh: LabelledMesh, row: dict[str, Any]) -> Facing | None:
    """How a part is seen from outside, None where it cannot be said or none of it is there."""
    faces = mesh.faces[mesh.part == row["id"]]
    if not len(faces):
        return None
    out = outward(mesh, row)
    if out is None:
        return None
    right = np.cross(np.eye(3)[2] if abs(out[2]) < 0.9 else np.eye(3)[1], out)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(out, right), out])
    used, at = np.unique(faces, return_inverse=True)
    points = mesh.points[used]
    image = render_depth(points, at.reshape(-1, 3), np.stack([-axes[0], axes[1], -axes[2]]), LOOK_PX)
    height = points @ axes[2]
    seen = height.max() - image.depth[image.face >= 0]
    step = 0.002 * mesh.diagonal
    bins = np.floor((seen - seen.min()) / step).astype(np.int64)
    share = np.bincount(bins) / len(bins)
    spread = share + np.append(share[1:], 0.0)
    level = int(np.flatnonzero(spread >= min(LEVEL_SHARE, spread.max()))[-1])
    near = seen[(bins >= level) & (bins <= level + 1)]
    return Facing(row["id"], axes, float(near.max()), float(np.quantile(seen, 0.005)), float(height.min()))


def no_handles(mesh: LabelledMesh, rng: np.random.Generator) -> LabelledMesh:
    """Doors, drawers and lids without what one grips them by: what is labelled, else pieces before the front."""
    gone = mesh.handle.copy()
    _, place = weld(mesh.points)
    label = face_components(place[mesh.faces], int(place.max()) + 1)
    areas = mesh.areas
    for row in mesh.parts:
        mine = mesh.part == row["id"]
        if row["type"] not in FRONTS or (gone & mine).any():
            continue
        seen = facing(mesh, row)
        if seen is None:
            continue
        before = (mesh.points[mesh.faces].mean(axis=1) @ seen.axes[2]) > seen.level
        for piece in np.unique(label[mine]).tolist():
            of = mine & (label == piece)
            small = areas[of].sum() < HANDLE_SHARE * areas[mine].sum()
            if small and areas[of & before].sum() > BEFORE * areas[of].sum():
                gone |= of
    for row in mesh.parts:  # of a part that is nothing but a handle it stays
        mine = mesh.part == row["id"]
        if areas[mine & ~gone].sum() < 0.3 * areas[mine].sum():
            gone &= ~mine
    return mesh.with_faces(~gone)


def flat_controls(mesh: LabelledMesh, rng: np.random.Generator) -> LabelledMesh:
    """Buttons and knobs pressed flat onto the surface around them, as if they were printed on it."""
    points, thin = mesh.points.copy(), PRINTED * mesh.diagonal
    for row in mesh.parts:
        seen = facing(mesh, row) if row["type"] in CONTROLS else None
        if seen is None:
            continue
        used = np.unique(mesh.faces[mesh.part == seen.part])
        shared = np.unique(mesh.faces[mesh.part != seen.part])
        used = np.setdiff1d(used, shared)
        height = points[used] @ seen.axes[2]
        ground = _surface_around(mesh, seen)
        share = np.clip((height - ground) / max(float(height.max()) - ground, 1e-300), 0.0, 1.0)
        points[used] += np.outer(ground + thin * share - height, seen.axes[2])
    return mesh.with_points(points)


def _surface_around(mesh: LabelledMesh, seen: Facing) -> float:
    """Height of what is seen close around a part; the lowest visible spot of the part where there is nothing."""
    flat = mesh.points @ seen.axes.T
    mine = mesh.part == seen.part
    own = flat[mesh.faces[mine]].reshape(-1, 3)
    low, high = own[:, :2].min(axis=0), own[:, :2].max(axis=0)
    reach = 0.35 * (high - low) + 0.002 * mesh.diagonal
    corners = flat[mesh.faces][..., :2]
    near = ((corners.max(axis=1) > low - reach) & (corners.min(axis=1) < high + reach)).all(axis=1) & ~mine
    near &= flat[mesh.faces][..., 2].min(axis=1) < own[:, 2].max()
    if not near.any():
        return seen.deepest
    spots = np.stack(np.meshgrid(*(np.linspace(a - r, b + r, 12) for a, b, r in zip(low, high, reach, strict=True))))
    spots = spots.reshape(2, -1).T
    spots = spots[((spots < low) | (spots > high)).any(axis=1)]
    heights = _heights(flat, mesh.faces[near], spots)
    heights = heights[np.isfinite(heights) & (heights < own[:, 2].max())]
    if not len(heights):
        return seen.deepest
    return float(np.clip(np.median(heights), own[:, 2].min(), own[:, 2].max()))


def _heights(flat: Floats, faces: Ints, spots: Floats) -> Floats:
    """(N,) height of the highest face over each of (N, 2) spots, minus infinity where there is none."""
    found = np.full(len(spots), -np.inf)
    corners = flat[faces]
    for i, spot in enumerate(spots):
        a, b, c = (corners[:, k, :2] - spot for k in range(3))
        weights = np.stack([_cross(b, c), _cross(c, a), _cross(a, b)], axis=1)
        total = weights.sum(axis=1)
        inside = ((weights >= 0).all(axis=1) | (weights <= 0).all(axis=1)) & (np.abs(total) > 1e-300)
        if inside.any():
            level = (weights[inside] * corners[inside, :, 2]).sum(axis=1) / total[inside]
            found[i] = level.max()
    return found


def _cross(a: Floats, b: Floats) -> Floats:
    out: Floats = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return out


def box_drawers(mesh: LabelledMesh, rng: np.random.Generator) -> LabelledMesh:
    """Drawers are closed boxes behind their fronts; what was modelled inside of them is not there."""
    for row in mesh.parts:
        seen = facing(mesh, row) if row["type"] == "drawer" else None
        if seen is None:
            continue
        mine = mesh.part == seen.part
        flat = mesh.points @ seen.axes.T
        top = flat[mesh.faces][..., 2].max(axis=1)
        stays = mine & (flat[mesh.faces][..., 2].min(axis=1) > seen.level - 0.25 * BACK * mesh.diagonal)
        stays |= mine & mesh.handle
        rest = mine & ~stays
        if not rest.any():
            continue
        cloud = flat[mesh.faces[rest]].reshape(-1, 3)
        low, high = cloud.min(axis=0), cloud.max(axis=0)
        high[2] = min(float(high[2]), seen.level)
        slab = seen.level - max(0.012 * mesh.diagonal, 1.5 * (seen.level - seen.deepest))
        boxes = [(np.array([low[0], low[1], max(low[2], slab)]), high)]
        behind = flat[mesh.faces[rest & (top < slab)]].reshape(-1, 3)
        if low[2] < slab and len(behind):
            boxes.append((behind.min(axis=0), np.array([*behind.max(axis=0)[:2], slab])))
        mesh = mesh.with_faces(~rest)
        for one in boxes:
            points, faces = box(*one)
            mesh = mesh.added(points @ seen.axes, faces, seen.part)
    return mesh


def box(low: Floats, high: Floats) -> tuple[Floats, Ints]:
    """A closed box between two corners, faces outward."""
    points = np.array([[x, y, z] for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])])
    quads = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    return points, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], dtype=np.int64)


def coincident(mesh: LabelledMesh, rng: np.random.Generator) -> LabelledMesh:
    """The body has a copy of the back of each front, reversed: two faces at the same positions."""
    for row in mesh.parts:
        seen = facing(mesh, row) if row["type"] in FRONTS else None
        if seen is None:
            continue
        normals, areas = face_normals(mesh.points, mesh.faces)
        flat = (np.abs(normals @ seen.axes[2]) > 0.95) & (mesh.part == seen.part)
        height = mesh.points[mesh.faces].mean(axis=1) @ seen.axes[2]
        behind = flat & (height < seen.deepest - 1e-4 * mesh.diagonal) & (height > seen.level - 0.06 * mesh.diagonal)
        if not behind.any():
            continue
        bins = np.round(height / (1e-3 * mesh.diagonal)).astype(np.int64)
        _, at = np.unique(bins[behind], return_inverse=True)
        rows = np.flatnonzero(behind)[at == int(np.bincount(at, weights=areas[behind]).argmax())]
        mesh = mesh.added(mesh.points, mesh.faces[rows][:, ::-1], 0)
    return mesh


def touching(mesh: LabelledMesh, rng: np.random.Generator) -> LabelledMesh:
    """Parts without backs whose rims are corners of sheets of the body around them, as pushing and pulling leaves them.

    A part is cut where its back begins; what is behind goes, of a drawer in every other case only its front's back. The
    body gets a flat sheet with a hole for each part, and the corners of the hole are exactly those of the part.
    """
    unit = mesh.diagonal
    mesh = mesh.with_points(mesh.points / unit)
    keeps_boxes = rng.random() < 0.5
    cuts: list[tuple[Facing, float]] = []
    for row in mesh.parts:
        seen = facing(mesh, row) if row["type"] in (*FRONTS, *CONTROLS) else None
        if seen is None:
            continue
        most = seen.level - ABOVE if row["type"] in CONTROLS else seen.deepest - BACK
        least = seen.bottom + 1e-5
        if row["type"] in FRONTS:
            most = max(most, min(least, seen.level - ABOVE))
        if most < least:  # a flat part has no back
            continue
        height = float(np.clip(_surface_around(mesh, seen) + ABOVE, least, most))
        cuts.append((seen, height))
    for group in _planes(cuts):
        mesh = _sheet(mesh, group, [seen for seen, _ in cuts], keeps_boxes)
    return mesh.with_points(mesh.points * unit)


def _planes(cuts: list[tuple[Facing, float]]) -> list[list[tuple[Facing, float]]]:
    """Parts that face one way and can be cut at one height, with that height."""
    groups: list[list[tuple[Facing, float]]] = []
    for seen, height in sorted(cuts, key=lambda c: -c[1]):
        for group in groups:
            other, level = group[0]
            same_way = float(other.axes[2] @ seen.axes[2]) > 1 - 1e-9
            if same_way and abs(level - height) < SAME_PLANE and seen.bottom < level < seen.deepest + 1e-9:
                group.append((seen, level))
                break
        else:
            groups.append([(seen, height)])
    return groups


def _sheet(
    mesh: LabelledMesh, group: list[tuple[Facing, float]], every: list[Facing], keeps_boxes: bool
) -> LabelledMesh:
    """Cut the parts of a group and put a sheet of the body around them, but not before other parts."""
    axes, level = group[0][0].axes, group[0][1]
    corners: list[Floats] = []
    regions: list[manifold3d.CrossSection] = []
    margins: list[manifold3d.CrossSection] = []
    kinds = {p["id"]: p["type"] for p in mesh.parts}
    for seen, _ in group:
        flat, others = mesh.points @ axes.T, mesh.faces[mesh.part != seen.part]
        mesh, segments = _cut(mesh, seen, level, keeps_boxes and kinds[seen.part] == "drawer")
        outline = _outline(segments)
        if outline is None:
            continue
        low, high = segments.min(axis=(0, 1)), segments.max(axis=(0, 1))
        reach = MARGIN if kinds[seen.part] in FRONTS else min(MARGIN, 0.3 * float((high - low).min()))
        corners.append(segments.reshape(-1, 2))
        regions.append(outline)
        margins.append(manifold3d.CrossSection([_rectangle(*_supported(flat, others, low, high, reach, level))]))
    if not regions:
        return mesh
    sheet = manifold3d.CrossSection.batch_boolean(margins, manifold3d.OpType.Add) - (
        manifold3d.CrossSection.batch_boolean(regions, manifold3d.OpType.Add)
    )
    own = {seen.part for seen, _ in group}
    boxes = [np.array(r.bounds()) for r in regions]
    for seen in every:
        if seen.part in own or seen.level > level or float(seen.axes[2] @ axes[2]) < 1 - 1e-9:
            continue
        cloud = (mesh.points[mesh.faces[mesh.part == seen.part].ravel()] @ axes.T)[:, :2]
        low, high = cloud.min(axis=0), cloud.max(axis=0)
        if not any((low <= b[:2]).all() and (b[2:] <= high).all() for b in boxes):  # else they sit on it
            sheet -= manifold3d.CrossSection([_rectangle(low, high)])
    if sheet.is_empty():
        return mesh
    polygons = [_with_corners(np.asarray(p), np.unique(np.concatenate(corners), axis=0)) for p in sheet.to_polygons()]
    polygons = [p for p in polygons if len(p) >= 3]
    faces = np.asarray(manifold3d.triangulate(polygons), dtype=np.int64).reshape(-1, 3)
    sheet_flat = np.concatenate(polygons)
    return mesh.added(np.column_stack([sheet_flat, np.full(len(sheet_flat), level)]) @ axes, faces, 0)


def _supported(
    flat: Floats, faces: Ints, low: Floats, high: Floats, reach: float, level: float
) -> tuple[Floats, Floats]:
    """A rectangle made larger by `reach` on the sides where there is something behind; on all a little if on none."""
    near = flat[faces]
    near_low, near_high = near[..., :2].min(axis=1), near[..., :2].max(axis=1)
    faces = faces[((near_high > low - reach) & (near_low < high + reach)).all(axis=1)]
    along = np.linspace(0.1, 0.9, 7)
    wider_low, wider_high = low.copy(), high.copy()
    for k in (0, 1):
        for sign, edge, wider in ((-1, low, wider_low), (1, high, wider_high)):
            spots = low + along[:, None] * (high - low)
            spots[:, k] = edge[k] + 0.5 * sign * reach
            heights = _heights(flat, faces, spots)
            if (np.isfinite(heights) & (heights < level + MARGIN)).mean() > 0.5:
                wider[k] += sign * reach
    if (wider_low == low).all() and (wider_high == high).all():
        return low - 0.2 * reach, high + 0.2 * reach
    return wider_low, wider_high


def _rectangle(low: Floats, high: Floats) -> list[tuple[float, float]]:
    return [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]


def _cut(mesh: LabelledMesh, seen: Facing, level: float, keeps_rest: bool) -> tuple[LabelledMesh, Floats]:
    """A part without what is below a height; the sides that its new rim has, (N, 2, 2) in the plane of the cut.

    Args:
        keeps_rest: pieces that are wholly below stay.
    """
    rows = np.flatnonzero(mesh.part == seen.part)
    height = mesh.points[mesh.faces[rows]] @ seen.axes[2] - level
    height = np.where(np.abs(height) < 1e-9, 1e-9, height)
    above = height > 0
    count = above.sum(axis=1)
    new_points, new_faces, source, segments = [], [], [], []
    size = len(mesh.points)
    at: dict[tuple[int, int], int] = {}

    def crossing(a: int, b: int) -> int:
        key = (min(a, b), max(a, b))
        if key not in at:
            p, q = mesh.points[key[0]], mesh.points[key[1]]
            one, two = p @ seen.axes[2] - level, q @ seen.axes[2] - level
            at[key] = size + len(new_points)
            new_points.append(p + (q - p) * (one / (one - two)))
        return at[key]

    for i in np.flatnonzero((count > 0) & (count < 3)).tolist():
        turn = int(np.flatnonzero(above[i] if count[i] == 1 else ~above[i])[0])
        a, b, c = np.roll(mesh.faces[rows[i]], -turn).tolist()
        one, two = crossing(a, b), crossing(a, c)
        new_faces += [(a, one, two)] if count[i] == 1 else [(one, b, c), (one, c, two)]
        source += [rows[i]] * (1 if count[i] == 1 else 2)
        segments.append((one, two))
    gone = np.zeros(len(mesh.faces), dtype=bool)
    gone[rows[count < 3]] = True
    if keeps_rest:
        label = face_components(mesh.faces, size)
        touched = np.unique(label[rows[count > 0]])
        gone &= np.isin(label, touched)
    points = np.concatenate([mesh.points, np.array(new_points).reshape(-1, 3)])
    took = np.array(source, dtype=np.int64)
    whole = LabelledMesh(
        points,
        np.concatenate([mesh.faces, np.array(new_faces, dtype=np.int64).reshape(-1, 3)]),
        np.concatenate([mesh.part, mesh.part[took]]),
        np.concatenate([mesh.handle, mesh.handle[took]]),
        mesh.truth,
    )
    keep = np.concatenate([~gone, np.ones(len(took), dtype=bool)])
    rim = np.array(segments, dtype=np.int64).reshape(-1, 2)
    return whole.with_faces(keep), (points[rim] @ seen.axes.T)[..., :2]


def _outline(segments: Floats) -> manifold3d.CrossSection | None:
    """The filled region that segments enclose, None where they do not close."""
    if len(segments) < 3:
        return None
    ends = segments.reshape(-1, 2)
    _, ids = weld(ends, SAME_POINT)
    first = np.full(int(ids.max()) + 1, -1)
    first[ids[::-1]] = np.arange(len(ids))[::-1]
    neighbours: dict[int, list[int]] = {}
    for a, b in ids.reshape(-1, 2).tolist():
        if a != b:
            neighbours.setdefault(a, []).append(b)
            neighbours.setdefault(b, []).append(a)
    loops = []
    while neighbours:
        start = next(iter(neighbours))
        loop, here = [start], start
        while neighbours.get(here):
            onward = neighbours[here].pop()
            neighbours[onward].remove(here)
            here = onward
            if here == start:
                break
            loop.append(here)
        closed = here == start and len(loop) >= 3
        neighbours = {k: v for k, v in neighbours.items() if v}
        if closed:
            loops.append(ends[first[loop]])
    shapes = [manifold3d.CrossSection([loop.tolist()], manifold3d.FillRule.NonZero) for loop in loops]
    turned = [
        manifold3d.CrossSection([loop[::-1].tolist()], manifold3d.FillRule.NonZero) if s.is_empty() else s
        for loop, s in zip(loops, shapes, strict=True)
    ]
    whole = manifold3d.CrossSection.batch_boolean(turned, manifold3d.OpType.Add) if turned else None
    if whole is None or whole.is_empty():
        return None
    return whole


def _with_corners(polygon: Floats, corners: Floats) -> Floats:
    """A polygon whose corners are moved to the given ones next to them, and that has those that lie on its sides."""
    out: list[Floats] = []
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        side = b - a
        length = float(np.linalg.norm(side))
        if length < SAME_POINT:
            continue
        along = (corners - a) @ side / length
        beside = np.abs((corners - a) @ np.array([-side[1], side[0]]) / length)
        on = np.flatnonzero((beside < SAME_POINT) & (along > SAME_POINT) & (along < length - SAME_POINT))
        distance = np.linalg.norm(corners - a, axis=1)
        out.append(corners[int(distance.argmin())] if distance.min() < 2 * SAME_POINT else a)
        out += [corners[i] for i in on[np.argsort(along[on])]]
    distinct = [p for p, q in zip(out, [*out[1:], *out[:1]], strict=True) if np.linalg.norm(p - q) > SAME_POINT]
    return np.array(distinct).reshape(-1, 2)
