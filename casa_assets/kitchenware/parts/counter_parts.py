"""Parts of what stands on a counter: cases, heads of mixers, parts of coffee machines, and jars of blenders."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from casa_assets.ext import solids
from casa_assets.ext.arrays import Floats, convex_hull
from casa_assets.ext.records import Hull, Mesh, Pose, Sphere, Vec2, Vec3
from casa_assets.ext.solids import ROOT, AssetBuilder, Placed, Solid

# Case -----------------------------------------------------------------------------------------------------------------

FLAT_BAND = 0.0015  # metres
LINER_THICKNESS = 0.0006  # metres of sheet that lines the inside of an oven or a microwave


def cavity_walls(outer: tuple[Vec3, Vec3], inner: tuple[Vec3, Vec3]) -> list[tuple[Vec3, Vec3]]:
    """Corners of five boards round a cavity that is open to the front (-y): left, right, floor, roof, back.

    outer, inner: lower and upper corners of the outside and of the cavity, metres; all boards begin at the outer front,
    and the side walls run over the whole height.
    """
    ((x0, y0, z0), (x1, y1, z1)), ((a0, _, c0), (a1, b1, c1)) = outer, inner
    return [
        ((x0, y0, z0), (a0, y1, z1)), ((a1, y0, z0), (x1, y1, z1)), ((a0, y0, z0), (a1, y1, c0)),
        ((a0, y0, c1), (a1, y1, z1)), ((a0, b1, c0), (a1, y1, c1)),
    ]  # fmt: skip


def cavity_colliders(outer: tuple[Vec3, Vec3], inner: tuple[Vec3, Vec3]) -> tuple[Placed, ...]:
    """The boards of `cavity_walls` as box colliders."""
    return tuple(solids.box_shape(*corners) for corners in cavity_walls(outer, inner))


def add_liner(
    builder: AssetBuilder,
    lower: Vec3,
    upper: Vec3,
    finish: str,
    density: str | None,
    thickness: float = LINER_THICKNESS,
) -> None:
    """Add sheets without colliders on the left, right, floor, roof and back of a cavity between two corners, metres."""
    (x0, y0, z0), (x1, y1, z1), t = lower, upper, thickness
    for a, b in (
        ((x0, y0, z0), (x0 + t, y1, z1)),
        ((x1 - t, y0, z0), (x1, y1, z1)),
        ((x0 + t, y0, z0), (x1 - t, y1 - t, z0 + t)),
        ((x0 + t, y0, z1 - t), (x1 - t, y1 - t, z1)),
        ((x0 + t, y1 - t, z0 + t), (x1 - t, y1, z1 - t)),
    ):
        builder.draw(ROOT, solids.board(a, b, 0.0), finish, "liner", density=density)


def rounded_polygon(points: Sequence[Vec2], radius: float) -> Floats:
    """(N, 2) closed polygon with its corners rounded; points counter-clockwise, metres."""
    first, last = np.array(points[0]), np.array(points[-1])
    middle = (first + last) / 2
    line = [(float(middle[0]), float(middle[1]), 0.0)]
    path = solids.round_corners([*line, *((x, y, 0.0) for x, y in points), *line], radius)[:-1, :2]
    # Neighbours that fall together would have no direction.
    return np.asarray(path[(np.linalg.norm(path - np.roll(path, 1, axis=0), axis=1) > 1e-6)])


def extrude_across(outline: Floats, width: float, chamfer: float) -> Solid:
    """An outline in y, z (counter-clockwise, y to the right) pulled along x, centred on x = 0."""
    solid = solids.prism(outline, width, chamfer)
    return Solid(solid.points[:, [2, 0, 1]] - np.array([width / 2, 0.0, 0.0]), solid.faces, crease_deg=40.0)


def rounded_body(width: float, depth: float, steps: Sequence[Vec2], radius: float, corner: int = 6) -> Solid:
    """A body of rounded rectangles above each other: (inset, z) each from below, metres, about the origin.

    Insets above half of the narrower side are cut to it.
    """
    rings = []
    # A narrow flat band inside each cap keeps the shading of the round edge off the cap.
    (bottom_inset, bottom), (top_inset, top) = steps[0], steps[-1]
    for inset, z in ((bottom_inset + FLAT_BAND, bottom), *steps, (top_inset + FLAT_BAND, top)):
        w, d = max(width - 2 * inset, 0.004), max(depth - 2 * inset, 0.004)
        ring = solids.rectangle(w, d, max(radius - inset, 0.15 * min(w, d)), corner)
        rings.append(np.column_stack([ring, np.full(len(ring), z)]))
    return solids.loft(rings)


def dome_profile(rise: float, reach: float, z: float) -> list[Vec2]:
    """(inset, z) of a rounded upper edge that goes in by `reach` while it rises by `rise` to z, metres."""
    turns = np.linspace(0.0, math.pi / 2, 6)
    return [(float(reach * (1 - math.cos(t))), float(z - rise + rise * math.sin(t))) for t in turns]


def round_wall_pieces(
    inner: Sequence[Vec2], outer: Sequence[Vec2], count: int = 12, start: float = 0.0, bulge: Sequence[Vec2] = ()
) -> list[Placed]:
    """Convex pieces of a round wall: between (radius, z) profiles that run upwards, one piece for each stretch.

    inner, outer: equally many points, metres. count: pieces around. start: angle of the first one's edge, rad. bulge:
    points of the outside that the pieces reach as well, each between two of the profile.
    """
    out: list[Placed] = []
    for k in range(len(inner) - 1):
        reached = [(r, z) for r, z in bulge if outer[k][1] < z < outer[k + 1][1]]
        for i in range(count):
            a, b = start + 2 * math.pi * i / count, start + 2 * math.pi * (i + 1) / count
            # Chords of the inner wall lie inside the circle: the hollow is as wide as it says at their middles.
            grow = 1.0 / math.cos(math.pi / count)
            cloud = [
                (r * g * math.cos(t), r * g * math.sin(t), z)
                for profile, g in ((inner[k : k + 2], grow), (outer[k : k + 2], 1.0), (reached, 1.0))
                for r, z in profile
                for t in (a, b)
            ]
            points, faces = convex_hull(np.array(cloud))
            out.append((Hull(mesh=Mesh(vertices=points, faces=faces)), Pose()))
    return out


def round_feet(places: Sequence[Vec2], radius: float, height: float) -> list[Solid]:
    """Round feet from z = 0 to `height` at points of the ground.

    Each collides as a ball of the foot's radius, so it touches a worktop at one point, while a disc touches at four: an
    object on four feet costs an engine four contacts instead of 16.
    """
    pad = solids.rod(radius, height, min(0.0015, 0.3 * height)).translated(0.0, 0.0, height / 2)
    feet = pad.with_shapes((Sphere(radius=radius), Pose(position=(0.0, 0.0, radius))))
    return [feet.translated(x, y) for x, y in places]


def inset_corners(width: float, front: float, back: float, inset: float) -> list[Vec2]:
    """Four points inside a rectangle that is centred on x = 0, metres."""
    return [(s * (width / 2 - inset), y) for s in (-1, 1) for y in (front + inset, back - inset)]


def thin_panel(lower: Vec3, upper: Vec3, edge_radius: float = 0.0012, steps: int = 2) -> Solid:
    """A panel between two corners without collider."""
    return solids.board(lower, upper, edge_radius, steps).without_colliders()


# Mixer ----------------------------------------------------------------------------------------------------------------

UNDERSIDE_SHARE = 0.8  # share of half the height at which a section of the head is cut off below

MixerTool = StrEnum("MixerTool", "WHISK BEATER HOOK")


def head_section(y: float, width: float, height: float, middle: float, power: float, count: int = 28) -> Floats:
    """(N, 3) outline of the head in a plane across it, flat below; metres. `power` 2 is an ellipse, more is boxy."""
    turns = np.arange(count) * 2 * np.pi / count
    c, s = np.cos(turns), np.sin(turns)
    x = width / 2 * np.sign(c) * np.abs(c) ** (2 / power)
    z = height / 2 * np.sign(s) * np.abs(s) ** (2 / power)
    return np.column_stack([-x, np.full(count, y), middle + np.maximum(z, -UNDERSIDE_SHARE * height / 2)])


@dataclass(frozen=True)
class MixerHead:
    """A head from y = front to back, its flat underside on z = 0.

    width, height: metres. nose_share: share of both that is left at the front. power: of its sections. bluntness: of
    its ends; 2 is a half ball, 8 nearly flat.
    """

    front: float
    back: float
    width: float
    height: float
    nose_share: float
    power: float
    bluntness: float

    @property
    def middle(self) -> float:
        """Height of the axis, metres."""
        return UNDERSIDE_SHARE * self.height / 2

    def scale(self, t: float) -> float:
        """Share of the full section at a share of its length from the front."""
        end = (1 - abs(2 * t - 1) ** self.bluntness) ** (1 / self.bluntness)
        return float(end * (1 - (1 - self.nose_share) * (1 - t) ** 1.6))

    def ring(self, t: float, more: float = 0.0, count: int = 28) -> Floats:
        """(N, 3) outline at a share of its length, wider all round by `more` metres."""
        k, y = self.scale(t), self.front + t * (self.back - self.front)
        return head_section(y, self.width * k + 2 * more, self.height * k + 2 * more, self.middle, self.power, count)


def head_solid(form: MixerHead) -> Solid:
    """The skin of a head."""
    shares = 0.5 - 0.5 * np.cos(np.linspace(0.04, math.pi - 0.04, 17))
    return solids.loft([form.ring(float(t)) for t in shares], 50.0).oriented_outwards()


def head_band(form: MixerHead, y: float) -> Solid:
    """A strip of 8 mm around a head at y, metres, that projects by a millimetre."""
    shares = [(y + d - form.front) / (form.back - form.front) for d in (-0.004, 0.0, 0.004)]
    return solids.loft([form.ring(t, 0.001, 44) for t in shares], 50.0).oriented_outwards()


def tool_solid(kind: MixerTool, length: float) -> Solid:
    """Solid of a tool that hangs from z = 0 to -length on the axis x = y = 0, with a hull collider."""
    shaft = solids.rod(0.0055, 0.034, 0.001).translated(z=-0.017)
    collar = solids.lathe([(0.011, -0.036), (0.013, -0.033), (0.013, -0.027), (0.008, -0.024)], 20)
    return solids.concatenate([shaft, collar, *_MAKERS[kind](length)]).with_hull_collider()


def _whisk(length: float) -> list[Solid]:
    wires = []
    for k in range(5):
        turn = math.pi * k / 5
        path: list[Vec3] = []
        for t in np.linspace(0.0, 2 * math.pi, 19)[1:-1]:
            r = 0.043 * math.sin(t) * (1.0 - 0.3 * (1 + math.cos(t)) / 2)
            path.append((r * math.cos(turn), r * math.sin(turn), (-0.03 - (length - 0.032) * (1 - math.cos(t)) / 2)))
        wires.append(solids.tube(path, solids.circle(0.0011, 6)).without_colliders())
    return wires


def _beater(length: float) -> list[Solid]:
    """A flat frame with ribs."""
    half_width, bottom = 0.041, -length
    loop: list[Vec3] = [
        (0.0, 0.0, -0.034), (half_width, 0.0, -0.05), (half_width, 0.0, bottom + 0.03), (0.004, 0.0, bottom + 0.003),
        (-0.004, 0.0, bottom + 0.003), (-half_width, 0.0, bottom + 0.03), (-half_width, 0.0, -0.05), (0.0, 0.0, -0.034),
    ]  # fmt: skip
    frame = solids.tube(loop, solids.rectangle(0.006, 0.0075, 0.002, 2), 0.006, up=(0.0, 1.0, 0.0)).without_colliders()
    rib = solids.tube(
        [(0.0, 0.0, -0.036), (0.0, 0.0, bottom + 0.004)], solids.rectangle(0.005, 0.006, 0.0015, 2), up=(0.0, 1.0, 0.0)
    )
    path = [(-half_width, 0.0, -0.068), (half_width, 0.0, -0.068)]
    bar = solids.tube(path, solids.rectangle(0.005, 0.006, 0.0015, 2), up=(0.0, 1.0, 0.0))
    return [frame, rib.without_colliders(), bar.without_colliders()]


def _hook(length: float) -> list[Solid]:
    path: list[Vec3] = [(0.0, 0.0, -0.03)]
    for t in np.linspace(0.0, 1.0, 15):
        angle = 2 * math.pi * 0.9 * float(t)
        r = 0.034 * math.sin(math.pi * (0.15 + 0.75 * float(t)))
        path.append((r * math.cos(angle), r * math.sin(angle), -0.04 - (length - 0.046) * float(t)))
    return [solids.tube(path, solids.circle(0.0055, 10)).without_colliders()]


_MAKERS = {MixerTool.WHISK: _whisk, MixerTool.BEATER: _beater, MixerTool.HOOK: _hook}


def bowl_profile(base_radius: float, rim_radius: float, depth: float) -> list[Vec2]:
    """(radius, z) of a bowl's outside from its foot to its rim, metres; z from 0 to depth."""
    wider = rim_radius - base_radius
    turns = np.linspace(0.0, 1.0, 9)
    return [(float(base_radius + wider * math.sin(t * math.pi / 2) ** 0.8), float(depth * t)) for t in turns]


def radius_at(line: Sequence[Vec2], z: float) -> float:
    """Radius of a profile at a height, metres."""
    return float(np.interp(z, [b for _, b in line], [a for a, _ in line]))


# Coffee ---------------------------------------------------------------------------------------------------------------


def add_drip_tray(builder: AssetBuilder, lower: Vec3, upper: Vec3, metal: str) -> None:
    """Add a dark tray with a grid on top to the root link, between two corners, metres; cups are placed at upper[2]."""
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    pan = solids.subtract(
        solids.board(lower, (x1, y1, z1 - 0.0006), 0.003, 2),
        solids.board((x0 + 0.006, y0 + 0.006, z0 + 0.006), (x1 - 0.006, y1 - 0.006, 1.0), 0.0),
    )
    builder.draw(ROOT, pan, "plastic_black", "tray")
    builder.add_collider(ROOT, solids.board(lower, upper, 0.0), metal, "tray", "drip_tray")
    for y in (y0 + 0.008, y1 - 0.008):
        rail = solids.board((x0 + 0.0064, y - 0.0016, z1 - 0.003), (x1 - 0.0064, y + 0.0016, z1), 0.0005)
        builder.draw(ROOT, rail, metal, "tray")
    count = max(5, int((x1 - x0 - 0.02) / 0.0085))
    for k in range(count):
        x = x0 + 0.011 + (x1 - x0 - 0.022) * k / (count - 1)
        slat = solids.board((x - 0.0017, y0 + 0.0065, z1 - 0.0024), (x + 0.0017, y1 - 0.0065, z1 - 0.0003), 0.0)
        builder.draw(ROOT, slat, metal, "tray")


def add_brew_group(builder: AssetBuilder, at: Vec3, ceiling: float, metal: str, grip: str) -> None:
    """A brewing group under a ceiling with a portafilter whose two spouts end at `at`, its handle to the front."""
    x, y, z = at
    head = solids.rod(0.036, ceiling - z - 0.034, 0.003).translated(x, y, (ceiling + z + 0.034) / 2)
    builder.add(ROOT, head, metal, "group", collider="group_head", density="brewing_casting")
    ring = solids.rod(0.041, 0.01, 0.002).translated(x, y, z + 0.0392)
    builder.draw(ROOT, ring, metal, "portafilter", density="brewing_casting")
    basket = solids.lathe([(0.02, z + 0.016), (0.034, z + 0.0215), (0.0352, z + 0.034)], 28).translated(x, y)
    portafilter = basket.with_box_collider()
    builder.add(ROOT, portafilter, metal, "portafilter", collider="portafilter_basket", density="brewing_casting")
    for s in (-1, 1):
        spout = solids.tube([(x, y, z + 0.014), (x + s * 0.012, y, z + 0.011), (x + s * 0.012, y, z)], 0.0048, 0.006)
        builder.draw(ROOT, spout, metal, "portafilter")
    builder.draw(ROOT, solids.tube([(x, y - 0.03, z + 0.028), (x, y - 0.066, z + 0.026)], 0.006), metal, "portafilter")
    line = [(0.0075, 0.0), (0.0125, 0.012), (0.0118, 0.05), (0.0142, 0.085), (0.011, 0.097), (0.004, 0.1)]
    handle = solids.lathe(line, 20, 60.0).rotated("x", math.pi / 2 + 0.06).translated(x, y - 0.064, z + 0.0262)
    builder.add(ROOT, handle.with_hull_collider(), grip, "portafilter", collider="portafilter_grip")


def add_spout(builder: AssetBuilder, at: Vec3, ceiling: float, finish: str, twin: bool) -> None:
    """A block under a ceiling from which one or two spouts look down; `at` is their lower end."""
    x, y, z = at
    width = 0.06 if twin else 0.034
    block = solids.board((x - width / 2, y - 0.022, z + 0.008), (x + width / 2, y + 0.022, ceiling), 0.005, 3)
    builder.add(ROOT, block, finish, "spout", collider="spout", density="hollow_moulding")
    for dx in (-0.014, 0.014) if twin else (0.0,):
        tip = solids.lathe([(0.0042, z), (0.0062, z + 0.0085)], 16).translated(x + dx, y)
        builder.draw(ROOT, tip, "plastic_black", "spout")


def add_steam_wand(builder: AssetBuilder, at: Vec3, tip_z: float, metal: str) -> None:
    """A steam wand that hangs from `at` down to z = low, leaning out to its side (the sign of x)."""
    x, y, z = at
    side = math.copysign(1.0, x)
    builder.draw(ROOT, solids.rod(0.011, 0.018, 0.004).translated(x, y, z - 0.004), metal, "wand")
    pipe = solids.tube([(x, y, z), (x, y, z - 0.03), (x + side * 0.02, y - 0.015, tip_z)], 0.0042, 0.012)
    builder.add(ROOT, pipe, metal, "wand", density="steam_wand")
    sleeve = solids.tube(
        [
            (x + side * 0.0095, y - 0.007, tip_z + (z - tip_z) * 0.5),
            (x + side * 0.0155, y - 0.0117, tip_z + (z - tip_z) * 0.22),
        ],
        0.0066,
    )
    builder.draw(ROOT, sleeve, "rubber_black", "wand")


def add_bean_hopper(builder: AssetBuilder, x: float, y: float, z: float, size: float, height: float) -> None:
    """Add a transparent funnel for beans with a lid; z is the height of the surface below it."""
    steps = [(0.022, z), (0.0, z + 0.5 * height), (0.0, z + height - 0.012)]
    body = rounded_body(size, size, steps, 0.03).translated(x, y)
    builder.add(ROOT, body.with_hull_collider(), "plastic_smoked", "hopper", density="bean_hopper")
    beans = rounded_body(size - 0.008, size - 0.008, [(0.022, z + 0.003), (0.002, z + 0.45 * height)], 0.028)
    beans = beans.translated(x, y)
    builder.draw(ROOT, beans, "coffee_dark", "hopper", density="coffee_beans")
    lid = rounded_body(
        size + 0.004, size + 0.004, [(0.0, z + height - 0.0118), (0.0, z + height - 0.003), (0.003, z + height)], 0.031
    ).translated(x, y)
    builder.add(ROOT, lid.with_hull_collider(), "plastic_black", "hopper", density="hopper_lid")
    builder.add(ROOT, solids.rod(0.011, 0.012, 0.003).translated(x, y, z + height + 0.006), "plastic_black", "hopper")


def add_pressure_gauge(builder: AssetBuilder, at: Vec3, radius: float, metal: str) -> None:
    """A round pressure gauge in a front that looks to -y."""
    x, y, z = at
    line = [(radius, 0.0), (radius, 0.005), (radius - 0.003, 0.007), (radius - 0.004, 0.0062), (0.0, 0.0062)]
    builder.draw(ROOT, solids.lathe(line, 32).rotated("x", math.pi / 2).translated(x, y, z), metal, "gauge")
    dial = solids.rod(radius - 0.0042, 0.0006, 0.0, "y").translated(x, y - 0.0067, z)
    builder.draw(ROOT, dial, "enamel_white", "gauge", density=0.0)
    for k in range(9):
        angle = math.radians(-130 + 260 * k / 8)
        tick = solids.box((0.0008, 0.0004, 0.003), (0.0, -0.0072, radius - 0.0066), 0.0).rotated("y", angle)
        tick = tick.translated(x, y, z)
        builder.draw(ROOT, tick, "plastic_black", "gauge", density=0.0)
    hand = solids.box((0.0012, 0.0004, radius - 0.008), (0.0, -0.0075, 0.3 * radius), 0.0).rotated("y", -0.9)
    hand = hand.translated(x, y, z)
    builder.draw(ROOT, hand, "plastic_red", "gauge", density=0.0)


def add_cup_rail(builder: AssetBuilder, lower: Vec3, upper: Vec3, metal: str) -> None:
    """Add a low fence of rod round the warming plate at lower[2], up to upper[2]. Metres."""
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    loop = [(x1, y1, z1), (x1, y0, z1), (x0, y0, z1), (x0, y1, z1), (x1, y1, z1)]
    builder.add(ROOT, solids.tube(loop, 0.0028), metal, "rail")
    for x, y in ((x0, y0), (x1, y0), (x0, y1), (x1, y1)):
        builder.draw(ROOT, solids.rod(0.0026, z1 - z0, 0.0005).translated(x, y, (z0 + z1) / 2), metal, "rail")


# Blender jar ----------------------------------------------------------------------------------------------------------

WALL_THICKNESS = 0.004  # metres
LIP_HEIGHT = 0.008
UNDER_LID = 0.0005  # how far the long pieces of the wall end below the mouth
# The glass begins so far above what the jar stands on: the collar is below it; metres.
COLLAR, RAISED = 0.026, 0.0252
# How far the plug of a lid reaches into the jar, its play there, how much wider the cover is than the jar; metres.
PLUG_DEPTH, PLUG_PLAY, OVERHANG = 0.008, 0.003, 0.001

BlenderJar = StrEnum("BlenderJar", "ROUND SQUARE CLOVER")

# Least half width of a jar like a clover, as a share of its half width.
WAIST = 0.9


@dataclass(frozen=True)
class Jar:
    """A jar; lengths in metres.

    form: its section. height: of the glass. top, foot: half width at the mouth and at the foot. grip, glass: finishes
    of collar and handle, and of the jar. reach, low: how far the handle projects, and the height of its lower end
    relative to that of the glass. edge_in_front: an edge between two collision shapes of a round wall faces the front,
    so that their bounding box is that of the wall.
    """

    form: BlenderJar
    height: float
    top: float
    foot: float
    grip: str
    glass: str
    reach: float = 0.045
    low: float = 0.2
    edge_in_front: bool = False

    @property
    def rim(self) -> float:
        """Height of the mouth above the surface that the jar rests on, metres."""
        return COLLAR + self.height


@dataclass(frozen=True)
class Cover:
    """A lid of a jar; lengths in metres.

    form, top: section of the jar, and half width of its mouth. thickness: of the cover. cap_radius, cap_height: of the
    filler cap that it is held by. grip, cap: finishes of cover and filler cap. cap_name: of the filler cap's collider.
    """

    form: BlenderJar
    top: float
    thickness: float
    cap_radius: float
    cap_height: float
    grip: str
    cap: str
    cap_name: str = "handle_main"


def jar_outline(jar: BlenderJar, half: float, z: float) -> np.ndarray:
    """(N, 3) outline of a jar of a half width at a height, metres."""
    if jar is BlenderJar.ROUND:
        flat = solids.circle(half, 44)
    elif jar is BlenderJar.SQUARE:
        flat = solids.rectangle(2 * half, 2 * half, 0.38 * half, 6)
    else:
        turns = np.arange(48) * 2 * np.pi / 48
        radius = half * (1.0 - 0.05 * (1 - np.cos(4 * turns)))
        flat = np.stack([radius * np.cos(turns), radius * np.sin(turns)], axis=1)
    return np.column_stack([flat, np.full(len(flat), z)])


def _jar_walls(p: Jar, width: float, foot: Vec2, rim: Vec2) -> list[Placed]:
    """Convex pieces of a jar's wall.

    width: least radius of the inside, as a share of the radius. foot, rim: radius and height, metres.
    """
    is_square = p.form is BlenderJar.SQUARE
    count = 4 if is_square else 12
    grow = math.sqrt(2.0) if is_square else 1.0
    first = 0.0 if p.edge_in_front and not is_square else math.pi / count
    lip = rim[0] - (rim[0] - foot[0]) * LIP_HEIGHT / (rim[1] - foot[1])
    profile = [foot, (lip, rim[1] - LIP_HEIGHT), rim, (rim[0], rim[1] - UNDER_LID)]
    walls, edge = (
        round_wall_pieces(
            [(width * r - WALL_THICKNESS, z) for r, z in stretch], [(grow * r, z) for r, z in stretch], count, first
        )
        for stretch in (profile[::3], profile[1:3])
    )
    # The lid lies on short pieces at the edge alone: boxes that stand for them in the light form end where they do, and
    # the long pieces, which end a little lower, have no contacts with it.
    return [*walls, *(edge[:: count // 4] if count > 4 else edge)]


def add_jar(builder: AssetBuilder, p: Jar, rest: float) -> None:
    """Add collar, jar with an open mouth, blades, and their colliders, about the z axis, from height `rest` up."""
    r0, r1, low, rim = p.foot, p.top, rest + 0.0004, rest + p.rim
    outline = [
        (r0 + 0.012, low), (r0 + 0.014, low + 0.002), (r0 + 0.01, low + 0.018), (r0 + 0.006, low + 0.024),
        (r0 - 0.01, low + 0.0245),
    ]  # fmt: skip
    collar = solids.lathe(outline, 44)
    builder.add(ROOT, collar.with_hull_collider(), p.grip, "collar", density="blender_collar")
    floor = rest + 0.034
    base = rest + RAISED
    shares = np.linspace(0.0, 1.0, 6)
    outer = [(r0 + (r1 - r0) * float(s) ** 0.8, base + float(s) * (rim - base)) for s in shares]
    inner = [(r - WALL_THICKNESS, max(z, floor)) for r, z in outer][::-1]
    rings = [
        jar_outline(p.form, r, z)
        for r, z in [(r0 - 0.004, base), (r0, base + 0.003), *outer[1:], *inner, (inner[-1][0] - 0.008, floor - 1e-4)]
    ]
    rings.insert(len(outer) + 1, jar_outline(p.form, r1 + 0.0025, rim))
    skin = solids.loft(rings, 50.0)
    width = WAIST if p.form is BlenderJar.CLOVER else 1.0
    walls = _jar_walls(p, width, (r0, base), (r1, rim))
    metal = not p.glass.startswith(("glass", "plastic"))
    density = {"glass": "glass", "plastic": "blender_plastic_jar"}.get(p.glass.split("_")[0], "blender_steel_jar")
    builder.add(ROOT, Solid(skin.points, skin.faces, tuple(walls), crease_deg=50.0), p.glass, "jar", density=density)
    disc = solids.rod(r0 - 0.001, floor - base, 0.0).translated(z=(floor + base) / 2)
    builder.add_collider(ROOT, disc, p.glass, "jar", "jar_bottom")
    line = [(0.6 * r0, floor + 3e-4), (0.5 * r0, floor + 0.002), (0.2 * r0, floor + 0.003), (0.0, floor + 0.0032)]
    builder.draw(ROOT, solids.lathe(line, 28), "stainless_polished", "blades")
    for k in range(4):
        blade = solids.box((0.024, 0.009, 0.0014), (0.013, 0.0, 0.0), 0.0005).rotated("y", -0.35 if k % 2 else 0.1)
        turned = blade.rotated("z", k * math.pi / 2).translated(0.0, 0.0, floor + 0.0075)
        builder.draw(ROOT, turned, "stainless_polished", "blades", name="blades")
    hub = solids.rod(0.0045, 0.008, 0.001).translated(0.0, 0.0, floor + 0.007)
    builder.draw(ROOT, hub, "stainless_polished", "blades", name="blades")
    builder.round_region("int", (0.0, 0.0, floor), 2 * (width * r0 - WALL_THICKNESS), rim - floor - 0.012)
    for k in range(0 if metal else 5):
        s = 0.25 + 0.14 * k
        r = (r0 + (r1 - r0) * s**0.8) * (0.9 if p.form is BlenderJar.CLOVER else 1.0)
        mark = solids.box((0.02 if k % 2 else 0.012, 0.0006, 0.0012), (0.0, -r - 2e-4, base + s * (rim - base)), 0.0)
        builder.draw(ROOT, mark, "plastic_white", "scale", density=0.0)


def add_jar_handle(builder: AssetBuilder, p: Jar, rest: float) -> None:
    """Add a loop on the right side of a jar whose bottom is at height `rest`."""
    rim = rest + p.rim
    base = rest + RAISED
    low, high = base + p.low * (rim - base), rim - 0.024

    def at(z: float) -> float:
        return float(p.foot + (p.top - p.foot) * ((z - base) / (rim - base)) ** 0.8)

    far = p.top + p.reach
    path: list[Vec3] = [
        (at(high) - 0.002, 0.0, high),
        (far, 0.0, high),
        (far - 0.012, 0.0, low),
        (at(low) - 0.002, 0.0, low),
    ]
    bow = solids.tube(path, solids.rectangle(0.016, 0.026, 0.007, 4), 0.016, up=(0.0, 1.0, 0.0))
    builder.add(ROOT, bow, p.grip, "handle", collider="handle_main", density="hollow_moulding")


def add_cover(builder: AssetBuilder, p: Cover, link: str = ROOT) -> None:
    """Add a cover to a link, in whose frame the jar's mouth is z = 0 and its axis x = y = 0."""
    half, t = p.top + OVERHANG, p.thickness
    rings = [(half - 0.002, 0.0), (half, 0.002), (half, t - 0.004), (half - 0.004, t), (0.55 * half, t + 0.0012)]
    cover = solids.loft([jar_outline(p.form, r, z) for r, z in rings], 50.0)
    square = p.form is BlenderJar.SQUARE
    shape = (
        solids.board((-half, -half, 0.0), (half, half, t), 0.0)
        if square
        else solids.rod(half, t, 0.0).translated(z=t / 2)
    )
    builder.add(link, cover.with_colliders_of(shape), p.grip, "lid", collider="lid_main", density="blender_lid")
    inside = (WAIST if p.form is BlenderJar.CLOVER else 1.0) * p.top - WALL_THICKNESS - PLUG_PLAY
    plug = solids.rod(inside, PLUG_DEPTH + 0.001, 0.002).translated(z=(0.001 - PLUG_DEPTH) / 2)
    builder.add(link, plug, p.grip, "lid", collider="lid_plug", density="blender_lid")
    r, foot, top = p.cap_radius, t + 0.0005, t + p.cap_height
    cap = solids.lathe([(r, foot), (r, top - 0.003), (r - 0.003, top)], 32)
    builder.add(link, cap.with_hull_collider(), p.cap, "handle", collider=p.cap_name, density="blender_lid")
