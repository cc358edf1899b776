"""Handles of doors and drawers, legs of furniture, and the wire and tubs that racks are made of."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from casa_assets.ext import solids
from casa_assets.ext.arrays import Floats, convex_hull
from casa_assets.ext.records import Capsule, Cylinder, Pose, Vec3, Vec4
from casa_assets.ext.solids import AssetBuilder, Placed, Solid
from casa_assets.kitchenware.parts.cases import tub_walls

WIRE_SIDES = 6  # of a wire

LEATHER = "leather_tan"  # finish of leather straps
EDGE_REACH = 0.024  # metres that an edge pull stands out before the face

HandleKind = StrEnum("HandleKind", "BAR BOXED BOW CUP KNOB RING STRAP TEE LEATHER EDGE_PULL FINGER_GROOVE")

# Handles that are one with an edge of the front; `doors.py` puts them there.
EDGE_HANDLES = (HandleKind.EDGE_PULL, HandleKind.FINGER_GROOVE)
# Handles that are as wide as high, or always lie across.
LEVEL_HANDLES = (HandleKind.CUP, HandleKind.RING, HandleKind.KNOB)
FIXED_LENGTHS = {HandleKind.CUP: 0.096, HandleKind.KNOB: 0.034, HandleKind.RING: 0.056, HandleKind.TEE: 0.06}

# Legs -----------------------------------------------------------------------------------------------------------------


def point_between(a: Vec3, b: Vec3, share: float) -> Vec3:
    """The point at a share of the way from a (0) to b (1)."""
    return a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share, a[2] + (b[2] - a[2]) * share


def on_circle(radius: float, angle: float, z: float) -> Vec3:
    """The point of a level circle about the z axis at an angle, rad."""
    return radius * math.cos(angle), radius * math.sin(angle), z


def round_bar(a: Vec3, b: Vec3, radius: float) -> Solid:
    """A round bar from a to b; its collider is a cylinder."""
    solid = solids.tube([a, b], radius)
    axis = np.array(b) - np.array(a)
    length = float(np.linalg.norm(axis))
    middle = (np.array(a) + np.array(b)) / 2
    x, y, z = (float(v) for v in middle)
    shape = Cylinder(radius=radius, height=length)
    return solid.with_shapes((shape, Pose(position=(x, y, z), quaternion=_onto(axis / length))))


def square_bar(a: Vec3, b: Vec3, width: float, depth: float, up: Vec3 = (0.0, 1.0, 0.0)) -> Solid:
    """A square-edged bar from a to b: `depth` along `up`, `width` across; its collider is a box."""
    return solids.tube([a, b], solids.rectangle(width, depth, min(width, depth) * 0.12, 1), up=up)


def tapered_leg(a: Vec3, b: Vec3, start: float, end: float, sides: int = 20) -> Solid:
    """A round leg whose radius goes from `start` at a to `end` at b; its collider is a cylinder of the mean radius."""
    axis = np.array(b) - np.array(a)
    length = float(np.linalg.norm(axis))
    ring = solids.circle(1.0, sides)
    start_ring = np.column_stack([ring * start, np.zeros(sides)])
    points, faces = convex_hull(np.concatenate([start_ring, np.column_stack([ring * end, np.full(sides, length)])]))
    x, y, z = a
    pose = Pose(position=(x, y, z), quaternion=_onto(axis / length))
    shape = (Cylinder(radius=(start + end) / 2, height=length), Pose(position=(0.0, 0.0, length / 2)))
    return Solid(points, faces, (shape,), crease_deg=40.0).transformed(pose)


def bowed_slat(size: Vec3, at: Vec3, bow: float, steps: int = 8) -> Solid:
    """A board bowed backwards (+y) in its middle: width x, thickness y, height z; its collider is the bounding box."""
    w, t, h = size
    xs = np.linspace(-w / 2, w / 2, steps + 1)
    ys = bow * (1 - (2 * xs / w) ** 2)
    outline = np.concatenate([np.column_stack([xs, ys - t / 2]), np.column_stack([xs, ys + t / 2])[::-1]])
    bottom = np.column_stack([outline, np.full(len(outline), -h / 2)])
    solid = solids.loft([bottom, np.column_stack([outline, np.full(len(outline), h / 2)])], 40.0)
    return solid.with_box_collider().translated(*at)


def _onto(direction: Floats) -> Vec4:
    x, y, z = (float(v) for v in direction)
    if z < -1 + 1e-9:
        return (0.0, 1.0, 0.0, 0.0)
    w = 1.0 + z
    n = math.sqrt(w * w + x * x + y * y)
    return (w / n, -y / n, x / n, 0.0)


# Tubs -----------------------------------------------------------------------------------------------------------------


def open_tub(width: float, depth: float, height: float, wall: float, radius: float, floor: float = 0.0) -> Solid:
    """An open box about x = 0, y = 0 from z = 0 up, its corners rounded; its colliders are a floor and four walls.

    width, depth, height: outside, metres. wall: its thickness. radius: of the upright corners. floor: thickness of the
    bottom; 0 for that of the walls.
    """
    base = floor or wall
    edge_radius = min(0.004, 0.3 * height)
    outline = solids.rectangle(width, depth, radius, 5)
    steps = [(edge_radius, 0.0), (0.0, edge_radius), (0.0, height - 0.001), (0.3 * wall, height), (0.7 * wall, height)]
    body = solids.loft(solids.inset_rings(outline, [*steps, (wall, height - 0.001), (wall, base)]), 45.0)
    w, d = width / 2, depth / 2
    walls = tub_walls(((-w, -d, 0.0), (w, d, height)), ((-w + wall, -d + wall, base), (w - wall, d - wall, height)))
    return body.with_shapes(*(solids.box_shape(*corners) for corners in walls))


def wire_loop(width: float, depth: float, z: float, radius: float, corner: float) -> Solid:
    """A level ring of wire about x = 0, y = 0: `width` by `depth` over the middle of the wire; without collider."""
    w, d = width / 2, depth / 2
    path = [(0.0, -d, z), (w, -d, z), (w, d, z), (-w, d, z), (-w, -d, z), (0.0, -d, z)]
    return solids.tube(path, solids.circle(radius, 8), corner).without_colliders()


def wire(path: list[Vec3], radius: float, bend: float = 0.0) -> Solid:
    """A wire along corner points, bent round with a radius, metres; without collider."""
    return solids.tube(path, solids.circle(radius, WIRE_SIDES), bend).without_colliders()


def wire_grid(width: float, depth: float, z: float, radius: float, across: int, along: int) -> Solid:
    """Crossed wires about x = 0, y = 0: `across` run from front to back, `along` from left to right just below them."""
    w, d = width / 2, depth / 2
    out = [wire([(float(x), -d, z), (float(x), d, z)], radius) for x in np.linspace(-w, w, across)]
    low, places = z - 1.6 * radius, np.linspace(-d, d, along + 2)[1:-1]
    out += [wire([(-w, float(y), low), (w, float(y), low)], radius) for y in places]
    return solids.concatenate(out)


# Handles --------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Handle:
    """A handle along x on a front's plane y = 0, out to -y, its foot about the origin; a hand takes the first shape."""

    metal: tuple[Solid, ...]
    shapes: tuple[Placed, ...]
    leather: tuple[Solid, ...] = ()

    @property
    def reach(self) -> float:
        """Distance that it projects, metres."""
        return -min(float(solid.bounds[0, 1]) for solid in (*self.metal, *self.leather))

    def transformed(self, pose: Pose) -> Handle:
        """Moved by `pose`."""
        return Handle(
            tuple(s.transformed(pose) for s in self.metal),
            tuple((shape, pose @ at) for shape, at in self.shapes),
            tuple(s.transformed(pose) for s in self.leather),
        )


def handle_length(kind: HandleKind, wanted: float) -> float:
    """Length of a handle of the kind where `wanted` metres are asked for, metres."""
    return FIXED_LENGTHS.get(kind, wanted)


def handle_reach(kind: HandleKind) -> float:
    """Distance that a handle of the kind projects in front of the face of a door, metres."""
    if kind is HandleKind.FINGER_GROOVE:
        return 0.0
    if kind is HandleKind.EDGE_PULL:
        return EDGE_REACH
    kind = HandleKind.KNOB if kind is HandleKind.CUP else kind
    return handle(kind, 0.16).reach


def handle(kind: HandleKind, length: float) -> Handle:
    """A handle of a length along x. Raises KeyError for those that are one with an edge."""
    return _MAKERS[kind](length)


def add_handle(builder: AssetBuilder, link: str, pull: Handle, metal: str, name: str) -> None:
    """Put a handle on a link; its grip's collider is called `name`, its mesh `<name>_visual`."""
    builder.draw(link, pull.metal, metal, "handle", name=name, density="handle_casting")
    builder.draw(link, pull.leather, LEATHER, "handle", name=f"{name}_hide", density="leather")
    builder.add_collider(link, pull.metal[0].with_shapes(*pull.shapes), metal, "handle", name)


def grip_capsule(length: float, radius: float, y: float) -> Placed:
    """A capsule collider along x whose axis lies at y; length over its round ends, metres."""
    pose = Pose(position=(0.0, y, 0.0), quaternion=(math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0))
    return Capsule(radius=radius, height=length - 2 * radius), pose


def collider_box(x: float, y0: float, y1: float, width: float, height: float) -> Placed:
    """A box collider about x and z = 0, from y0 to y1; width along x, height along z, metres."""
    return solids.box_shape((x - width / 2, y0, -height / 2), (x + width / 2, y1, height / 2))


def _post(x: float, reach: float, radius: float, foot_radius: float) -> Solid:
    line = [(foot_radius, 0.0), (foot_radius, 0.0025), (foot_radius - 0.0012, 0.004), (radius, 0.005), (radius, reach)]
    return solids.lathe(line, segments=12).rotated("x", math.pi / 2).translated(x)


def _bar(length: float) -> Handle:
    radius, reach, at = 0.006, 0.038, max(0.02, length / 2 - 0.035)
    grip = solids.rod(radius, length, 0.0015, "x").translated(0.0, -reach)
    posts = tuple(_post(x, reach, 0.0042, 0.0065) for x in (-at, at))
    feet = tuple(collider_box(x, -reach + radius, 0.0, 0.011, 0.011) for x in (-at, at))
    return Handle((grip, *posts), (grip_capsule(length, radius, -reach), *feet))


def _boxed(length: float) -> Handle:
    thickness, depth, reach = 0.012, 0.01, 0.04
    h = length / 2 - thickness / 2
    path = [(-h, 0.0, 0.0), (-h, -reach + depth / 2, 0.0), (h, -reach + depth / 2, 0.0), (h, 0.0, 0.0)]
    grip = solids.tube(path, solids.rectangle(thickness, thickness, 0.0015, 2))
    legs = tuple(collider_box(x, -reach + depth, 0.0, thickness, thickness) for x in (-h, h))
    return Handle((grip,), (collider_box(0.0, -reach - 0.001, -reach + depth + 0.001, length, thickness), *legs))


def _bow(length: float) -> Handle:
    radius, reach, h = 0.0055, 0.036, length / 2 - 0.01
    corners = [(-h, 0.0, 0.0), (-0.72 * h, -reach, 0.0), (0.72 * h, -reach, 0.0), (h, 0.0, 0.0)]
    path = solids.round_corners(corners, 0.05, 6)
    grip = solids.tube([(float(x), float(y), float(z)) for x, y, z in path], radius)
    feet = tuple(solids.rod(0.0095, 0.004, 0.0015, "y").translated(x, -0.002) for x in (-h, h))
    ends = tuple(collider_box(s * 0.86 * h, -0.75 * reach, 0.0, 0.28 * h, 0.012) for s in (-1, 1))
    return Handle((grip, *feet), (grip_capsule(1.3 * h, radius, -reach), *ends))


def _cup(length: float) -> Handle:
    w, d, h, wall = length / 2 - 0.005, 0.027, 0.036, 0.003

    def shell(thin: float) -> Solid:
        scale = np.array([w - thin, d - thin, h - thin])
        sphere = solids.ball(1.0, 14)
        return Solid(sphere.points * scale, sphere.faces, crease_deg=50.0)

    below = solids.box((0.3, 0.3, 0.3), (0.0, 0.0, -0.15), 0.0)
    behind = solids.box((0.3, 0.3, 0.3), (0.0, 0.15, 0.0), 0.0)
    cup = solids.subtract(shell(0.0), shell(wall), below, behind).translated(0.0, 0.0, -h / 2)
    turns = np.linspace(0.0, math.pi, 17)
    rim = [((w + 0.005) * math.cos(a), (h + 0.005) * math.sin(a)) for a in turns]
    plate = solids.prism(np.array([*rim, (-w - 0.005, -0.003), (w + 0.005, -0.003)]), 0.002, 0.0006)
    flange = plate.rotated("x", math.pi / 2).translated(0.0, 0.0, -h / 2)
    z = -h / 2
    shapes = (
        solids.box_shape((-0.72 * w, -d, z), (0.72 * w, -d + 0.006, z + 0.6 * h)),
        solids.box_shape((-0.8 * w, -0.8 * d, z + 0.6 * h), (0.8 * w, 0.0, z + h)),
        *(solids.box_shape((x - 0.006, -0.7 * d, z), (x + 0.006, 0.0, z + 0.7 * h)) for x in (-w + 0.006, w - 0.006)),
    )
    return Handle((cup, flange), shapes)


def _knob(length: float) -> Handle:
    r, reach = length / 2, 0.03
    line = [(0.5 * r, 0.0), (0.5 * r, 0.002), (0.38 * r, 0.006), (0.36 * r, 0.013), (0.8 * r, 0.0175)]
    line += [(r, 0.021), (r, 0.0235), (0.92 * r, 0.0265), (0.7 * r, 0.029), (0.35 * r, reach)]
    head = solids.lathe(line, segments=24, crease_deg=50.0).rotated("x", math.pi / 2)
    grip = collider_box(0.0, -reach, -0.0165, 1.8 * r, 1.8 * r)
    return Handle((head,), (grip, collider_box(0.0, -0.0165, 0.0, 0.013, 0.013)))


def _ring(length: float) -> Handle:
    r, wire, reach = length / 2 - 0.0035, 0.0035, 0.024
    turns = np.linspace(0.0, 2 * math.pi, 25)
    loop = solids.tube(([(r * math.cos(a), -reach, r * math.sin(a) - r) for a in turns]), wire, up=(0.0, 1.0, 0.0))
    rosette = solids.lathe([(0.016, 0.0), (0.016, 0.002), (0.012, 0.0045), (0.007, 0.006)], 24)
    rosette = rosette.rotated("x", math.pi / 2)
    post = solids.rod(0.0055, reach + 0.006, 0.002, "y").translated(0.0, -(reach + 0.006) / 2)
    z = -2 * r
    shapes = (
        solids.box_shape((-0.55 * r, -reach - wire, z - wire), (0.55 * r, -reach + wire, z + wire + 0.003)),
        *(
            solids.box_shape((x - 0.004, -reach - wire, z + 0.5 * r), (x + 0.004, -reach + wire, -0.5 * r))
            for x in (-r, r)
        ),
        # A finger that lies in the ring comes close to its foot, so post and rosette are touched as they are.
        solids.box_shape((-0.0055, -reach - 0.006, -0.0055), (0.0055, 0.0, 0.0055)),
        solids.box_shape((-0.0125, -0.006, -0.0125), (0.0125, 0.0, 0.0125)),
    )
    return Handle((loop, rosette, post), shapes)


def _flat(length: float, width: float, thickness: float, reach: float) -> tuple[Solid, tuple[Placed, ...]]:
    h, end_length, rise = length / 2, 0.022, 0.03
    y = -thickness / 2
    corners = [(-h, y, 0.0), (-h + end_length, y, 0.0), (-h + end_length + rise, -reach, 0.0)]
    path = solids.round_corners([*corners, *((-a, b, c) for a, b, c in corners[::-1])], 0.02, 5)
    section = solids.rectangle(thickness, width, 0.3 * thickness, 2)
    strap = solids.tube([(float(a), float(b), float(c)) for a, b, c in path], section)
    inner = h - end_length - rise
    grip = solids.box_shape((-inner, -reach - thickness / 2, -width / 2), (inner, -reach + thickness / 2, width / 2))
    ends = tuple(
        solids.box_shape((min(a, b), -0.8 * reach, -width / 2), (max(a, b), 0.0, width / 2))
        for a, b in ((-h + end_length, -inner), (inner, h - end_length))
    )
    return strap, (grip, *ends)


def _strap(length: float) -> Handle:
    strap, shapes = _flat(max(length, 0.15), 0.018, 0.004, 0.034)
    return Handle((strap,), shapes)


def _leather(length: float) -> Handle:
    size = max(length, 0.16)
    strap, shapes = _flat(size, 0.024, 0.005, 0.034)
    stud = solids.lathe([(0.0065, 0.0), (0.0065, 0.001), (0.005, 0.0026), (0.002, 0.0034)], 16)
    stud = stud.rotated("x", math.pi / 2)
    studs = solids.concatenate([stud.translated(x, -0.0052) for x in (-size / 2 + 0.011, size / 2 - 0.011)])
    return Handle((studs,), shapes, (strap,))


def _tee(length: float) -> Handle:
    radius, reach = 0.006, 0.034
    grip = solids.rod(radius, length, 0.0015, "x").translated(0.0, -reach)
    post = _post(0.0, reach, 0.0055, 0.008)
    foot = collider_box(0.0, -reach + radius, 0.0, 0.012, 0.012)
    return Handle((grip, post), (grip_capsule(length, radius, -reach), foot))


_MAKERS = {
    HandleKind.BAR: _bar, HandleKind.BOXED: _boxed, HandleKind.BOW: _bow, HandleKind.CUP: _cup, HandleKind.KNOB: _knob,
    HandleKind.RING: _ring, HandleKind.STRAP: _strap, HandleKind.TEE: _tee, HandleKind.LEATHER: _leather,
}  # fmt: skip


def edge_pull(length: float) -> Handle:
    """An angle of sheet metal screwed on an edge; along x, lying on the plane z = 0 (the edge), the face in y = 0."""
    thickness, reach, drop = 0.0022, EDGE_REACH, 0.014
    plate = solids.box((length, reach + 0.014, thickness), (0.0, (0.014 - reach) / 2, thickness / 2), 0.0006)
    hook = solids.box((length, thickness, drop), (0.0, -reach + thickness / 2, thickness - drop / 2 - 0.0006), 0.0006)
    shapes = (
        solids.box_shape((-length / 2, -reach, thickness - drop), (length / 2, -reach + thickness + 0.001, thickness)),
        solids.box_shape((-length / 2, -reach, 0.0), (length / 2, 0.014, thickness)),
    )
    return Handle((plate, hook), shapes)


def placed_handle(pull: Handle, axis: str, angle: float, at: Vec3) -> Handle:
    """A handle rotated about an axis through its foot by radians, its foot then moved to a point."""
    return pull.transformed(Pose(position=at) @ solids.axis_turn(axis, angle))
