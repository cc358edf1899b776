"""Cases of appliances: walls and linings of cavities, rounded bodies, and feet."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from casa_assets.ext import solids
from casa_assets.ext.arrays import Floats, convex_hull
from casa_assets.ext.records import Hull, Mesh, Pose, Sphere, Vec2, Vec3
from casa_assets.ext.solids import ROOT, AssetBuilder, Placed, Solid

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


def tub_walls(outer: tuple[Vec3, Vec3], inner: tuple[Vec3, Vec3]) -> list[tuple[Vec3, Vec3]]:
    """Corners of five boards round a tub that is open on top: bottom; front, back over all its width; left, right."""
    ((x0, y0, z0), (x1, y1, z1)), ((a0, b0, c0), (a1, b1, _)) = outer, inner
    return [
        ((x0, y0, z0), (x1, y1, c0)), ((x0, y0, c0), (x1, b0, z1)), ((x0, b1, c0), (x1, y1, z1)),
        ((x0, b0, c0), (a0, b1, z1)), ((a1, b0, c0), (x1, b1, z1)),
    ]  # fmt: skip


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


def extrude_across(outline: Floats, width: float, chamfer: float, start: float = 0.0) -> Solid:
    """An outline in y, z (counter-clockwise, y to the right) pulled along x, from x = `start` on. Metres."""
    solid = solids.prism(outline, width, chamfer)
    return Solid(solid.points[:, [2, 0, 1]] + np.array([start, 0.0, 0.0]), solid.faces, crease_deg=40.0)


def rounded_body(width: float, depth: float, steps: Sequence[Vec2], radius: float, corner: int = 6) -> Solid:
    """A body of rounded rectangles, (inset, z) each from below; insets are cut to half of the narrower side. Metres."""
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
