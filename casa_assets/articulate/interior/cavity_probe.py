"""Probe the space behind an opening: the largest free box, within covers, frames and skins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.plan import Cavity, InteriorKind, PartPlan, to_vec3
from casa_assets.articulate.segment.fragments import WeldedMesh
from casa_assets.articulate.segment.orthographic import RayCrossings, cross_rays, sample_grid
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.model.record import Vec3

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
PROBE_LINES_PER_SIDE, LINES_DOWN_PER_SIDE = 7, 9
# Share of a drawer over which its floor is visible from above.
MIN_FLOOR_SHARE = 0.4
# Lines across a front, each way, to find its open part; a row open to this share of the most open one is no frame.
FINE_LINES_PER_SIDE, OPEN_BORDER_SHARE = 24, 0.7
# Narrowest frame, diagonals.
MIN_FRAME_WIDTH = 0.006
# Distance of built walls from the skin, diagonals, and the share by which a cavity shrinks while it pierces the skin.
SKIN_DISTANCE, SHRINK_SHARE, MAX_SHRINKS = 0.004, 0.06, 8
# A cavity has contents if this share of the lines meets something.
MIN_CONTENTS_SHARE = 0.25
# A rectangular front covers this share of a line inside its border (inset by a share of its size); a round one is
# shrunk by the last share on every side until it does.
MIN_BORDER_COVERAGE, BORDER_INSET_SHARE, ROUND_SHRINK_SHARE = 0.85, 0.02, 0.03
# Margin of the boxes in which the body has nothing to be, within a panel, diagonals.
PANEL_MARGIN = 0.001
# Lines to each side of a cavity, each way.
LINES_PER_SIDE = 5
# A line whose last surface is nearer than this share of the median left through a hole of the skin.
HOLE_DISTANCE_SHARE = 0.45


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
    carried: Sequence[Sequence[int]]
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
        z = np.linspace(float(left[0][2]), float(left[1][2]), PROBE_LINES_PER_SIDE + 2)[1:-1]
        first = self.cast_lines(1, np.stack([np.full(PROBE_LINES_PER_SIDE, x), z], axis=1), pair).first()
        if float(np.median(first)) < float(left[0][1] + left[1][1]) / 2:
            return True
        start, end = float(left[1][1]), float(self.points[:, 1].max())
        behind = np.array([[start + 0.2 * (end - start), left[0][2]], [start + 0.7 * (end - start), left[1][2]]])
        across = self.cast_lines(0, sample_grid(behind[0], behind[1], PROBE_LINES_PER_SIDE, 0.1), pair)
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
            lines = self.cast_lines(axis, sample_grid(lower[[a, b]], upper[[a, b]], PROBE_LINES_PER_SIDE, 0.2), parts)
            for sign in signs:
                way, looks = lines.beyond(float(middle[axis]), sign)
                near = np.isfinite(way) & (way <= 0.75 * size[axis] if axis != 1 else way < np.inf)
                count += int(float((near & looks).mean()) >= MIN_WALL_SHARE)
                if axis == 2:
                    # Shelves stand back: right behind the mouth one sees the floor and the roof.
                    rim = np.array([upper[0], start + SHELF_FREE_SHARE * size[1]])
                    edge = self.cast_lines(2, sample_grid(lower[:2], rim, PROBE_LINES_PER_SIDE, 0.2), parts)
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
    carried: list[list[int]] = [[] for _ in parts]
    for k in range(len(parts)):
        host = k
        while host >= 0:
            carried[host].append(k)
            host = parent[host]
    rows = np.flatnonzero(mesh.areas > 0.0)
    sign = _turned(mesh.points, mesh.faces[rows])
    return CavityProbe(mesh.points, mesh.faces[rows], owner[rows], grip[rows], carried, sign)


def _turned(points: Floats, faces: Ints) -> float:
    """Return -1 where most of the surface met from outside faces away, so that the mesh is inside out; else 1."""
    lower, upper = points.min(axis=0), points.max(axis=0)
    away: list[Mask] = []
    for axis in range(3):
        a, b = (k for k in range(3) if k != axis)
        spots = sample_grid(lower[[a, b]], upper[[a, b]], 2 * PROBE_LINES_PER_SIDE, 0.05)
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
    share = np.linspace(0.003, 0.9961, PROBE_LINES_PER_SIDE)
    x, z = a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])
    level = [np.stack([x, np.full(PROBE_LINES_PER_SIDE, end)], axis=1) for end in (a[1], b[1])]
    upright = [np.stack([np.full(PROBE_LINES_PER_SIDE, end), z], axis=1) for end in (a[0], b[0])]
    return np.concatenate([*level, *upright])


def fit_cavity(
    probe: CavityProbe,
    part_ids: Sequence[int],
    panel_box: tuple[Floats, Floats],
    mouth: float,
    back: float,
    wall: float,
    interior: InteriorKind,
    is_closed: bool,
) -> Cavity:
    """Return the largest cavity behind a front.

    Args:
        part_ids: places of its parts. panel_box: their corners without handles.
        mouth, back: depths between which the body lies. wall: thickness of what is built round it.
        is_closed: the body is solid there, or closed off: it is cut open.
    """
    lower, upper = _shrink_to_covered(probe, part_ids, *panel_box)
    lower[1], upper[1] = mouth, back - max(wall, SKIN_DISTANCE)
    lower[[0, 2]] += wall
    upper[[0, 2]] -= wall
    if not is_closed:
        lower, upper = _shrink_to_frame(probe, part_ids, panel_box, mouth, lower, upper)
    outer_low, outer_high = _shrink_to_skin(probe, part_ids, lower - wall, upper + wall)
    # The front of what is built lies in the mouth.
    outer_low[1] = mouth
    # The least thickness of a wall is a share of the usual one.
    inner_low, inner_high = np.maximum(lower, outer_low + 0.3 * wall), np.minimum(upper, outer_high - 0.3 * wall)
    inner_low[1] = mouth
    cut = None
    if is_closed:
        half = 0.5 * np.minimum(inner_low - outer_low, outer_high - inner_high)
        start = np.array([inner_low[0] - half[0], float(panel_box[0][1]), inner_low[2] - half[2]])
        cut = (to_vec3(start), to_vec3(inner_high + half))
    return Cavity(
        parts=(),
        interior=interior,
        lower=to_vec3(inner_low),
        upper=to_vec3(inner_high),
        wall=wall,
        outer=(to_vec3(outer_low), to_vec3(outer_high)),
        built=True,
        cut=cut,
        fronts=_panel_boxes(probe, part_ids, mouth) if is_closed else (),
        furnish=is_closed or not _has_contents(probe, part_ids, inner_low, inner_high),
    )


def _shrink_to_covered(
    probe: CavityProbe, part_ids: Sequence[int], lower: Floats, upper: Floats
) -> tuple[Floats, Floats]:
    """Return the corners of a front, shrunk where it is round until the front covers the border of what is left."""
    lower, upper = lower.copy(), upper.copy()
    for _ in range(MAX_SHRINKS):
        spots = border_points(lower[[0, 2]], upper[[0, 2]], BORDER_INSET_SHARE * float((upper - lower)[[0, 2]].min()))
        covered = np.isfinite(probe.cast_through_panels(1, spots, part_ids).first())
        # The points nearest to the four corners have to be covered, too.
        a, b = spots.min(axis=0), spots.max(axis=0)
        away = [np.abs(spots - (x, y)).sum(axis=1) for x in (a[0], b[0]) for y in (a[1], b[1])]
        nearest = [np.round(d, 9) <= round(float(d.min()), 9) for d in away]
        if float(covered.mean()) >= MIN_BORDER_COVERAGE and all(covered[rows].all() for rows in nearest):
            return lower, upper
        inset = ROUND_SHRINK_SHARE * (upper - lower)[[0, 2]]
        lower[[0, 2]] += inset
        upper[[0, 2]] -= inset
    return lower, upper


def _panel_boxes(probe: CavityProbe, part_ids: Sequence[int], mouth: float) -> tuple[tuple[Vec3, Vec3], ...]:
    """Return boxes of panels that are rectangles, at a small distance from the body around and behind them."""
    out = []
    for part in part_ids:
        lower, upper = probe.panel_box_of(part)
        a, b = _shrink_to_covered(probe, (part,), lower, upper)
        end = min(mouth, probe.panel_back_depth((part,), lower, upper)) - PANEL_MARGIN
        if (a == lower).all() and (b == upper).all() and end > lower[1] + PANEL_MARGIN:
            shift = np.array([PANEL_MARGIN, -PANEL_MARGIN, PANEL_MARGIN])
            out.append((to_vec3(lower + shift), to_vec3([upper[0] - PANEL_MARGIN, end, upper[2] - PANEL_MARGIN])))
    return tuple(out)


def _shrink_to_frame(
    probe: CavityProbe,
    part_ids: Sequence[int],
    panel_box: tuple[Floats, Floats],
    mouth: float,
    lower: Floats,
    upper: Floats,
) -> tuple[Floats, Floats]:
    """Shrink a cavity to the frame that a hollow object has around its opening."""
    a, b = panel_box[0][[0, 2]], panel_box[1][[0, 2]]
    lines = probe.cast_lines(1, sample_grid(a, b, FINE_LINES_PER_SIDE), part_ids)
    depth = lines.select(lines.at > float(panel_box[0][1])).first().reshape(FINE_LINES_PER_SIDE, FINE_LINES_PER_SIDE)
    is_open: Mask = depth > mouth + 0.05
    step = (b - a) / FINE_LINES_PER_SIDE
    lower, upper = lower.copy(), upper.copy()
    for axis, k in ((0, 0), (2, 1)):
        share = is_open.mean(axis=1 - k)
        rows = np.flatnonzero(share >= OPEN_BORDER_SHARE * share.max(initial=0.0))
        if not len(rows) or share.max() < 0.3:
            continue
        start, stop = float(a[k] + rows[0] * step[k]), float(b[k] - (FINE_LINES_PER_SIDE - 1 - rows[-1]) * step[k])
        if start - float(a[k]) > MIN_FRAME_WIDTH:
            lower[axis] = max(lower[axis], start) if start - float(a[k]) > 2 * step[k] else lower[axis]
        if float(b[k]) - stop > MIN_FRAME_WIDTH:
            upper[axis] = min(upper[axis], stop) if float(b[k]) - stop > 2 * step[k] else upper[axis]
    return lower, upper


def _shrink_to_skin(probe: CavityProbe, part_ids: Sequence[int], lower: Floats, upper: Floats) -> tuple[Floats, Floats]:
    """Shrink a box until the skin of the object lies around all of it, as seen from its middle."""
    body = probe.points[probe.faces[probe.owner == -1]].reshape(-1, 3)
    if len(body):
        lower = np.maximum(lower, body.min(axis=0) + SKIN_DISTANCE)
        upper = np.minimum(upper, body.max(axis=0) - SKIN_DISTANCE)
    for _ in range(MAX_SHRINKS):
        moved = False
        for axis in (0, 1, 2):
            for sign in (-1.0, 1.0) if axis != 1 else (1.0,):
                end = _reach_inside_skin(probe, part_ids, lower, upper, axis, sign)
                if sign > 0 and end < upper[axis] - 1e-6:
                    upper[axis], moved = max(end, upper[axis] - SHRINK_SHARE * (upper[axis] - lower[axis])), True
                if sign < 0 and end > lower[axis] + 1e-6:
                    lower[axis], moved = min(end, lower[axis] + SHRINK_SHARE * (upper[axis] - lower[axis])), True
        if not moved:
            break
    return lower, upper


def _reach_inside_skin(
    probe: CavityProbe, part_ids: Sequence[int], lower: Floats, upper: Floats, axis: int, sign: float
) -> float:
    """Return how far a box may go to a side before it pierces the skin at one of its edges there."""
    a, b = (k for k in range(3) if k != axis)
    share = np.linspace(0.004, 0.996, LINES_PER_SIDE)
    x, y = (lower[k] + share * (upper[k] - lower[k]) for k in (a, b))
    lines = probe.cast_lines(axis, np.stack(np.meshgrid(x, y, indexing="ij"), axis=2).reshape(-1, 2), part_ids)
    # The farthest surface on each line is the skin; a line that leaves through a hole says nothing.
    far = lines.last() if sign > 0 else lines.first()
    distance = np.where(np.isfinite(far), (far - (lower[axis] + upper[axis]) / 2) * sign, -1.0)
    if not (distance > 0).any():
        return float(upper[axis] if sign > 0 else lower[axis])
    seen = distance >= HOLE_DISTANCE_SHARE * float(np.median(distance[distance > 0]))
    nearest = float((far[seen] * sign).min()) * sign
    return nearest - sign * SKIN_DISTANCE


def _has_contents(probe: CavityProbe, part_ids: Sequence[int], lower: Floats, upper: Floats) -> bool:
    """Return whether something lies in a hollow cavity already: shelves, racks, pipes."""
    inset = 0.1 * (upper - lower)
    a, b = lower + inset, upper - inset
    for axis in (2, 0):
        p, q = (k for k in range(3) if k != axis)
        lines = probe.cast_lines(axis, sample_grid(a[[p, q]], b[[p, q]], LINES_PER_SIDE), part_ids)
        inside = lines.select((lines.at > a[axis]) & (lines.at < b[axis]))
        if float(np.isfinite(inside.first()).mean()) >= MIN_CONTENTS_SHARE:
            return True
    return False
