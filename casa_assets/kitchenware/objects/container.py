"""Closed containers: bottles, jars, cans, flasks and shakers, with a label round them and what closes them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from casa_assets.ext.arrays import Floats
from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.records import Cylinder, Vec2, Vec3
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid, board, hull_around, lathe, rod, tube
from casa_assets.kitchenware.objects import closures
from casa_assets.kitchenware.objects.closed_surface import run_along
from casa_assets.kitchenware.objects.closures import COVERED, HINGED, LID, LID_GRIP, Closure, Mouth, Part

# Points round a section: four on the axes, and those in each corner.
CORNER = 7
AROUND = 4 * (CORNER + 1)


def rounded_outline(points: Sequence[Vec3]) -> list[Vec2]:
    """Points (radius, height) of an outline whose corners are rounded, with four points per right angle.

    points: (radius, height, radius of the corner) from the foot up, metres; a corner takes at most half of a piece.
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
        middle = line[k] + (a + b) / np.linalg.norm(a + b) * (reach * math.tan(half)) / math.sin(half)
        start, end = line[k] + a * reach - middle, line[k] + b * reach - middle
        for t in np.linspace(0.0, 1.0, max(2, round(4 * sweep / (math.pi / 2)) + 1) + 1):
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
    return sorted([*rest, *([(radius_at(outline, z) - d, z) for z, d in wanted])], key=lambda point: point[1])


def radius_at(outline: Sequence[Vec2], z: float) -> float:
    """Radius of the outline at a height."""
    return float(np.interp(z, [q for _, q in outline], [r for r, _ in outline]))


class Section:
    """The section of a body: a circle, an oval, or a rectangle with round corners; at its mouth it is a circle.

    flat: depth by width. corner: radius of the corners by half the width, 1 for a circle or an oval. mouth, widest:
    radii between which it passes from a circle into its own form, metres.
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
        return np.asarray(_unit_ring(corner) * (radius + out, (1.0 + (self.flat - 1.0) * share) * radius + out))

    def around(self) -> Floats:
        """(AROUND + 1,) share of the way round at which each point lies, from 0 behind over -x, front and +x to 1."""
        ring = self.ring(self.widest)
        run = run_along(np.vstack([ring, ring[:1]]))
        return np.asarray(run / run[-1])


def _unit_ring(corner: float) -> Floats:
    """(AROUND, 2) points of a square of half side 1 with round corners, from (0, 1) counter-clockwise."""
    even = np.arange(1, CORNER + 1) / (CORNER + 1)
    angles = (even * corner + np.linspace(0.0, 1.0, CORNER) * (1 - corner)) * math.pi / 2
    quarter = np.vstack([[[1.0, 0.0]], (np.column_stack([np.cos(angles), np.sin(angles)]) * corner + (1.0 - corner))])
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
    inside = [(radius_at(outline, floor), floor), *([(r, max(floor, z)) for r, z in outline if z > floor])]
    rings = [np.column_stack([section.ring(r), np.full(AROUND, z)]) for r, z in outline]
    rings += [np.column_stack([section.ring(r, -wall), np.full(AROUND, z)]) for r, z in inside[::-1]]
    return _skin(rings)


def _skin(rings: Sequence[Floats]) -> Solid:
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

    outline: of the piece. wrap: share of the circumference that it covers, centred on the front; the picture spans it
    from left to right. out: distance of the skin from the body, metres.
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


Metres = Annotated[float, Field(gt=0, le=0.5)]
Share = Annotated[float, Field(ge=0, le=1)]
# Height of the foot on which a body with a collider that is a hull stands, metres.
FOOT = 0.006
# Share of the height within which ridges reach their full depth.
FLUTE_RISE = 0.08
# Metres between a wall and what is in it.
GAP = 0.0006
# A mouth of this radius lets spoons and fingers in: then the body is hollow for collisions as well. Metres.
WIDE_MOUTH = 0.018
# Slabs round a hollow body, and the least thickness of one, metres.
SECTORS, SLAB = 8, 0.003
# A lid lies so far above the rim of the collision shapes, metres.
LID_GAP = 0.0003
# How far a lid on a hinge turns, rad.
SWING = 1.75


class Container(Params):
    """Parameters of a closed container; lengths in metres, heights as shares of `height` if they are called shares."""

    width: Metres = Field(description="of the widest part, along x, m")
    height: Metres = Field(description="from the foot to the mouth, without the closure, m")
    flat: float = Field(1.0, ge=0.35, le=1, description="depth relative to the width")
    corner: float = Field(1.0, ge=0.1, le=1, description="of the section, by half the width; 1: round or oval")
    foot: float = Field(1.0, ge=0.4, le=1.4, description="radius at the foot by the widest one")
    foot_bend: float = Field(0.08, ge=0.01, le=1, description="radius of the edge at the foot by half the width")
    waist: float = Field(1.0, ge=0.5, le=1.3, description="radius halfway up the lower part, by that without a waist")
    shoulder: float = Field(0.66, ge=0.02, le=0.99, description="share of the height where the widest part ends")
    neck_at: float = Field(0.78, ge=0.03, le=0.995, description="share of the height where the neck begins")
    neck: float = Field(0.38, ge=0.1, le=1, description="radius of the mouth by the widest one")
    shoulder_bend: float = Field(0.5, ge=0, le=4, description="radius of that corner by half the width")
    neck_bend: float = Field(0.4, ge=0, le=4, description="radius of that corner by half the width")
    bulge: float = Field(0.0, ge=-0.4, le=0.6, description="of the middle of the neck, by the mouth's radius")
    lip: float = Field(0.0, ge=0, le=0.4, description="how far a ring at the mouth projects, by its radius")
    grooves: int = Field(0, ge=0, le=16, description="number of grooves around the body")
    groove_low: Share = Field(0.1, description="lower end of the grooves, share of the height")
    groove_high: Share = Field(0.5, description="upper end of the grooves")
    groove_depth: float = Field(0.0015, ge=0, le=0.006, description="m")
    flutes: Literal[0, 4, 8, 16] = Field(0, description="number of ridges from foot to shoulder, round bodies only")
    flute_depth: float = Field(0.06, ge=0, le=0.2, description="by half the width")
    closure: Closure = Closure.SCREW
    cap_height: float = Field(0.015, ge=0, le=0.12, description="of the closure, m")
    cap_wide: float = Field(1.05, ge=0.4, le=2.5, description="radius of the closure by that of the mouth")
    base_cap: float = Field(0.0, ge=0, le=0.06, description="height of a cap on which it rests upside down, m; 0: none")
    opens: bool = Field(False, description="the closure comes off; a wide mouth is then hollow for collisions")
    open_top: bool = Field(False, description="the body is open above and shows its content")
    wall: float = Field(0.0022, ge=0.0008, le=0.008, description="thickness, m")
    label_low: Share = Field(0.15, description="lower edge of the label, share of the height")
    label_high: Share = Field(0.55, description="upper edge of the label")
    label_wrap: float = Field(1.0, ge=0.1, le=1, description="share of the circumference")
    tag_low: Share = Field(0.8, description="lower edge of a second label")
    tag_high: Share = Field(0.9, description="upper edge of it")
    tag_wrap: float = Field(1.0, ge=0.1, le=1, description="share of the circumference")
    sleeve: Share = Field(0.0, description="share of the height under foil, from the mouth down")
    band_low: Share = Field(0.0, description="lower edge of a plain band, such as a grip")
    band_high: Share = Field(0.0, description="upper edge of it")
    fill: float = Field(0.85, ge=0, le=0.99, description="share of the height that is filled; 0: empty")
    rims: bool = Field(False, description="beads at both ends, as on tins")
    handle: float = Field(0.0, ge=0, le=0.9, description="share of the height that a handle takes; 0: none")
    handle_at: Share = Field(0.6, description="share of the height of its middle")
    handle_out: float = Field(0.55, ge=0.2, le=1.5, description="how far it projects, by half the width")
    handle_thick: float = Field(0.012, ge=0.003, le=0.025, description="m")
    heft: float = Field(1000.0, ge=50, le=2600, description="mass of the whole per volume of its body, kg/m^3")
    body: FinishId = "bottle_clear"
    content: FinishId = "water"
    cap: FinishId = "plastic_white"
    cap_second: FinishId = "plastic_grey_dark"
    label: FinishId | None = Field(None, description="a picture or plain")
    tag: FinishId | None = Field(None, description="a picture or plain")
    foil: FinishId = "foil_gold"
    band_finish: FinishId = "plastic_grey_dark"
    rim_finish: FinishId = "stainless_polished"
    handle_finish: FinishId | None = None

    @model_validator(mode="after")
    def _in_order(self) -> Container:
        if not self.shoulder < self.neck_at:
            raise ValueError(f"shoulder below neck_at is expected, got {self.shoulder} and {self.neck_at}")
        if self.label is not None and not self.label_low < self.label_high:
            raise ValueError("label_low below label_high is expected")
        if self.opens and (self.closure not in COVERED or self.sleeve > 0 or self.base_cap > 0 or self.open_top):
            raise ValueError(f"a {self.closure} under no foil, on a body that stands on its foot, is expected to open")
        return self


@dataclass(frozen=True)
class _Frame:
    """Outline and section of a body."""

    outline: list[Vec2]  # (radius, z) from the foot to the mouth, m
    plain: list[Vec2]  # the same without grooves
    section: Section
    height: float  # from the foot to a closed mouth, m; one that opens ends a little lower

    def z(self, share: float) -> float:
        """A height from a share of the height of the body."""
        return self.plain[0][1] + share * self.height

    @property
    def top(self) -> float:
        """Height of the mouth, metres."""
        return self.plain[-1][1]


def build_container(builder: AssetBuilder, p: Container) -> None:
    """Build the asset around the origin, its bottom at z = 0."""
    frame = _frame(p)
    seen = builder.supplies.finish(p.body).material.base_color[3] < 0.999
    is_cup = p.open_top or p.opens
    shell = cup(frame.outline, frame.section, p.wall, 1.5 * p.wall) if is_cup else body(frame.outline, frame.section)
    if p.flutes and frame.section.is_round:
        shell = replace(shell, points=_fluted(shell.points, p, frame), crease_deg=60.0)
    solid_body = body(frame.outline, frame.section)
    level = min(frame.z(p.fill), frame.top - 0.004) if p.opens else frame.z(p.fill)
    is_hollow = p.opens and frame.plain[-1][0] >= WIDE_MOUTH
    shell = shell.with_colliders_of(*(_hollow_hits(builder, p, frame, level) if is_hollow else _hits(p, frame)))
    builder.add(ROOT, shell, p.body, label="body", name="body", density=0.0)
    builder.add(ROOT, solid_body, p.body, collider=False, density=p.heft, visible=False)
    if (seen or is_cup) and p.fill > 0.02:
        inset = p.wall + GAP + (p.flute_depth * p.width / 2 if p.flutes else 0.0)
        held = piece(frame.plain, frame.plain[0][1] + max(0.003, p.wall), level)
        held = [(r, z) for r, z in held if r > inset + 0.001]
        builder.add(ROOT, body(held, frame.section, inset), p.content, label="content", collider=False, density=0.0)
    rows = (
        (p.label, p.label_low, p.label_high, p.label_wrap, 0.0004, "label"),
        (p.tag, p.tag_low, p.tag_high, p.tag_wrap, 0.0004, "tag"),
        (p.foil if p.sleeve > 0 else None, 1.0 - p.sleeve, 0.998, 1.0, 0.0005, "foil"),
        (p.band_finish if p.band_high > p.band_low else None, p.band_low, p.band_high, 1.0, 0.0008, "band"),
    )
    for finish, low, high, wrap, out, label in rows:
        if finish is not None:
            part = piece(frame.plain, frame.z(low), min(frame.z(high), frame.top - 0.001))
            skin = sleeve(part, frame.section, wrap, out)
            if p.flutes and frame.section.is_round:
                skin = replace(skin, points=_fluted(skin.points, p, frame))
            builder.add(ROOT, skin, finish, label=label, name=label, collider=False, density=0.0)
    _close(builder, p, frame, level)
    if p.handle > 0:
        _handle(builder, p, frame)


def _frame(p: Container) -> _Frame:
    half = p.width / 2
    r = half / max(1.0, p.foot, p.waist * (1 + p.foot) / 2 if p.waist > 1 else 1.0)
    h, n = p.height, p.neck * r
    foot, start = p.foot * r, p.base_cap
    points: list[Vec3] = [(max(0.4 * foot, foot - p.foot_bend * half), 0.0, 0.0), (foot, 0.0, p.foot_bend * half)]
    if abs(p.waist - 1) > 0.005:
        points.append(((foot + r) / 2 * p.waist, 0.5 * p.shoulder * h, 2.5 * half))
    points += [(r, p.shoulder * h, p.shoulder_bend * half), (n, p.neck_at * h, p.neck_bend * half)]
    if abs(p.bulge) > 0.005:
        points.append((n * (1 + p.bulge), (0.5 + 0.5 * p.neck_at) * h, 1.5 * half))
    if p.lip > 0:
        out, z = n * (1 + p.lip), h - min(0.009, 0.5 * (1 - p.neck_at) * h)
        points += [(n, z, 0.0), (out, z + 0.001, 0.0), (out, h - 0.001, 0.0), (out - 0.0006, h, 0.0)]
    else:
        points.append((n, h, 0.0))
    plain = [(q, z + start) for q, z in rounded_outline(points)]
    widest = max(q for q, _ in plain)
    if p.flutes:  # rows where the ridges begin and are full, so that labels lie on them
        low, high = _ridged(p, start)
        rise = FLUTE_RISE * h
        rows = sorted({low, low + rise, high - rise, high} - {z for _, z in plain})
        plain = sorted([*plain, *((radius_at(plain, z), z) for z in rows)], key=lambda point: point[1])
    outline = grooved(plain, start + p.groove_low * h, start + p.groove_high * h, p.grooves, p.groove_depth)
    if p.opens:  # the mouth ends a little above the lower edge of what closes it
        down = closures.lowered(p.closure, p.cap_height, (1 - p.neck_at) * h - 0.001)
        plain, outline = (piece(line, line[0][1], line[-1][1] - down) for line in (plain, outline))
    return _Frame(outline, plain, Section(p.flat, p.corner, (widest if p.base_cap > 0 else plain[-1][0]), widest), h)


def _ridged(p: Container, start: float) -> Vec2:
    return start + 0.04 * p.height, start + p.shoulder * p.height


def _fluted(points: Floats, p: Container, frame: _Frame) -> Floats:
    angle = np.arctan2(points[:, 1], points[:, 0])
    low, high = _ridged(p, frame.plain[0][1])
    here = np.clip(np.minimum(points[:, 2] - low, high - points[:, 2]) / (FLUTE_RISE * p.height), 0.0, 1.0)
    share = 1.0 - p.flute_depth * here * (0.5 - 0.5 * np.cos(p.flutes * angle))
    return np.column_stack([points[:, :2] * share[:, None], points[:, 2]])


def _hits(p: Container, frame: _Frame) -> list[Solid]:
    outline, section = frame.plain, frame.section
    widest, mouth = section.widest, outline[-1][0]
    base, top = outline[0][1], outline[-1][1]
    edge = max(z for r, z in outline if r > 0.97 * widest)
    narrow = [z for r, z in outline if z > edge and r < 1.25 * mouth]
    start = narrow[0] if narrow else top
    low = [r for r, z in outline if base + 0.1 * (edge - base) < z <= edge]
    solids = []
    if p.base_cap > 0:
        ring = section.ring(p.cap_wide * outline[0][0])
        x, y = 0.8 * float(ring[:, 0].max()), 0.8 * float(ring[:, 1].max())
        solids.append(board((-x, -y, 0.0), (x, y, p.base_cap), 0.0))
    if section.is_round and min(low, default=0.0) > 0.94 * widest:
        solids.append(rod(widest, edge - base).translated(z=(edge + base) / 2))
    elif p.base_cap > 0:
        solids.append(body(piece(outline, base, edge), section).with_hull_collider())
    else:
        solids += _footed(frame, edge)
    if start - edge > 0.002:
        solids.append(body(piece(outline, edge, start), section).with_hull_collider())
    if top - start > 0.003:
        r = max(q for q, z in outline if z >= start)
        neck = rod(r, top - start).translated(z=(top + start) / 2)
        solids.append(neck if section.is_round else body(piece(outline, start, top), section).with_hull_collider())
    return solids


def _footed(frame: _Frame, high: float) -> list[Solid]:
    base, section = frame.plain[0][1], frame.section
    tall = min(FOOT, high - base)
    hull = body(piece(frame.plain, base + tall / 2, high), section).with_hull_collider()
    radius = radius_at(frame.plain, base + tall)
    if section.is_round:
        return [hull, rod(0.95 * radius, tall).translated(z=base + tall / 2)]
    ring = section.ring(radius)
    x, y = 0.75 * float(ring[:, 0].max()), 0.75 * float(ring[:, 1].max())
    return [hull, board((-x, -y, base), (x, y, base + tall), 0.0)]


def _hollow_hits(builder: AssetBuilder, p: Container, frame: _Frame, level: float) -> list[Solid]:
    """Collision solids of a body that is open above: what is filled or its floor, and slabs round the room above it."""
    outline, base = frame.plain, frame.plain[0][1]
    is_filled = p.fill > 0.02 and level > base + 0.02
    floor = level if is_filled else base + max(SLAB, 1.5 * p.wall)
    widest = max(z for r, z in outline if r > 0.97 * frame.section.widest)
    levels = [floor, frame.top]
    if widest > floor + 0.01 and frame.top > widest + 0.005:
        levels = [floor, widest, frame.top]
    thick, steps = max(SLAB, p.wall), AROUND // SECTORS
    solids = _footed(frame, floor)
    for low, high in pairwise(levels):
        line = piece(outline, low, high)
        outer = [np.column_stack([frame.section.ring(r), np.full(AROUND, z)]) for r, z in line]
        inner = [np.column_stack([frame.section.ring(r, -thick), np.full(AROUND, z)]) for r, z in (line[0], line[-1])]
        for k in range(SECTORS):
            at = np.arange(k * steps, (k + 1) * steps + 1) % AROUND
            solids.append(hull_around(np.concatenate([ring[at] for ring in (*outer, *inner)])))
    if not is_filled:
        room = frame.section.ring(min(r for r, z in outline if z >= floor) - thick)
        width = 2 * float(np.linalg.norm(room, axis=1).min()) * math.cos(math.pi / SECTORS)
        builder.round_region("int", (0.0, 0.0, floor), width, frame.top - floor - 0.002)
    return solids


def _close(builder: AssetBuilder, p: Container, frame: _Frame, level: float) -> None:
    radius, z = frame.plain[-1]
    z = level if p.open_top else z
    room = closures.loose_skirt(p.closure) if p.opens else max(0.0, (1 - p.neck_at) * p.height - 0.001)
    mouth = Mouth(radius, z, p.cap_height, p.cap_wide, room, p.opens)
    parts = closures.closure_parts(p.closure, mouth)
    if p.opens:
        _opening(builder, p, mouth, [part for part in parts if not part.fixed])
        parts = [part for part in parts if part.fixed]
    for k, part in enumerate(parts):
        finish, hit = p.cap_second if part.second else p.cap, bool(part.solid.shapes)
        name = "cap" if k == 0 else None
        builder.add(ROOT, part.solid, finish, label="cap", name=name, collider=hit, density="screw_cap")
    if p.base_cap > 0:
        r, top = p.cap_wide * frame.plain[0][0], p.base_cap + 0.001
        cap = body([(0.97 * r, 0.0), (r, 0.001), (0.985 * r, top - 0.002), (0.96 * r, top)], frame.section)
        builder.add(ROOT, cap, p.cap, label="cap", name="base", collider=False, density="screw_cap")
    if p.rims:
        r = frame.section.widest
        for at in (0.0, frame.z(1.0) - 0.002):
            side = [(r - 0.001, at), (r + 0.0012, at + 0.0006), (r + 0.0012, at + 0.0024), (r - 0.001, at + 0.003)]
            builder.add(ROOT, lathe(side, 36), p.rim_finish, label="rim", collider=False, density=0.0)


def _opening(builder: AssetBuilder, p: Container, mouth: Mouth, parts: list[Part]) -> None:
    """Add the parts that open as a separate link, whose collision shapes begin above the mouth or a flip cap's seam."""
    is_hinged = p.closure in HINGED
    low = mouth.z + LID_GAP
    at = (0.0, 0.0, mouth.z)
    if p.closure is Closure.FLIP:
        seam = min(float(part.solid.bounds[0, 2]) for part in parts if part.solid.shapes)
        low = seam
        at = (0.0, mouth.radius * mouth.wide + 0.001, seam)
    elif is_hinged:
        at = (0.0, 1.03 * mouth.radius, mouth.z)
    back = (-at[0], -at[1], -at[2])
    builder.link(LID, at)
    for k, part in enumerate(parts):
        solid = part.solid
        if solid.shapes:
            points = np.column_stack([solid.points[:, :2], solid.points[:, 2].clip(low)])
            raised = replace(solid, points=points)
            if len(solid.shapes) == 1 and isinstance(solid.shapes[0][0], Cylinder):
                high = float(points[:, 2].max())
                raised = rod(solid.shapes[0][0].radius, high - low).translated(z=(low + high) / 2)
            else:
                raised = raised.with_hull_collider()
            solid = solid.with_colliders_of(raised)
        finish = p.cap_second if part.second else p.cap
        hit: str | bool = LID_GRIP if k == 0 else bool(solid.shapes)
        name = "lid" if k == 0 else None
        builder.add(LID, solid.translated(*back), finish, label="lid", name=name, collider=hit, density="screw_cap")
    if is_hinged:
        closures.swing_up(builder, (-1.0, 0.0, 0.0), SWING)
    else:
        closures.lift_off(builder, 2 * mouth.radius)


def _handle(builder: AssetBuilder, p: Container, frame: _Frame) -> None:
    half, thick = p.width / 2, p.handle_thick
    z0, z1 = frame.z(max(0.04, p.handle_at - p.handle / 2)), frame.z(min(0.97, p.handle_at + p.handle / 2))
    x0, x1 = radius_at(frame.plain, z0), radius_at(frame.plain, z1)
    out = max(x0, x1) + p.handle_out * half
    drop = 0.25 * (z1 - z0)
    path = [(x1 - 0.6 * thick, 0.0, z1), (out, 0.0, z1 - 0.3 * drop)]
    path += [(out, 0.0, z0 + drop), (x0 - 0.4 * thick, 0.0, z0)]
    turns = np.linspace(0.0, 2 * math.pi, 13)[:-1]
    oval = np.column_stack([0.65 * thick * np.cos(turns), 0.4 * thick * np.sin(turns)])
    bar = tube(path, oval, 0.35 * (z1 - z0), up=(1.0, 0.0, 0.3))
    builder.add(ROOT, bar, p.handle_finish or p.body, label="handle", name="handle", density="flask_handle")
