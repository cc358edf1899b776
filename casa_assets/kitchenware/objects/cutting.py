"""Cut closed bodies with planes: what is left, with its picture, and the faces that show their inside."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import manifold3d
import numpy as np

from casa_assets.ext.arrays import Floats, Ints, counter_clockwise, signed_area
from casa_assets.ext.solids import Solid

# A cut face is a plate of this thickness; a part of it stands out of the body, so that nothing of the body shows, m.
PLATE, PROUD = 0.0006, 0.00025
# Size of a plate by that of the face: the rest is the edge of the skin.
WITHIN = 0.985
# Points nearer than this to a plane lie on it, m.
ON_PLANE = 1e-7
# Points of an outline nearer than this to the one before are left out, m: what is written is rounded to a tenth of it.
SAME = 1e-7
# Radius of the circle in the picture of a section that is the rim of the face, by the width of the picture; as in
# kitchenware/textures/food.py.
PICTURE_RIM = 0.49


@dataclass(frozen=True)
class Plane:
    """A cutting plane: everything beyond it is removed."""

    normal: Floats  # (3,) unit vector, away from what is kept
    offset: float  # along it from the origin, m
    middle: Floats | None  # (3,) middle of the picture of the cut face, m; None: that of the face
    up: Floats  # (3,) unit vector in the plane: the upward direction of the picture


def along(turn: float, middle: Floats) -> Plane:
    """A plane through the z axis that leaves the half turn before an angle, rad from x."""
    normal = np.array([-math.sin(turn), math.cos(turn), 0.0])
    return Plane(normal, 0.0, middle, np.array([0.0, 0.0, 1.0]))


def sector(angle: float, middle: Floats) -> list[Plane]:
    """Two planes through the z axis that leave a sector of an angle (rad) about the x axis."""
    first, last = along(angle / 2, middle), along(-angle / 2, middle)
    return [first, replace(last, normal=-last.normal)]


def across(height: float, *, below: bool, slant: float = 0.0) -> Plane:
    """A plane that leaves what is below it, or what is above: level, or slanted towards x by an angle, rad.

    Args:
        height: its distance from the origin, m.
    """
    sign = 1.0 if below else -1.0
    normal = sign * np.array([math.sin(slant), 0.0, math.cos(slant)])
    return Plane(normal, sign * height, None, np.array([0.0, 1.0, 0.0]))


def cut(solid: Solid, planes: list[Plane], hollow: Solid | None = None) -> tuple[Solid, list[Solid]]:
    """Cut a body by planes, and make the plates that lie on its cut faces.

    Args:
        solid: closed; its picture is kept on its skin.
        hollow: an empty body within it, or None; its faces have no picture.
    Returns:
        The rest of the body, closed, without collision shapes; and for each plane a plate, whose picture is that of a
            section.
    Raises:
        ValueError: the planes leave nothing of the body, or a plane does not meet it.
    """
    body = _manifold(solid)
    if hollow is not None:
        body -= _manifold(hollow)
    body = _trimmed(body, planes)
    if body.is_empty():
        raise ValueError("the cuts leave nothing of the body")
    kept = _solid(body, solid.crease_deg)
    return kept, [_plate(kept, plane) for plane in planes]


def shell(outer: Solid, inner: Solid, planes: list[Plane]) -> Solid:
    """The cut material between two closed bodies, slightly behind the cut faces; its picture is seen from the side."""
    kept = _solid(_trimmed(_manifold(outer) - _manifold(inner), planes, behind=PLATE), outer.crease_deg)
    low, high = kept.bounds
    # The middle of the picture has the flesh without the skin.
    uv = 0.5 + 0.5 * ((kept.points - low) / (high - low) - 0.5)[:, [0, 2]]
    return replace(kept, picture_uv=uv[kept.faces])


def _trimmed(body: manifold3d.Manifold, planes: list[Plane], behind: float = 0.0) -> manifold3d.Manifold:
    """The rest of a body after cuts by planes that are moved by `behind` into it, m."""
    for plane in planes:
        x, y, z = (-float(v) for v in plane.normal)
        body = body.trim_by_plane((x, y, z), behind - plane.offset)
    return body


def _manifold(solid: Solid) -> manifold3d.Manifold:
    """The body with the coordinates of its picture as properties of its points."""
    uv = np.zeros((*solid.faces.shape, 2)) if solid.picture_uv is None else solid.picture_uv
    corners = np.column_stack([solid.points[solid.faces.ravel()], uv.reshape(-1, 2)])
    rows, index = np.unique(np.round(corners, 12), axis=0, return_inverse=True)
    mesh = manifold3d.Mesh64(
        vert_properties=np.ascontiguousarray(rows), tri_verts=index.reshape(-1, 3).astype(np.uint64)
    )
    mesh.merge()
    body = manifold3d.Manifold(mesh)
    if body.status() != manifold3d.Error.NoError:
        raise ValueError(f"a body of {len(solid.faces)} faces is not closed: {body.status()}")
    return body


def _solid(body: manifold3d.Manifold, crease_deg: float) -> Solid:
    """The surface of a body whose points have the coordinates of a picture as properties."""
    mesh = body.to_mesh64()
    corners, faces = np.array(mesh.vert_properties, dtype=np.float64), np.array(mesh.tri_verts, dtype=np.int64)
    points, index = np.unique(np.round(corners[:, :3], 9), axis=0, return_inverse=True)
    return Solid(points, index[faces], crease_deg=crease_deg, picture_uv=corners[:, 3:5][faces])


def _plate(body: Solid, plane: Plane) -> Solid:
    """The plate over the face that a plane cut, with a hole where the face has one.

    Its faces fan out from the middle, so that the picture of the section follows the outline.
    """
    side = np.cross(plane.up, plane.normal)
    loops = [body.points[loop] for loop in _loops(body, plane)]
    if not loops:
        raise ValueError("a plane does not meet the body")
    outlines = [np.column_stack([loop @ side, loop @ plane.up]) for loop in loops]
    outlines.sort(key=lambda loop: -abs(signed_area(loop)))
    outer = counter_clockwise(outlines[0])
    middle = _centroid(outer) if plane.middle is None else np.array([plane.middle @ side, plane.middle @ plane.up])
    rim = outer - middle
    angle = np.arctan2(rim[:, 1], rim[:, 0])
    hole = 0.0 * angle
    if len(outlines) > 1:
        # The plate stands a trifle over the hollow, or its edge would lie in the wall.
        hole = np.minimum(WITHIN * _radius(outlines[1] - middle, angle) / np.hypot(rim[:, 0], rim[:, 1]), 0.96)
    inner = rim * hole[:, None]
    n = len(rim)
    # Its edges slant inwards below the face: upright ones might lie in a wall of the body.
    slant = 0.04 * (rim - inner)
    levels = (
        (PROUD, inner, WITHIN * rim),
        (PROUD - PLATE, inner + np.where(hole > 0, 1.0, 0.0)[:, None] * slant, WITHIN * rim - slant),
    )
    flats = [(np.concatenate([low, high]) + middle, plane.offset + level) for level, low, high in levels]
    points = np.concatenate(
        [flat[:, :1] * side + flat[:, 1:] * plane.up + level * plane.normal for flat, level in flats]
    )
    i, j = np.arange(n), np.roll(np.arange(n), -1)
    top = np.concatenate([np.stack([n + i, n + j, i], 1), np.stack([n + j, j, i], 1)])
    wall = np.concatenate([np.stack([n + i, 3 * n + i, n + j], 1), np.stack([n + j, 3 * n + i, 3 * n + j], 1)])
    core = np.concatenate([np.stack([i, j, 2 * n + i], 1), np.stack([j, 2 * n + j, 2 * n + i], 1)])
    faces = np.concatenate([top, top[:, ::-1] + 2 * n, wall, core])
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    uv = 0.5 + PICTURE_RIM * np.concatenate([circle * hole[:, None], circle] * 2)
    made = _welded(Solid(points, faces.astype(np.int64), crease_deg=40.0, picture_uv=uv[faces]))
    return made.oriented_outwards()


def _welded(solid: Solid) -> Solid:
    """The solid with points that are the same made one, and without the faces that vanish."""
    points, index = np.unique(np.round(solid.points, 9), axis=0, return_inverse=True)
    faces = index[solid.faces]
    a, b, c = faces.T
    kept = (a != b) & (b != c) & (c != a)
    assert solid.picture_uv is not None
    return replace(solid, points=points, faces=faces[kept], picture_uv=solid.picture_uv[kept])


def _loops(body: Solid, plane: Plane) -> list[Ints]:
    """The outlines of the face on a plane, as points in order."""
    on = np.abs(body.points @ plane.normal - plane.offset) < ON_PLANE
    faces = body.faces[on[body.faces].all(axis=1)]
    edges = {(int(a), int(b)) for face in faces for a, b in zip(face, np.roll(face, -1), strict=True)}
    after = {a: b for a, b in sorted(edges) if (b, a) not in edges}
    loops = []
    while after:
        first, following = next(iter(after.items()))
        loop = [first]
        while following in after and following != first:
            loop.append(following)
            following = after.pop(following)
        after.pop(first, None)
        loops.append(np.array(loop))
    steps = [np.linalg.norm(body.points[loop] - body.points[np.roll(loop, 1)], axis=1) for loop in loops]
    loops = [loop[step > SAME] for loop, step in zip(loops, steps, strict=True)]
    return [loop for loop in loops if len(loop) > 2]


def _centroid(loop: Floats) -> Floats:
    """(2,) middle of the area within a loop."""
    after = np.roll(loop, -1, axis=0)
    share = loop[:, 0] * after[:, 1] - after[:, 0] * loop[:, 1]
    found: Floats = ((loop + after) * share[:, None]).sum(axis=0) / (3 * share.sum())
    return found


def _radius(loop: Floats, angle: Floats) -> Floats:
    """(N,) distance of a loop from the origin in directions, rad."""
    own = np.arctan2(loop[:, 1], loop[:, 0])
    order = np.argsort(own)
    found: Floats = np.interp(angle, own[order], np.hypot(loop[:, 0], loop[:, 1])[order], period=2 * np.pi)
    return found
