"""Bodies of bottles, jars and cans: an outline with round corners, a section, sleeves with a picture round them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from casa_assets.ext.arrays import Floats
from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import Solid
from casa_assets.kitchenware.objects.closed_surface import run_along

# Points round a section: four on the axes and so many in each corner.
CORNER = 7
AROUND = 4 * (CORNER + 1)


def rounded_outline(points: Sequence[Vec3]) -> list[Vec2]:
    """Points (radius, height) of an outline whose corners are rounded, with four points per right angle.

    Args:
        points: (radius, height, radius of the corner) from the foot to the mouth, metres. A corner takes at most half
            of each of the two pieces that meet in it.
    """
    line = [np.array(p[:2]) for p in points]
    out: list[Vec2] = [(float(line[0][0]), float(line[0][1]))]
    for k in range(1, len(line) - 1):
        a, b = line[k - 1] - line[k], line[k + 1] - line[k]
        la, lb = float(np.linalg.norm(a)), float(np.linalg.norm(b))
        a, b = a / la, b / lb
        half = math.acos(float(np.clip(a @ b, -1.0, 1.0))) / 2
        reach = min(points[k][2] / max(math.tan(half), 1e-6), 0.499 * la, 0.499 * lb)
        if reach < 1e-5 or half > math.pi / 2 - 0.01:
            out.append((float(line[k][0]), float(line[k][1])))
            continue
        sweep = math.pi - 2 * half
        bulge = reach * math.tan(half)
        middle = line[k] + (a + b) / np.linalg.norm(a + b) * bulge / math.sin(half)
        start, end = line[k] + a * reach - middle, line[k] + b * reach - middle
        count = max(2, round(4 * sweep / (math.pi / 2)) + 1)
        for t in np.linspace(0.0, 1.0, count + 1):
            arm = (math.sin((1 - t) * sweep) * start + math.sin(t * sweep) * end) / math.sin(sweep)
            out.append((float(middle[0] + arm[0]), float(middle[1] + arm[1])))
    out.append((float(line[-1][0]), float(line[-1][1])))
    return [out[0], *[b for a, b in pairwise(out) if math.dist(a, b) > 1e-6]]


def grooved(outline: Sequence[Vec2], low: float, high: float, count: int, depth: float) -> list[Vec2]:
    """The outline with grooves that run round it between two heights, metres."""
    if count < 1:
        return list(outline)
    pitch = (high - low) / count
    wanted = []
    for k in range(count):
        middle = low + (k + 0.5) * pitch
        wanted += [(middle - 0.4 * pitch, 0.0), (middle, depth), (middle + 0.4 * pitch, 0.0)]
    rest = [(r, z) for r, z in outline if not low < z < high]
    added = [(radius_at(outline, z) - d, z) for z, d in wanted]
    return sorted([*rest, *added], key=lambda point: point[1])


def radius_at(outline: Sequence[Vec2], z: float) -> float:
    """Radius of the outline at a height."""
    return float(np.interp(z, [q for _, q in outline], [r for r, _ in outline]))


class Section:
    """The section of a body: a circle, an oval, or a rectangle with round corners; at its mouth it is a circle.

    Attributes:
        flat: depth by width. corner: radius of the corners by half the width, 1 for a circle or an oval.
        mouth, widest: radii between which it passes from a circle into its own form, metres.
    """

    def __init__(self, flat: float, corner: float, mouth: float, widest: float) -> None:
        self.flat, self.corner, self.mouth, self.widest = flat, corner, mouth, widest

    @property
    def is_round(self) -> bool:
        """Whether it is a circle all the way."""
        return self.flat > 0.999 and self.corner > 0.999

    def ring(self, radius: float, out: float = 0.0) -> Floats:
        """(AROUND, 2) points at a radius, metres, counter-clockwise from behind (+y), moved outwards by `out`."""
        reach = self.widest - self.mouth
        share = 1.0 if reach < 0.12 * self.widest else float(np.clip((radius - self.mouth) / (0.7 * reach), 0.0, 1.0))
        share = share * share * (3 - 2 * share)
        corner = 1.0 + (self.corner - 1.0) * share
        flat = 1.0 + (self.flat - 1.0) * share
        return np.asarray(_unit_ring(corner) * (radius + out, flat * radius + out))

    def around(self) -> Floats:
        """(AROUND + 1,) share of the way round at which each point lies, from 0 behind over -x, front and +x to 1."""
        ring = self.ring(self.widest)
        run = run_along(np.vstack([ring, ring[:1]]))
        return np.asarray(run / run[-1])


def _unit_ring(corner: float) -> Floats:
    """(AROUND, 2) points of a square of half side 1 with round corners, from (0, 1) counter-clockwise."""
    even = np.arange(1, CORNER + 1) / (CORNER + 1)
    ends = np.linspace(0.0, 1.0, CORNER)
    angles = (even * corner + ends * (1 - corner)) * math.pi / 2
    arc = np.column_stack([np.cos(angles), np.sin(angles)]) * corner + (1.0 - corner)
    quarter = np.vstack([[[1.0, 0.0]], arc])
    out = []
    for k in range(1, 5):
        c, s = round(math.cos(k * math.pi / 2)), round(math.sin(k * math.pi / 2))
        out.append(quarter @ np.array([[c, s], [-s, c]]))
    return np.vstack(out)


def body(outline: Sequence[Vec2], section: Section, inner: float = 0.0) -> Solid:
    """The closed surface of an outline, its ends closed flat; `inner`: how far it is drawn in all round, metres."""
    return _skin([np.column_stack([section.ring(r, -inner), np.full(AROUND, z)]) for r, z in outline])


def cup(outline: Sequence[Vec2], section: Section, wall: float, floor: float) -> Solid:
    """A body that is open above: up outside and down inside, `wall` thick."""
    inside = [(r, max(floor, z)) for r, z in outline if z > floor]
    inside = [(radius_at(outline, floor), floor), *inside]
    rings = [np.column_stack([section.ring(r), np.full(AROUND, z)]) for r, z in outline]
    rings += [np.column_stack([section.ring(r, -wall), np.full(AROUND, z)]) for r, z in inside[::-1]]
    return _skin(rings)


def _skin(rings: Sequence[Floats]) -> Solid:
    """Rings joined into a closed surface; each end is closed by a fan about its middle."""
    count = len(rings)
    points = np.vstack([*rings, rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    i = np.arange(AROUND)
    j = (i + 1) % AROUND
    faces = []
    for k in range(count - 1):
        a, b = k * AROUND, (k + 1) * AROUND
        faces += [np.stack([a + i, a + j, b + j], axis=1), np.stack([a + i, b + j, b + i], axis=1)]
    low, high, top = count * AROUND, count * AROUND + 1, (count - 1) * AROUND
    faces += [np.stack([np.full(AROUND, low), j, i], axis=1)]
    faces += [np.stack([np.full(AROUND, high), top + i, top + j], axis=1)]
    return Solid(points, np.concatenate(faces).astype(np.int64), crease_deg=42.0)


def piece(outline: Sequence[Vec2], low: float, high: float) -> list[Vec2]:
    """The part of an outline between two heights, with an added point at either height."""
    inside = [(r, z) for r, z in outline if low + 1e-5 < z < high - 1e-5]
    return [(radius_at(outline, low), low), *inside, (radius_at(outline, high), high)]


def sleeve(outline: Sequence[Vec2], section: Section, wrap: float, out: float) -> Solid:
    """A thin skin around a piece of a body, with a picture from end to end.

    Args:
        outline: of the piece.
        wrap: share of the circumference that it covers, centred on the front; the picture spans it from left to right.
        out: distance of the skin from the body, metres.
    """
    at = section.around()
    whole = wrap > 0.999
    if whole:
        places = at[:-1]
    else:
        low, high = 0.5 - wrap / 2, 0.5 + wrap / 2
        places = np.array([low, *at[(at > low + 0.004) & (at < high - 0.004)], high])
    n, m = len(places), len(outline)
    outer, inner = (
        [np.column_stack([_placed(section.ring(r, d), at, places), np.full(n, z)]) for r, z in outline]
        for d in (out, -0.0003)
    )
    points = np.vstack([*outer, *inner])
    run = np.concatenate([[0.0], np.cumsum([math.dist(a, b) for a, b in pairwise(outline)])])
    v = run / run[-1]
    u = np.append(places, 1.0) if whole else (places - places[0]) / (places[-1] - places[0])
    uv_of = [(float(u[i]), float(v[k])) for k in range(m) for i in range(n)]
    columns = n if whole else n - 1
    faces: list[tuple[int, int, int]] = []
    uv: list[tuple[Vec2, Vec2, Vec2]] = []

    def add(corners: Sequence[int], at_uv: Sequence[Vec2]) -> None:
        a, b, c, d = corners
        ua, ub, uc, ud = at_uv
        faces.extend([(a, b, c), (a, c, d)])
        uv.extend([(ua, ub, uc), (ua, uc, ud)])

    back = m * n
    for k in range(m - 1):
        for i in range(columns):
            j = (i + 1) % n
            a, b, c, d = k * n + i, k * n + j, (k + 1) * n + j, (k + 1) * n + i
            right = float(u[i + 1])
            add((a, b, c, d), (uv_of[a], (right, float(v[k])), (right, float(v[k + 1])), uv_of[d]))
            add((back + b, back + a, back + d, back + c), [(float(u[i]), 0.004)] * 4)
    for i in range(columns):
        j, top = (i + 1) % n, (m - 1) * n
        add((back + i, back + j, j, i), [uv_of[i]] * 4)
        add((top + i, top + j, back + top + j, back + top + i), [uv_of[top + i]] * 4)
    for k in range(m - 1) if not whole else ():
        a, b, last = k * n, (k + 1) * n, n - 1
        add((back + a, a, b, back + b), [uv_of[a]] * 4)
        add((a + last, back + a + last, back + b + last, b + last), [uv_of[a + last]] * 4)
    return Solid(points, np.array(faces, dtype=np.int64), crease_deg=42.0, picture_uv=np.array(uv))


def _placed(ring: Floats, at: Floats, places: Floats) -> Floats:
    """(N, 2) points of a ring at shares of the way round."""
    closed = np.vstack([ring, ring[:1]])
    return np.column_stack([np.interp(places, at, closed[:, k]) for k in (0, 1)])
