"""Bodies of open things: an outline seen from above follows a profile up and down; and their collision shapes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np
from scipy.interpolate import PchipInterpolator

from casa_assets.ext import solids
from casa_assets.ext.arrays import Floats
from casa_assets.ext.records import Vec2
from casa_assets.ext.solids import Placed, Solid, rectangle, round_corners
from casa_assets.kitchenware.objects.closed_surface import run_along

# Heights in the picture of a vessel: the edge of its foot, its rim; the middle of the inside is 1.
FOOT_V, RIM_V = 0.08, 0.5
# How far a profile may be off when points of it are left out, by the width of the thing.
SLACK = 0.0018
# Slabs are at least as thick as this, metres.
THICK = 0.003
# A ring has eight slabs; twelve from one radius on, six up to another, metres.
WIDE, SMALL = 0.18, 0.075
# Corners of a rectangle that are rounder than this get a slab of their own, metres.
ROUND_CORNER = 0.03
# Slabs bulge as the wall does where straight ones would end so far from it, metres.
BULGE = 0.008
# How far a bead on the rim may stand over the slabs, metres.
OVER = 0.0035


@dataclass(frozen=True)
class Plan:
    """The outline of a vessel seen from above, and how it changes with height; lengths in metres."""

    half_x: float  # at the widest height
    half_y: float
    corner: float | None  # radius; None: an ellipse
    height: float  # of the rim
    facets: int = 0  # flat sides
    flutes: int = 0  # furrows
    flute_depth: float = 0.0  # by the radius
    twist: float = 0.0  # turn of facets and flutes on their way up, rad
    fluted_from: float = 0.0  # share of the height above which they are
    lip: float = 0.0  # how far the rim is drawn out to -x as a spout
    lip_width: float = 0.4  # rad
    lip_rise: float = 0.0  # how far the lip is drawn up
    lip_from: float = 0.55  # share of the height above which the lip begins
    weave: float = 0.0  # how far strands go out and in
    stakes: int = 0  # around which strands go
    row: float = 0.01  # height of a row of strands
    around: int = 40  # points around an ellipse

    def ring(self, radius: float, z: float) -> Floats:
        """(N, 3) points round the vessel where its half width along x is `radius`, counter-clockwise from +x."""
        inset = self.half_x - radius
        half_x, half_y = max(radius, 1e-5), max(self.half_y - inset, 0.1 * radius, 1e-5)
        if self.corner is not None:
            flat = rectangle(2 * half_x, 2 * half_y, max(self.corner - inset, 0.06 * min(half_x, half_y)), 4)
            return np.column_stack([flat, np.full(len(flat), z)])
        angle = np.arange(self.around) * 2 * np.pi / self.around
        flat = np.stack([half_x * np.cos(angle), half_y * np.sin(angle)], axis=1)
        share = min(max(z / self.height, 0.0), 1.0)
        flat *= self._shape(angle, share)[:, None]
        if self.weave > 0:
            place = z / self.row
            bulge = abs(math.sin(math.pi * place))
            over = np.cos(0.5 * self.stakes * angle + math.pi * math.floor(place))
            flat *= (1.0 + self.weave / self.half_x * bulge * over)[:, None]
        pull = self._pull(angle, share)
        way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return np.column_stack([flat + self.lip * pull[:, None] * way, z + self.lip_rise * pull])

    def _shape(self, angle: Floats, share: float) -> Floats:
        fade = min(1.0, max(0.0, (share - self.fluted_from) / 0.15)) if self.fluted_from > 0 else 1.0
        turned = angle + self.twist * share
        factor = np.ones(len(angle))
        if self.facets:
            step = 2 * np.pi / self.facets
            factor += fade * ((np.cos(step / 2) / np.cos(np.mod(turned, step) - step / 2)) - 1.0)
        if self.flutes:
            factor -= fade * self.flute_depth * (0.5 - 0.5 * np.cos(self.flutes * turned))
        return factor

    def _pull(self, angle: Floats, share: float) -> Floats:
        """How much of the lip is felt at some angles, 0..1."""
        if self.lip <= 0:
            return np.zeros(len(angle))
        away = np.abs(np.mod(angle, 2 * np.pi) - np.pi) / self.lip_width
        return np.asarray(np.exp(-(away**2)) * max(0.0, (share - self.lip_from) / (1.0 - self.lip_from)) ** 2)


@dataclass(frozen=True)
class Profile:
    """The outside and the inside of a vessel in a plane through its axis, from below to the rim; (N, 2) metres."""

    outside: Floats
    inside: Floats
    foot: float = 0.0
    foot_wall: float = 0.0

    def radius(self, z: float) -> float:
        """Half the width of the outside at a height."""
        return float(np.interp(z, np.maximum.accumulate(self.outside[:, 1]), self.outside[:, 0]))

    def slope(self, z: float) -> float:
        """How steeply the outside leans outwards at a height, rad from upright."""
        low, high = self.radius(z - 0.004), self.radius(z + 0.004)
        return math.atan2(high - low, 0.008)

    def path(self) -> tuple[Floats, Floats]:
        """(N, 2) points from the axis below over the rim to the axis inside, and (N,) heights in the picture."""
        under = [(0.0, 0.0)]
        r = float(self.outside[0, 0])
        if self.foot > 0:
            under = [(0.0, self.foot), (r - self.foot_wall, self.foot), (r - 0.8 * self.foot_wall, 0.0003)]
            under += [(r - 0.5 * self.foot_wall, 0.0), (r, 0.0004)]
        outer = self.outside[1:] if self.foot > 0 else self.outside
        a, b = outer[-1], self.inside[-1]
        way = outer[-1] - outer[-2]
        way = way / np.linalg.norm(way) * float(np.linalg.norm(b - a)) / 2
        rim = [(a + b) / 2 + math.cos(t) * (a - b) / 2 + math.sin(t) * way for t in (math.pi / 4, math.pi / 2, 2.356)]
        parts = (np.array(under), outer, np.array(rim), self.inside[::-1])
        spans = ((0.0, FOOT_V), (FOOT_V + 0.005, RIM_V - 0.01), (RIM_V - 0.006, RIM_V + 0.006), (RIM_V + 0.01, 1.0))
        v = [_spread(part, *span) for part, span in zip(parts, spans, strict=True)]
        return np.concatenate(parts), np.concatenate(v)


def vessel_profile(
    points: Sequence[Vec2], soft: bool, rounding: float, wall: float, floor: float, fillet: float, foot: float
) -> Profile:
    """The profile of a vessel.

    points: of the outside, (radius, height) in metres from the edge of the foot to the rim. soft: a smooth curve runs
    through them; else their corners are rounded by `rounding`. wall: its thickness. floor: height of the inside's
    floor. fillet: between floor and wall. foot: height of a hollow under it, 0 for none.
    """
    corners = [(r, 0.0, z) for r, z in points]
    fine = _smooth(np.array(points)) if soft else _bent(corners, rounding)
    way = np.gradient(fine, axis=0)
    way /= np.maximum(np.linalg.norm(way, axis=1), 1e-12)[:, None]
    inner = fine + wall * np.stack([-way[:, 1], way[:, 0]], axis=1)
    low = np.flatnonzero((inner[:, 1] < floor) | (inner[:, 0] < 1e-4) | (fine[:, 1] < floor - wall))
    start = int(low[-1]) + 1 if len(low) else 0
    before, inner = inner[max(start - 1, 0)], inner[start:]
    # The wall goes straight down to the floor where no point of it is near.
    rise = float(inner[0, 1] - before[1])
    share = min(max((floor - float(before[1])) / rise, 0.0), 1.0) if start and rise > 1e-9 else 1.0
    edge = max(float(before[0] + share * (inner[0, 0] - before[0])), 1e-3)
    if share < 1.0:
        inner = np.concatenate([[[edge, floor]], inner])
    turned = _bent([(0.0, 0.0, floor), (edge, 0.0, floor), *((r, 0.0, z) for r, z in inner[1:])], fillet, 1)
    tolerance = SLACK * 2 * float(fine[:, 0].max())
    return Profile(thinned(fine, tolerance), thinned(turned, tolerance), foot, 1.6 * wall if foot > 0 else 0.0)


def woven(profile: Profile, step: float) -> Profile:
    """The profile with a point on the outside every `step` metres of height, as the rows of a basket need them."""
    wall = profile.outside
    z = np.arange(math.ceil(wall[0, 1] / step + 0.01) * step, wall[-1, 1] - 0.2 * step, step)
    between = np.stack([np.interp(z, wall[:, 1], wall[:, 0]), z], axis=1)
    return replace(profile, outside=np.concatenate([wall[:1], between, wall[-1:]]))


def surface(path: Floats, v: Floats, plan: Plan, inside: Plan | None = None) -> Solid:
    """A closed surface whose rings follow a path that begins and ends on the axis; a picture covers all of it.

    path: (N, 2) half width along x, and height. v: (N,) heights in the picture. inside: the plan from the rim on.
    """
    rings = [
        (inside if inside and s >= RIM_V - 0.01 else plan).ring(float(r), float(z))
        for (r, z), s in zip(path[1:-1], v[1:-1], strict=True)
    ]
    n, levels = len(rings[0]), len(rings)
    first, last = (np.array([[0.0, 0.0, float(z)]]) for z in (path[0, 1], path[-1, 1]))
    points = np.concatenate([first, *rings, last])
    i = np.arange(n)
    j = np.roll(i, -1)
    longest = max(rings, key=lambda ring: float(np.ptp(ring[:, 0])))
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.roll(longest, -1, axis=0) - longest, axis=1))])
    u = run / run[-1]
    u0, u1 = u[:-1], u[1:]
    middle = (u0 + u1) / 2
    faces = [np.stack([0 * i, 1 + j, 1 + i], axis=1)]
    uv = [_corners((middle, v[0]), (u1, v[1]), (u0, v[1]))]
    for k in range(levels - 1):
        a, d = 1 + k * n + i, 1 + (k + 1) * n + i
        b, c = 1 + k * n + j, 1 + (k + 1) * n + j
        v0, v1 = v[k + 1], v[k + 2]
        if plan.weave > 0:
            # Every other square is cut the other way, so that strands bulge evenly to both sides.
            odd = i % 2 == 1
            e, f = np.where(odd, d, c), np.where(odd, b, a)
            ue, uf = np.where(odd, u0, u1), np.where(odd, u1, u0)
            faces += [np.stack([a, b, e], axis=1), np.stack([f, c, d], axis=1)]
            uv += [_corners((u0, v0), (u1, v0), (ue, v1)), _corners((uf, v0), (u1, v1), (u0, v1))]
            continue
        faces += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
        uv += [_corners((u0, v0), (u1, v0), (u1, v1)), _corners((u0, v0), (u1, v1), (u0, v1))]
    top = 1 + (levels - 1) * n
    faces.append(np.stack([np.full(n, len(points) - 1), top + i, top + j], axis=1))
    uv.append(_corners((middle, v[-1]), (u0, v[-2]), (u1, v[-2])))
    found = Solid(points, np.concatenate(faces).astype(np.int64), crease_deg=42.0, picture_uv=np.concatenate(uv))
    return found.oriented_outwards()


def turned_on(path: Floats, plan: Plan) -> Solid:
    """As `surface`, with picture heights along the path."""
    return surface(path, _spread(path, 0.0, 1.0), plan)


def pictured(solid: Solid, profile: Profile, around: float) -> Solid:
    """A part, as a handle, with the picture of the wall next to it at each height; around: of the vessel, metres."""
    corners = solid.points[solid.faces]
    heights = _spread(profile.outside, FOOT_V + 0.02, RIM_V - 0.03)
    v = np.interp(corners[..., 2], np.maximum.accumulate(profile.outside[:, 1]), heights)
    u = 0.25 + (corners[..., 1] + 0.4 * corners[..., 0]) / around
    return replace(solid, uv_m=None, picture_uv=np.stack([np.clip(u, 0, 1), v], axis=2))


def patched(solid: Solid, v: float = 0.3, reach: float = 0.05) -> Solid:
    """A small part such as a knob with a patch of the picture of a vessel about a height of it."""
    low, high = solid.bounds
    share = (solid.points - low) / np.maximum(high - low, 1e-9)
    uv = np.stack([0.2 + 0.1 * share[:, 0], v - reach + 2 * reach * share[:, 2]], axis=1)[solid.faces]
    return replace(solid, uv_m=None, picture_uv=uv)


def thinned(line: Floats, tolerance: float) -> Floats:
    """The points of an open line without those that a straight piece replaces within a tolerance. Ref: Douglas 1973."""
    keep = np.zeros(len(line), dtype=bool)
    keep[[0, -1]] = True
    spans = [(0, len(line) - 1)]
    while spans:
        a, b = spans.pop()
        if b - a < 2:
            continue
        along = line[b] - line[a]
        between = line[a + 1 : b] - line[a]
        length = float(np.linalg.norm(along))
        off = np.abs(between[:, 0] * along[1] - between[:, 1] * along[0]) / length if length > 1e-12 else between[:, 0]
        k = int(np.argmax(off))
        if off[k] > tolerance:
            keep[a + 1 + k] = True
            spans += [(a, a + 1 + k), (a + 1 + k, b)]
    return line[keep]


def _smooth(points: Floats) -> Floats:
    run = run_along(points)
    at = np.unique(np.concatenate([run, np.linspace(0.0, run[-1], 120)]))
    return np.stack([PchipInterpolator(run, points[:, k])(at) for k in (0, 1)], axis=1)


def _bent(corners: Sequence[tuple[float, float, float]], rounding: float, only: int | None = None) -> Floats:
    """(N, 2) the line in the plane x, z with rounded corners: all of them, or one; straight pieces are subdivided."""
    if rounding <= 0:
        line = np.array(corners)[:, [0, 2]]
    elif only is None:
        line = round_corners(corners, rounding, 6)[:, [0, 2]]
    else:
        # A fillet may take up many short pieces of the wall, or end within a long one.
        flat = np.array(corners)[:, [0, 2]]
        wall = flat[only:]
        run = run_along(wall)
        reach = min(rounding, 0.9 * float(run[-1]), 0.9 * float(flat[only, 0]))
        end = np.array([np.interp(reach, run, wall[:, k]) for k in (0, 1)])
        start = flat[only] - (reach, 0.0)
        t = np.linspace(0.0, 1.0, 6)[:, None]
        arc = (1 - t) ** 2 * start + 2 * t * (1 - t) * flat[only] + t**2 * end
        return np.concatenate([flat[:only], arc, wall[run > reach + 1e-6]])
    if only is not None:
        return line
    # The offset of a straight piece to the inside needs a point at both of its ends.
    out = []
    for a, b in pairwise(line):
        out += [a + (b - a) * s for s in (0.0, 0.02, 0.5, 0.98)]
    return np.array([*out, line[-1]])


def _corners(*places: tuple[Floats, float] | tuple[Floats, Floats]) -> Floats:
    """(F, 3, 2) picture places of three corners."""
    return np.stack([np.stack([u, np.broadcast_to(v, u.shape)], axis=1) for u, v in places], axis=1)


def _spread(line: Floats, low: float, high: float) -> Floats:
    if len(line) == 1:
        return np.array([low])
    run = run_along(line)
    return low + (high - low) * run / max(float(run[-1]), 1e-12)


def open_shapes(
    profile: Profile, plan: Plan, floor: float, low: float, room: int, bead: float = 0.0
) -> tuple[Placed, ...]:
    """The shapes of an open vessel.

    floor: height of the inside's floor. low: where the wall begins. room: most shapes. bead: radius of the rim's wire.
    """
    outside = profile.outside
    solid = [*outside[outside[:, 1] < floor], (profile.radius(floor), floor)]
    shapes = closed_shapes(np.array(solid), plan, 0.05 * plan.half_x)
    ways = _ways(plan)
    levels = max(1, (room - len(shapes) - (plan.lip > 0)) // len(ways))
    start = low + max(0.0035, 0.25 * (floor - low))
    wall = np.concatenate([[[profile.radius(start), start]], outside[outside[:, 1] > start + 1e-5]])
    line = _levels(wall, plan, min(levels, 3))
    thickness = max(THICK, float(np.linalg.norm(profile.inside[-1] - outside[-1])))
    # (N, 2) unit normals of a profile line that point to its inside.
    way = np.gradient(line, axis=0) if len(line) > 2 else np.repeat(np.diff(line, axis=0), 2, axis=0)
    way /= np.maximum(np.linalg.norm(way, axis=1), 1e-9)[:, None]
    inner = line + thickness * np.stack([-way[:, 1], way[:, 0]], axis=1)
    inner[:, 0] = np.maximum(inner[:, 0], 0.02 * plan.half_x)
    bulging = wall if _error(wall, line) > BULGE else wall[:0]
    over = max(0.0, bead - OVER)
    line[-1] += over  # outwards and upwards
    inner[-1, 1] += over
    for lower, upper in pairwise(range(len(line))):
        sides = [(float(r), float(z)) for ring in (line, inner) for r, z in (ring[lower], ring[upper])]
        sides += [(float(r), float(z)) for r, z in bulging if line[lower, 1] < z < line[upper, 1]]
        rings = [_polygon(plan, r, z, ways) for r, z in sides]
        for i in range(len(ways)):
            j = (i + 1) % len(ways)
            shapes += solids.hull_around(np.array([ring[k] for ring in rings for k in (i, j)])).shapes
    if plan.lip > 0:
        shapes += _lip(profile, plan, thickness)
    return tuple(shapes)


def _levels(wall: Floats, plan: Plan, most: int) -> Floats:
    """The (N, 2) corners of the line that follows a wall's profile best with few pieces."""
    marks = thinned(wall, 0.0008)
    tolerance = max(0.0035, 0.035 * plan.half_x)
    best = marks[[0, -1]]
    for inner in range(most):
        choices = [marks[[0, *chosen, -1]] for chosen in combinations(range(1, len(marks) - 1), inner)]
        errors = [_error(marks, line) for line in choices]
        best = choices[int(np.argmin(errors))] if choices else best
        if not choices or min(errors) < tolerance:
            break
    return best


def _error(points: Floats, line: Floats) -> float:
    found = np.full(len(points), np.inf)
    for a, b in pairwise(line):
        share = np.clip((points - a) @ (b - a) / max(float((b - a) @ (b - a)), 1e-12), 0.0, 1.0)
        found = np.minimum(found, np.linalg.norm(points - a - share[:, None] * (b - a), axis=1))
    return float(found.max())


def _lip(profile: Profile, plan: Plan, thickness: float) -> tuple[Placed, ...]:
    near = np.abs((np.arange(plan.around) * 2 * np.pi / plan.around) - np.pi) < 1.25 * plan.lip_width
    low = plan.lip_from + 0.35 * (1 - plan.lip_from)
    points = []
    for z in (low * plan.height, plan.height):
        r = profile.radius(z)
        points += [plan.ring(r, z)[near], replace(plan, lip=0.0).ring(r - thickness, z)[near]]
    return solids.hull_around(np.concatenate(points)).shapes


def closed_shapes(line: Floats, plan: Plan, slack: float) -> list[Placed]:
    """The shapes of a solid body that a profile line bounds, (N, 2) radius and height: cylinders, boxes and hulls."""
    shapes: list[Placed] = []
    found = thinned(line, slack)
    low = float(found[0, 1])
    if len(found) > 1 and found[0, 0] > 1.02 * plan.half_x * 0.02:
        # It stands on a plain disc or box, whatever else it is made of.
        shapes += _block(plan, float(found[0, 0]), low, max(min(low + 0.003, float(found[-1, 1])), low + 0.001))
    for (r0, z0), (r1, z1) in pairwise(found):
        if z1 - z0 < 0.001:
            continue
        if abs(r1 - r0) < 0.06 * max(r0, r1):
            shapes += _block(plan, float(r0 + r1) / 2, float(z0), float(z1))
            continue
        lift = min(0.0015, 0.3 * float(z1 - z0))
        rings = [plan.ring(float(r), float(z) + raised)[::2] for r, z, raised in ((r0, z0, lift), (r1, z1, 0.0))]
        shapes += solids.hull_around(np.concatenate(rings)).shapes
    return shapes


def _block(plan: Plan, radius: float, low: float, high: float) -> tuple[Placed, ...]:
    middle, tall = (low + high) / 2, high - low
    half_y = max(plan.half_y - (plan.half_x - radius), 0.1 * radius)
    if plan.corner is None and abs(half_y - radius) < 1e-6:
        return solids.rod(radius, tall, 0.0).translated(z=middle).shapes
    if plan.corner is not None:
        return solids.box((2 * radius, 2 * half_y, tall), (0.0, 0.0, middle), 0.0).shapes
    return solids.hull_around(np.concatenate([plan.ring(radius, z)[::2] for z in (low, high)])).shapes


def _ways(plan: Plan) -> Floats:
    """Directions of the corners of a ring of slabs: angles of an ellipse, or of a rectangle numbers of its corners."""
    if plan.corner is not None:
        return np.arange(8 if plan.corner > ROUND_CORNER else 4, dtype=np.float64)
    count = 12 if plan.half_x > WIDE else 6 if plan.half_x < SMALL else 8
    # A quarter of a step on: then the polygon is as wide in x as in y, to all four sides.
    return (np.arange(count) + 0.25) * 2 * np.pi / count


def _polygon(plan: Plan, radius: float, z: float, ways: Floats) -> Floats:
    """(N, 3) corners of a ring of slabs, half way between the polygon inside the outline and the one about it."""
    if plan.corner is not None:
        inset = plan.half_x - radius
        x, y = max(radius, 1e-4), max(plan.half_y - inset, 1e-4)
        cut = min(0.45 * (max(plan.corner - inset, 0.0) if len(ways) == 8 else 0.0), 0.8 * x, 0.8 * y)
        corners = [(x, y - cut), (x - cut, y), (-x + cut, y), (-x, y - cut)]
        corners += [(-x, -y + cut), (-x + cut, -y), (x - cut, -y), (x, -y + cut)]
        flat = np.array(corners if len(ways) == 8 else corners[::2])
        return np.column_stack([flat, np.full(len(flat), z)])
    ring = replace(plan, lip=0.0, lip_rise=0.0, flutes=0, facets=0).ring(float(radius), float(z))
    angle = np.arange(plan.around) * 2 * np.pi / plan.around
    wide = 1 + 0.5 * (1 / math.cos(math.pi / len(ways)) - 1)
    if plan.facets:
        wide *= 0.3 + 0.7 * math.cos(math.pi / plan.facets)
    parts = [np.interp(ways, angle, ring[:, k], period=2 * np.pi) for k in range(3)]
    return np.stack([parts[0] * wide, parts[1] * wide, parts[2]], axis=1)
