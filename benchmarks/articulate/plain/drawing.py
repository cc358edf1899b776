"""What a thing is drawn with: how its modeller works, its parts and their joints, fronts, handles, keys and knobs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from benchmarks.articulate.labelled import LabelledMesh
from benchmarks.articulate.plain.solids import (
    Place,
    Surface,
    box,
    ellipse,
    extrude,
    front_of,
    inside_out,
    joined,
    plate,
    rectangle,
    rounded,
    tube,
    turned,
)
from casa_assets.core.numeric import Floats

# How a front or a control stands to the surface that it sits in. `gap`: before it, with air between, or reaching into
# it; `contact`: its back lies on it; `pushed`: no back, its rim is the rim of a hole in the surface; `inset`: inside of
# a hole, with air around; `flush`: a flat piece of the surface itself; `printed`: a sheet hardly above it.
Touch = Literal["gap", "contact", "pushed", "inset", "flush", "printed"]
Edge = Literal["left", "right", "top", "bottom"]
# How far a printed control stands above its surface, metres.
PRINTED = 4e-4


@dataclass(frozen=True)
class Style:
    """How somebody models.

    Attributes:
        fronts, controls: how these stand to their surface. hollow: whether there is a room behind fronts.
        boards: whether a body is put together of boards, else one shell. panel: what a front looks like.
        grip: what a front is held by. sides: of round things. key: outline of keys. knob: shape of knobs.
        tub: what is behind the front of a drawer. thick: of fronts, metres.
    """

    fronts: Touch
    controls: Touch
    hollow: bool
    boards: bool
    panel: Literal["slab", "framed", "raised", "window", "pane"]
    grip: Literal["none", "bar", "knob", "lip", "groove"]
    sides: int
    key: Literal["square", "round", "rounded", "ellipse"]
    knob: Literal["disc", "boss", "bar", "dome", "dial"]
    tub: Literal["none", "tub", "box"]
    thick: float


def drawn_style(rng: np.random.Generator) -> Style:
    """A style; fronts that touch their body are as frequent as those that do not."""
    pick = lambda names, weights: str(rng.choice(names, p=np.array(weights) / sum(weights)))  # noqa: E731
    fronts = pick(["gap", "contact", "pushed", "inset", "flush"], [3, 3, 3, 2, 0.6])
    return Style(
        fronts=fronts,  # type: ignore[arg-type]
        controls=pick(["gap", "contact", "pushed", "printed", "flush"], [3, 3, 2, 2, 0.7]),  # type: ignore[arg-type]
        hollow=bool(rng.random() < 0.55),
        boards=bool(rng.random() < 0.45) and fronts in {"gap", "contact", "inset"},
        panel=pick(["slab", "framed", "raised", "pane"], [4, 2, 1, 1.5]),  # type: ignore[arg-type]
        grip=pick(["none", "bar", "knob", "lip", "groove"], [2, 4, 2, 1, 0.7]),  # type: ignore[arg-type]
        sides=int(rng.choice([8, 12, 16, 24, 32])),
        key=pick(["square", "round", "rounded", "ellipse"], [4, 3, 2, 1]),  # type: ignore[arg-type]
        knob=pick(["disc", "boss", "bar", "dome", "dial"], [3, 2, 2, 1, 1.5]),  # type: ignore[arg-type]
        tub=pick(["none", "tub", "box"], [1, 1.2, 1.2]),  # type: ignore[arg-type]
        thick=float(rng.uniform(0.008, 0.03)),
    )


@dataclass
class Drawing:
    """A thing that is being drawn; z is up and its front faces -y."""

    category: str
    style: Style
    rng: np.random.Generator
    front: str | None = "-Y"
    pieces: list[tuple[Surface, int]] = field(default_factory=list)
    rows: list[dict[str, Any]] = field(default_factory=list)

    def add(self, surface: Surface, part: int = 0) -> None:
        """More surface of a part, 0 for what does not move; a component of its own."""
        self.pieces.append((surface, part))

    def part(
        self, kind: str, joint: str, axis: Floats, origin: Floats, span: tuple[float, float], interior: bool = False
    ) -> int:
        """A new part; its joint opens in the positive sense."""
        number = len(self.rows) + 1
        row = {"type": joint, "axis": np.asarray(axis).tolist(), "origin": np.asarray(origin).tolist()}
        row["range"] = list(span)
        self.rows.append(
            {"id": number, "name": f"{kind}_{number}", "type": kind, "parent": "base", "scored": True, "visible": 1.0}
            | {"interior": interior, "joint": row, "bbox": [[0, 0, 0], [0, 0, 0]], "area": 0.0}
        )
        return number

    def mesh(self, name: str) -> LabelledMesh:
        """The thing as a labelled mesh; its pieces in an order that says nothing."""
        order = self.rng.permutation(len(self.pieces)).tolist()
        points, faces = joined([self.pieces[i][0] for i in order])
        part = np.concatenate([np.full(len(self.pieces[i][0][1]), self.pieces[i][1]) for i in order])
        truth = {"name": name, "category": self.category, "up": "+Z", "front": self.front, "metric": True}
        whole = {**truth, "source": {"repo": "plain"}, "parts": self.rows, "welded": {}, "fused": {}}
        return LabelledMesh(points, faces, part.astype(np.int64), whole)

    def uniform(self, low: float, high: float) -> float:
        """A number between two."""
        return float(self.rng.uniform(low, high))

    def chance(self, share: float) -> bool:
        """Whether something with this probability happens."""
        return bool(self.rng.random() < share)

    def count(self, low: int, high: int) -> int:
        """A whole number between two, both possible."""
        return int(self.rng.integers(low, high + 1))

    def choice(self, options: Sequence[Any]) -> Any:
        """One of some."""
        return options[int(self.rng.integers(len(options)))]


Rect = tuple[float, float, float, float]


def add_front(
    d: Drawing, place: Place, rect: Rect, kind: str, hinge: Edge | None, *, depth: float = 0.3, outline: str = "rect"
) -> Floats | None:
    """A door, lid or drawer in a rectangle of a surface.

    Args:
        rect: (u0, v0, u1, v1) on the plane. hinge: the edge that it turns on, None where it slides out.
        depth: room behind the surface for the box of a drawer. outline: `rect` or `round`.

    Returns:
        The outline of the hole that the surface has to have for it, None where it has none.
    """
    style, thick = d.style, d.style.thick
    u0, v0, u1, v1 = rect
    air = {"gap": 0.0015, "inset": 0.002}.get(style.fronts, 0.0)
    inner = rectangle(u0 + air, v0 + air, u1 - air, v1 - air)
    hole = rectangle(u0, v0, u1, v1)
    if outline == "round":
        middle, radius = ((u0 + u1) / 2, (v0 + v1) / 2), min(u1 - u0, v1 - v0) / 2
        inner, hole = (ellipse(*middle, radius - a, radius - a, max(16, style.sides)) for a in (air, 0.0))
    proud = d.uniform(0.0, 0.6) * thick if style.fronts == "inset" else thick
    low = {"gap": 0.0015, "inset": proud - thick, "flush": 0.0}.get(style.fronts, 0.0)
    high = low + (0.0 if style.fronts == "flush" else thick)
    span = {"left": (u0, None), "right": (u1, None), "top": (None, v1), "bottom": (None, v0)}
    middle_u, middle_v = (u0 + u1) / 2, (v0 + v1) / 2
    if hinge is None:
        part = d.part(kind, "prismatic", place.axes[2], place.point(middle_u, middle_v), (0.0, 0.8 * depth))
    else:
        at_u, at_v = span[hinge]
        at = (middle_u if at_u is None else at_u, middle_v if at_v is None else at_v)
        arm = (middle_u - at[0]) * place.axes[0] + (middle_v - at[1]) * place.axes[1]
        axis = np.cross(arm / np.linalg.norm(arm), place.axes[2])
        origin = place.point(*at, d.choice([0.0, low, (low + high) / 2]))
        part = d.part(kind, "revolute", axis, origin, (0.0, d.uniform(1.4, 2.2)))
    for piece in _panel(d, place, inner, low, high):
        d.add(piece, part)
    for piece in _grip(d, place, (u0, v0, u1, v1), hinge, high, kind):
        d.add(piece, part)
    if kind == "drawer" and style.tub != "none" and style.fronts != "flush":
        d.add(_tub(d, place, rect, low, depth), part)
    return hole if style.fronts in {"pushed", "inset", "flush"} else None


def _panel(d: Drawing, place: Place, inner: Floats, low: float, high: float) -> list[Surface]:
    """The leaf of a front in its outline."""
    style = d.style
    size = float(np.ptp(inner, axis=0).min())
    if style.fronts == "flush":
        return [plate(place, inner, w=low)]
    back = style.fronts != "pushed"
    looks = style.panel if size > 0.09 and len(inner) == 4 else "slab"
    if looks == "slab":
        return [extrude(place, inner, low, high, back=back)]
    border = d.uniform(0.1, 0.22) * size
    (a, b), (c, e) = inner.min(axis=0), inner.max(axis=0)
    field_ = rectangle(a + border, b + border, c - border, e - border)
    sunk = low + d.uniform(0.3, 0.7) * (high - low)
    if looks == "window":  # a hole with a pane in it
        ring = extrude(place, inner, low, high, [field_], back=back)
        return [ring, plate(place, field_, w=sunk)]
    if looks == "pane":  # a darker pane on the leaf, a piece of its own
        return [extrude(place, inner, low, high, back=back), plate(place, field_, w=high + d.choice([3e-4, 1e-3]))]
    level = sunk if looks == "framed" else high + 0.3 * (high - low)
    leaf = extrude(place, inner, low, high, back=back, face=False)
    step = extrude(place, field_, high, level, face=False, back=False)
    step = (step[0], step[1][:, ::-1]) if level < high else step
    return [joined([leaf, plate(place, inner, [field_], w=high), step, plate(place, field_, w=level)])]


def _grip(d: Drawing, place: Place, rect: Rect, hinge: Edge | None, high: float, kind: str) -> list[Surface]:
    """What a front is held by, across from its hinge; of a drawer in the middle or near its top."""
    u0, v0, u1, v1 = rect
    wide, tall = u1 - u0, v1 - v0
    inset = min(0.05, 0.12 * min(wide, tall))
    spots: dict[Edge | None, tuple[float, float]] = {
        "left": (u1 - inset, (v0 + v1) / 2 + d.choice([0.0, 0.25, -0.25]) * tall),
        "right": (u0 + inset, (v0 + v1) / 2 + d.choice([0.0, 0.25, -0.25]) * tall),
        "bottom": ((u0 + u1) / 2, v1 - inset),
        "top": ((u0 + u1) / 2, v0 + inset),
        None: ((u0 + u1) / 2, v0 + d.choice([0.5, 0.5, 0.8]) * tall),
    }
    u, v = spots[hinge]
    upright = hinge in {"left", "right"}
    reach = d.uniform(0.15, 0.45) * (tall if upright else wide)
    slim = min(0.012, 0.08 * min(wide, tall))
    grip = d.style.grip
    if grip == "bar":
        half = (slim / 2, reach / 2) if upright else (reach / 2, slim / 2)
        v = float(np.clip(v, v0 + half[1] + 0.003, v1 - half[1] - 0.003))
        out = d.uniform(0.02, 0.05)
        rod = extrude(
            place, rectangle(u - half[0], v - half[1], u + half[0], v + half[1]), high + out - slim, high + out
        )
        posts = []
        for end in (-0.85, 0.85):
            a, b = (u, v + end * half[1]) if upright else (u + end * half[0], v)
            square = rectangle(a - slim / 2, b - slim / 2, a + slim / 2, b + slim / 2)
            posts.append(extrude(place, square, high, high + out - slim, back=False, face=False))
        return [rod, *posts] if d.chance(0.8) else [rod]
    if grip == "knob":
        radius = min(0.018, 0.1 * min(wide, tall))
        spots_u = [u] if kind != "drawer" or wide < 0.6 else [u - wide / 4, u + wide / 4]
        profile = np.array([[0.5 * radius, 0], [0.5 * radius, 0.012], [radius, 0.016], [radius, 0.026], [0.0, 0.03]])
        return [turned(place, a, v, profile + np.array([0.0, high]), d.style.sides) for a in spots_u]
    if grip == "lip":
        ends = {
            "left": (u1 - slim, v0, u1, v1),
            "right": (u0, v0, u0 + slim, v1),
            "top": (u0, v0, u1, v0 + slim),
        }.get(hinge or "", (u0, v1 - slim, u1, v1))
        return [extrude(place, rectangle(*ends), high, high + 0.02)]
    if grip == "groove":  # a dark strip that stands for a recess
        half = (slim, reach / 2) if upright else (reach / 2, slim)
        v = float(np.clip(v, v0 + half[1] + 0.003, v1 - half[1] - 0.003))
        return [plate(place, rectangle(u - half[0], v - half[1], u + half[0], v + half[1]), w=high + 3e-4)]
    return []


def _tub(d: Drawing, place: Place, rect: Rect, low: float, depth: float) -> Surface:
    """The box of a drawer behind its front, open above or closed; drawn on the plane, whose v is up."""
    u0, v0, u1, v1 = rect
    wall = min(0.012, 0.05 * (u1 - u0))
    a, b, c, e = u0 + wall, v0 + wall, u1 - wall, v0 + d.uniform(0.6, 0.92) * (v1 - v0)
    far = low - d.uniform(0.6, 0.92) * depth
    outer = extrude(place, rectangle(a, b, c, e), far, min(low, -1e-3))
    if d.style.tub == "box" or e - b < 3 * wall:
        return outer
    floor = extrude(place, rectangle(a, b, c, b + wall), far, low)
    sides = [extrude(place, rectangle(s, b + wall, s + wall, e), far, low) for s in (a, c - wall)]
    back = extrude(place, rectangle(a + wall, b + wall, c - wall, e), far, far + wall)
    return joined([floor, *sides, back])


def add_body(d: Drawing, low: Floats, high: Floats, fronts: Sequence[Rect], holes: Sequence[Floats]) -> None:
    """The body of a thing between two corners, with its front at low[1].

    Args:
        fronts: rectangles of the fronts on it. holes: outlines of the holes that fronts and controls need.
    """
    style, place = d.style, front_of(float(low[1]))
    (x0, y0, z0), (x1, y1, z1) = low, high
    if style.boards and style.hollow and not holes:
        _boards(d, low, high, fronts)
        return
    rooms = _rooms(style, fronts)
    cut = [*holes, *(rectangle(*r) for r in rooms if style.fronts in {"gap", "contact"})]
    pieces = [box(low, high, without="f"), plate(place, rectangle(x0, z0, x1, z1), cut)]
    pieces += [inside_out(box((u0, y0, v0), (u1, y1 - 0.02, v1), without="f")) for u0, v0, u1, v1 in rooms]
    if style.fronts == "inset" and not style.hollow:  # the recess that a front sits in
        deep = -style.thick - 1e-3
        recessed = [h for h in holes if float(np.ptp(h, axis=0).min()) > 0.07]
        pieces += [inside_out(extrude(place, h, deep, 0.0, face=False)) for h in recessed]
    for piece in [joined(pieces)] if d.chance(0.5) else pieces:
        d.add(piece)


def _boards(d: Drawing, low: Floats, high: Floats, fronts: Sequence[Rect]) -> None:
    """A body of boards, with rails and stiles at the edges that fronts have in common."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    t = d.uniform(0.008, 0.02)
    d.add(box((x0, y0, z0), (x0 + t, y1, z1)))
    d.add(box((x1 - t, y0, z0), (x1, y1, z1)))
    d.add(box((x0 + t, y0, z0), (x1 - t, y1, z0 + t)))
    d.add(box((x0 + t, y0, z1 - t), (x1 - t, y1, z1)))
    d.add(box((x0 + t, y1 - t, z0 + t), (x1 - t, y1, z1 - t)))
    for u0, v0, u1, v1 in fronts:
        if v0 > z0 + 3 * t:
            d.add(box((max(u0, x0 + t), y0, v0 - t / 2), (min(u1, x1 - t), y1 - t, v0 + t / 2)))
        if u0 > x0 + 3 * t:
            d.add(box((u0 - t / 2, y0, max(v0, z0 + t)), (u0 + t / 2, y1 - t, min(v1, z1 - t))))


def _rooms(style: Style, fronts: Sequence[Rect]) -> list[Rect]:
    """Openings of the rooms behind fronts, a rim narrower than fronts that lie before the body."""
    rim = 0.012 if style.fronts in {"gap", "contact"} else 0.0
    if not style.hollow or style.fronts == "flush" or (rim and style.tub == "box"):
        return []
    large = [f for f in fronts if min(f[2] - f[0], f[3] - f[1]) > 0.07]
    return [(u0 + rim, v0 + rim, u1 - rim, v1 - rim) for u0, v0, u1, v1 in large]


def add_key(d: Drawing, place: Place, u: float, v: float, wide: float, tall: float, high: float) -> Floats | None:
    """A key that is pressed into a plane; returns the outline of the hole that it needs."""
    outline = {
        "square": lambda: rectangle(u - wide / 2, v - tall / 2, u + wide / 2, v + tall / 2),
        "rounded": lambda: rounded(u - wide / 2, v - tall / 2, u + wide / 2, v + tall / 2, 0.25 * min(wide, tall)),
        "round": lambda: ellipse(u, v, min(wide, tall) / 2, min(wide, tall) / 2, d.style.sides),
        "ellipse": lambda: ellipse(u, v, wide / 2, tall / 2, d.style.sides),
    }[d.style.key]()
    part = d.part("button", "prismatic", -place.axes[2], place.point(u, v), (0.0, max(0.3 * high, 5e-4)))
    return stamp(d, place, outline, high, part)


def stamp(d: Drawing, place: Place, outline: Floats, high: float, part: int, taper: float = 1.0) -> Floats | None:
    """An outline on a plane as the style has controls; returns the hole that it needs."""
    touch = d.style.controls
    if touch == "printed":
        d.add(plate(place, outline, w=PRINTED), part)
    elif touch == "flush":
        d.add(plate(place, outline), part)
    else:
        low = -0.3 * high if touch == "gap" else 0.0
        d.add(extrude(place, outline, low, high, back=touch != "pushed", taper=taper), part)
    return outline if touch in {"pushed", "flush"} else None


def add_knob(d: Drawing, place: Place, u: float, v: float, radius: float, high: float) -> Floats | None:
    """A knob that is turned around the normal of a plane; returns the outline of the hole that it needs."""
    sides, shape = d.style.sides, d.style.knob
    joint = "continuous" if d.chance(0.2) else "revolute"
    part = d.part("knob", joint, place.axes[2], place.point(u, v), (0.0, d.uniform(2.0, 5.0)))
    outline = ellipse(u, v, radius, radius, sides)
    hole = stamp(d, place, outline, high, part, taper=0.75 if shape == "boss" else 1.0)
    if d.style.controls in {"printed", "flush"}:
        return hole
    turn = d.uniform(0.0, np.pi) if d.chance(0.4) else np.pi / 2
    ahead, beside = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    if shape == "bar":
        ends = [(0.9, -0.2), (0.9, 0.2), (-0.9, 0.2), (-0.9, -0.2)]
        bar = np.array([u, v]) + radius * np.array([a * ahead + b * beside for a, b in ends])
        d.add(extrude(place, bar, high, 1.7 * high, back=d.chance(0.5)), part)
    elif shape == "dome":
        profile = np.array([[radius, high], [0.8 * radius, 1.25 * high], [0.0, 1.4 * high]])
        d.add(turned(place, u, v, profile, sides), part)
    elif shape == "dial":
        mark = np.array([u, v]) + radius * np.array(
            [0.5 * ahead, 0.9 * ahead + 0.06 * beside, 0.9 * ahead - 0.06 * beside]
        )
        d.add(plate(place, mark[::-1], w=high + 3e-4), part)
    return hole


def add_keypad(d: Drawing, place: Place, rect: Rect, rows: int, columns: int) -> list[Floats]:
    """A grid of equal keys; returns the outlines of the holes that they need."""
    u0, v0, u1, v1 = rect
    step_u, step_v = (u1 - u0) / columns, (v1 - v0) / rows
    wide, tall = d.uniform(0.5, 0.85) * step_u, d.uniform(0.5, 0.85) * step_v
    if d.chance(0.4):
        wide = tall = min(wide, tall)
    high = d.uniform(0.08, 0.4) * min(wide, tall)
    found = [
        add_key(d, place, u0 + (c + 0.5) * step_u, v0 + (r + 0.5) * step_v, wide, tall, high)
        for r in range(rows)
        for c in range(columns)
    ]
    return [f for f in found if f is not None]


def add_knobs(d: Drawing, place: Place, rect: Rect, count: int) -> list[Floats]:
    """A row of equal knobs along the longer side of a rectangle; returns the holes that they need."""
    u0, v0, u1, v1 = rect
    along = u1 - u0 >= v1 - v0
    spots = np.linspace(u0 if along else v0, u1 if along else v1, count + 1)
    spots = (spots[:-1] + spots[1:]) / 2
    room = min(u1 - u0, v1 - v0, max(u1 - u0, v1 - v0) / count)
    radius = d.uniform(0.25, 0.42) * room
    high = d.uniform(0.5, 1.1) * radius
    across = (v0 + v1) / 2 if along else (u0 + u1) / 2
    found = [add_knob(d, place, *((s, across) if along else (across, s)), radius, high) for s in spots.tolist()]
    return [f for f in found if f is not None]


def add_marks(d: Drawing, place: Place, rect: Rect, count: int) -> None:
    """Things on a surface that do not move: signs, screws, slots, a display; hardly above it."""
    u0, v0, u1, v1 = rect
    least = min(u1 - u0, v1 - v0)
    for _ in range(count):
        u, v = d.uniform(u0 + 0.38 * least, u1 - 0.38 * least), d.uniform(v0 + 0.38 * least, v1 - 0.38 * least)
        kind = d.choice(["sign", "screw", "slots"])
        if kind == "sign":
            a, b = d.uniform(0.15, 0.35) * least, d.uniform(0.05, 0.12) * least
            d.add(plate(place, rectangle(u - a, v - b, u + a, v + b), w=5e-4))
        elif kind == "screw":
            r = d.uniform(0.03, 0.06) * least
            d.add(extrude(place, ellipse(u, v, r, r, d.style.sides), 0.0, 0.4 * r, back=False))
        else:
            a, b = 0.2 * least, 0.02 * least
            for k in range(d.count(2, 5)):
                d.add(plate(place, rectangle(u - a, v + 3 * b * k, u + a, v + 3 * b * k + b), w=5e-4))


def add_feet(d: Drawing, low: Floats, high: Floats, tall: float) -> None:
    """Four feet or legs below a body."""
    size = min(0.08, 0.12 * float(min(high[0] - low[0], high[1] - low[1])))
    inset = d.uniform(0.0, 0.6) * size
    for x in (low[0] + inset, high[0] - inset - size):
        for y in (low[1] + inset, high[1] - inset - size):
            if d.chance(0.5) or tall > 0.1:
                d.add(box((x, y, low[2] - tall), (x + size, y + size, low[2])))
            else:
                ring = ellipse(x + size / 2, y + size / 2, size / 2, size / 2, d.style.sides)
                d.add(extrude(Place(np.array([0.0, 0.0, low[2]]), np.eye(3)), ring, -tall, 0.0))


def bent_tube(points: Sequence[Sequence[float]], radius: float, sides: int, bend: int = 4) -> Surface:
    """A tube along straight pieces whose corners are rounded."""
    corners = [np.array(p, dtype=np.float64) for p in points]
    path = [corners[0]]
    for before, corner, after in zip(corners, corners[1:], corners[2:], strict=False):
        reach = 0.4 * min(float(np.linalg.norm(before - corner)), float(np.linalg.norm(after - corner)))
        a = corner + (before - corner) / np.linalg.norm(before - corner) * reach
        b = corner + (after - corner) / np.linalg.norm(after - corner) * reach
        for t in np.linspace(0, 1, bend + 1):
            path.append((1 - t) ** 2 * a + 2 * t * (1 - t) * corner + t**2 * b)
    path.append(corners[-1])
    return tube(np.array(path), radius, sides)
