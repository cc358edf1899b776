"""Probe the space behind a front with axis-parallel lines: its depth, its walls and its contents."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.plan import PartPlan
from casa_assets.articulate.segment.orthographic import RayCrossings, cross_rays, sample_grid
from casa_assets.articulate.segment.welded_mesh import WeldedMesh
from casa_assets.core.numeric import Floats, Ints, Mask

# Distance outside the edges of a front at which the body is looked for, diagonals.
BORDER_DISTANCE = 0.008
# Share of the border that has to show the body, and its greatest distance from the back of the front, diagonals.
MIN_BORDER_SHARE, MAX_BODY_DISTANCE = 0.3, 0.05
# Share of the lines that have to meet the back of an object; else its bounding box says where the back is.
MIN_BACK_SHARE = 0.5
# A surface nearer than this share of the depth is not the back.
MIN_BACK_DEPTH_SHARE = 0.4
# A mesh is inside out if this share of the first faces that lines meet faces away.
INSIDE_OUT_SHARE = 0.5
# A wall is visible over at least this share of the lines from the middle.
MIN_WALL_SHARE = 0.5
# Share of the depth behind the mouth that is free of shelves.
SHELF_FREE_SHARE = 0.04
# Distances from its border at which the back of a panel is looked for, by its narrower side; thickest rim, diagonals.
PANEL_RIM_INSETS, MAX_RIM_THICKNESS = (0.05, 0.008), 0.06
# Least size of a cavity as a share of its front; smaller ones are boards.
MIN_SIZE_SHARE = 0.25
LINES_PER_SIDE, LINES_DOWN_PER_SIDE = 7, 9
# Share of a drawer over which its floor is visible from above.
MIN_FLOOR_SHARE = 0.4


@dataclass(frozen=True)
class CavityProbe:
    """Triangles with the part of each, to be probed with lines.

    Attributes:
        points: (P, 3) in the frame. faces: (F, 3) those that have an area. owner: (F,) part of each, -1 the body.
        grip: (F,) whether it is a handle's. carried: part -> those that it carries, itself included.
        normal_sign: 1, or -1 where the faces of the mesh look inwards.
    """

    points: Floats
    faces: Ints
    owner: Ints
    grip: Ints
    carried: tuple[tuple[int, ...], ...]
    normal_sign: float

    def panel_box_of(self, part: int) -> tuple[Floats, Floats]:
        """Return the (3,) corners of a part without its handle."""
        rows = (self.owner == part) & (self.grip == 0)
        rows = rows if rows.any() else self.owner == part
        own = self.points[self.faces[rows]].reshape(-1, 3)
        return own.min(axis=0), own.max(axis=0)

    def cast_lines(self, axis: int, spots: Floats, without_parts: Sequence[int]) -> RayCrossings:
        """Intersect lines with everything but some parts and what they carry."""
        excluded = [k for i in without_parts for k in self.carried[i]]
        return self._cross(np.flatnonzero(~np.isin(self.owner, excluded)), axis, spots)

    def cast_through_panels(self, axis: int, spots: Floats, parts: Sequence[int]) -> RayCrossings:
        """Intersect lines with the panels of some parts only."""
        return self._cross(np.flatnonzero(np.isin(self.owner, list(parts)) & (self.grip == 0)), axis, spots)

    def _cross(self, rows: Ints, axis: int, spots: Floats) -> RayCrossings:
        """Intersect lines with some faces."""
        a, b = (k for k in range(3) if k != axis)
        flat = self.points[self.faces[rows]][:, :, [a, b]]
        lower, upper = spots.min(axis=0), spots.max(axis=0)
        rows = rows[((flat.min(axis=1) <= upper) & (flat.max(axis=1) >= lower)).all(axis=1)]
        found = cross_rays(self.points, self.faces[rows], axis, spots)
        return RayCrossings(found.line, found.at, found.towards * self.normal_sign, rows[found.face], found.count)

    def panel_back_depth(self, parts: Sequence[int], lower: Floats, upper: Floats) -> float:
        """Return the depth of the back of a front near its border, where nothing hangs on it."""
        narrow = float(min(upper[0] - lower[0], upper[2] - lower[2]))
        backs = []
        # A panel that is open behind, like a pan, is as thick as its rim.
        for inset in PANEL_RIM_INSETS:
            spots = border_points(lower[[0, 2]], upper[[0, 2]], inset * narrow)
            last = self.cast_through_panels(1, spots, parts).last()
            seen = last[np.isfinite(last)]
            # A box behind it reaches far back at some places only.
            backs += [float(np.percentile(seen, 30))] if len(seen) else []
        return max(
            [*backs[:1], *(b for b in backs[1:] if b <= float(lower[1]) + MAX_RIM_THICKNESS)], default=float(upper[1])
        )

    def mouth_depth(self, parts: Sequence[int], lower: Floats, upper: Floats) -> float:
        """Return the depth at which the body begins around a front, at the back of the front or behind it."""
        slab = self.panel_back_depth(parts, lower, upper)
        spots = border_points(lower[[0, 2]], upper[[0, 2]], -BORDER_DISTANCE)
        body = self._cross(np.flatnonzero(self.owner == -1), 1, spots)
        first = body.select(
            (body.at >= float(lower[1]) - MAX_BODY_DISTANCE) & (body.at <= slab + MAX_BODY_DISTANCE)
        ).first()
        seen = first[np.isfinite(first)]
        return max(slab, float(np.median(seen))) if len(seen) >= MIN_BORDER_SHARE * len(spots) else slab

    def has_stile(self, pair: Sequence[int], left: tuple[Floats, Floats], right: tuple[Floats, Floats]) -> bool:
        """Return whether the body comes forward between two panels (given by corners), or has a wall behind them."""
        x = float(left[1][0] + right[0][0]) / 2
        z = np.linspace(float(left[0][2]), float(left[1][2]), LINES_PER_SIDE + 2)[1:-1]
        first = self.cast_lines(1, np.stack([np.full(LINES_PER_SIDE, x), z], axis=1), pair).first()
        if float(np.median(first)) < float(left[0][1] + left[1][1]) / 2:
            return True
        start, end = float(left[1][1]), float(self.points[:, 1].max())
        behind = np.array([[start + 0.2 * (end - start), left[0][2]], [start + 0.7 * (end - start), left[1][2]]])
        across = self.cast_lines(0, sample_grid(behind[0], behind[1], LINES_PER_SIDE, 0.1), pair)
        inner = [float(a[0] + b[0]) / 2 for a, b in (left, right)]
        wall = across.select((across.at > inner[0]) & (across.at < inner[1])).first()
        return float(np.isfinite(wall).mean()) >= MIN_WALL_SHARE

    def back_depth(self, behind: RayCrossings, start: float) -> float:
        """Return the depth of the rearmost surface behind a front."""
        body = self.points[self.faces[self.owner == -1]].reshape(-1, 3)
        end = float(body[:, 1].max()) if len(body) else start
        last = behind.last()
        seen = last[last > start + max(MAX_BODY_DISTANCE, MIN_BACK_DEPTH_SHARE * (end - start))]
        return float(np.percentile(seen, 25)) if len(seen) >= MIN_BACK_SHARE * behind.count else end

    def visible_walls(
        self, parts: Sequence[int], lower: Floats, upper: Floats, start: float, free: float
    ) -> tuple[int, tuple[Floats, Floats]]:
        """Count the walls of left, right, floor, roof and back that are visible; return also the free box."""
        lower = np.array([lower[0], start, lower[2]])
        upper = np.array([upper[0], max(free, start + 1e-3), upper[2]])
        middle, size = (lower + upper) / 2, upper - lower
        count, out = 0, [lower.copy(), upper.copy()]
        for axis, signs in ((0, (-1.0, 1.0)), (2, (-1.0, 1.0)), (1, (1.0,))):
            a, b = (k for k in range(3) if k != axis)
            lines = self.cast_lines(axis, sample_grid(lower[[a, b]], upper[[a, b]], LINES_PER_SIDE, 0.2), parts)
            for sign in signs:
                way, looks = lines.beyond(float(middle[axis]), sign)
                near = np.isfinite(way) & (way <= 0.75 * size[axis] if axis != 1 else way < np.inf)
                count += int(float((near & looks).mean()) >= MIN_WALL_SHARE)
                if axis == 2:
                    # Shelves stand back: right behind the mouth one sees the floor and the roof.
                    rim = np.array([upper[0], start + SHELF_FREE_SHARE * size[1]])
                    edge = self.cast_lines(2, sample_grid(lower[:2], rim, LINES_PER_SIDE, 0.2), parts)
                    way, _ = edge.beyond(float(middle[2]), sign)
                    near = np.isfinite(way) & (way <= 0.5 * size[2])
                if near.any():
                    end = float(middle[axis]) + sign * float(np.percentile(way[near], 25))
                    k = int(sign > 0)
                    out[k][axis] = min(out[k][axis], end) if sign > 0 else max(out[k][axis], end)
            if out[1][axis] - out[0][axis] < MIN_SIZE_SHARE * size[axis]:
                # The middle lies in a shelf.
                out[0][axis], out[1][axis] = lower[axis], upper[axis]
        return count, (out[0], out[1])

    def drawer_space(self, part: int, front: float) -> tuple[Floats, Floats] | None:
        """Return the (3,) corners of the space in a drawer behind its front, None if it is closed from above."""
        lower, upper = self.panel_box_of(part)
        lower = np.array([lower[0], front, lower[2]])
        down = self.cast_through_panels(2, sample_grid(lower[:2], upper[:2], LINES_DOWN_PER_SIDE, 0.12), (part,))
        top = down.last()
        seen = np.isfinite(top)
        deep = seen & (top <= lower[2] + 0.5 * (upper[2] - lower[2]))
        if float(deep.mean()) < MIN_FLOOR_SHARE:
            return None
        floor = float(np.median(top[deep]))
        inset = 0.06 * (upper - lower)
        return np.array([lower[0] + inset[0], lower[1] + inset[1], floor]), np.array(
            [upper[0] - inset[0], upper[1] - inset[1], upper[2] - 0.1 * (upper[2] - floor)]
        )


def make_probe(mesh: WeldedMesh, parts: Sequence[PartPlan]) -> CavityProbe:
    """Return the probe of a mesh and its parts."""
    owner = np.full(len(mesh.faces), -1, dtype=np.int64)
    grip = np.zeros(len(mesh.faces), dtype=np.int64)
    for i, part in enumerate(parts):
        owner[part.faces] = i
        grip[part.grip] = 1
    names = [p.name for p in parts]
    parent = [names.index(p.parent) if p.parent in names else -1 for p in parts]
    carried = tuple(tuple(k for k in range(len(parts)) if _is_on(k, i, parent)) for i in range(len(parts)))
    rows = np.flatnonzero(mesh.areas > 0.0)
    sign = _turned(mesh.points, mesh.faces[rows])
    return CavityProbe(mesh.points, mesh.faces[rows], owner[rows], grip[rows], carried, sign)


def _is_on(part: int, host: int, parent: Sequence[int]) -> bool:
    """Return whether a part is another part, or is carried by it."""
    while part >= 0:
        if part == host:
            return True
        part = parent[part]
    return False


def _turned(points: Floats, faces: Ints) -> float:
    """Return -1 where most of the surface met from outside faces away, so that the mesh is inside out; else 1."""
    lower, upper = points.min(axis=0), points.max(axis=0)
    away: list[Mask] = []
    for axis in range(3):
        a, b = (k for k in range(3) if k != axis)
        spots = sample_grid(lower[[a, b]], upper[[a, b]], 2 * LINES_PER_SIDE, 0.05)
        lines = cross_rays(points, faces, axis, spots)
        for sign, start in ((1.0, float(lower[axis]) - 1.0), (-1.0, float(upper[axis]) + 1.0)):
            way, looks = lines.beyond(start, sign)
            away.append(~looks[np.isfinite(way)])
    found = np.concatenate(away)
    return -1.0 if len(found) and float(found.mean()) > INSIDE_OUT_SHARE else 1.0


def border_points(lower: Floats, upper: Floats, inset: float) -> Floats:
    """Return (N, 2) points along the border of a rectangle, moved inwards."""
    a, b = lower + inset, upper - inset
    # The ends lie a little inside the corners, so that no line runs along an edge.
    share = np.linspace(0.003, 0.9961, LINES_PER_SIDE)
    x, z = a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])
    level = [np.stack([x, np.full(LINES_PER_SIDE, end)], axis=1) for end in (a[1], b[1])]
    upright = [np.stack([np.full(LINES_PER_SIDE, end), z], axis=1) for end in (a[0], b[0])]
    return np.concatenate([*level, *upright])
