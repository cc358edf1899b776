"""Give doors and drawers the loose pieces of the body that they would run into as they open."""

from __future__ import annotations

import numpy as np

from casa_assets.articulate.plan import Articulation, PartKind, PartPlan
from casa_assets.articulate.segment.fragment_measures import SIDES, corners_of_labels
from casa_assets.articulate.segment.raster import render_depth
from casa_assets.articulate.segment.welded_mesh import Bools, WeldedMesh
from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.topology import face_components
from casa_assets.model.asset.joint import JointKind

# Longer side of the pictures in which a front and what stands before it are compared, pixels.
PIXELS = 256
# A piece lies within the outline of a front, or touches it, to within this, diagonals. Choices, as is the next.
TOLERANCE = 0.002
# Share of a piece, seen along the way of a front, behind which something of the front follows.
MIN_BLOCKED_SHARE = 0.25
# An axis is one of the six sides where its cosine with it is at least this.
MIN_COSINE = 0.99
# The way that doors open, in the frame.
OUT = np.array([0.0, -1.0, 0.0])


def with_pieces_in_the_way(articulation: Articulation, mesh: WeldedMesh) -> Articulation:
    """Return the articulation with doors and drawers that carry what they would run into as they open.

    A connected piece of the body, or the rest of one from which parts were taken, goes with a front if it lies within
    the outline of the front, reaches at least its front and no farther than its back, and some surface of the front is
    behind the piece: the sides of a box between front and back, the foot of a handle, a piece of a shell between the
    two sheets of a door. Pieces of the frame reach beyond that outline, or have none of the front behind them.

    Args:
        mesh: in the frame; the faces of the parts are those of this mesh.
    """
    label = _pieces_of_body(articulation.face_owner(len(mesh.faces)) < 0, mesh)
    count = int(label.max(initial=-1)) + 1
    if not count:
        return articulation
    lower, upper = corners_of_labels(mesh, label)
    free = np.ones(count, dtype=bool)
    parts = []
    for part in articulation.parts:
        found = _pieces_in_the_way(part, mesh, label, free, lower, upper)
        free[found] = False
        faces = np.flatnonzero(np.isin(label, found))
        parts.append(part.replace(faces=np.union1d(part.faces, faces)) if len(faces) else part)
    return articulation.replace(parts=tuple(parts))


def _pieces_of_body(is_body: Bools, mesh: WeldedMesh) -> Ints:
    """Return the (F,) connected piece of each face of the body, -1 for all others.

    A fragment that parts have taken faces from may be several pieces.
    """
    fragment = mesh.fragment_labels
    label = np.where(is_body, fragment, -1)
    count = int(fragment.max(initial=-1)) + 1
    for shared in np.intersect1d(label[label >= 0], fragment[~is_body]).tolist():
        rows = np.flatnonzero(label == shared)
        label[rows] = count + face_components(mesh.faces[rows], len(mesh.points))
        count = int(label.max()) + 1
    found: Ints = np.unique(label, return_inverse=True)[1].reshape(-1) - int((label < 0).any())
    return found


def _pieces_in_the_way(
    part: PartPlan, mesh: WeldedMesh, label: Ints, free: Bools, lower: Floats, upper: Floats
) -> list[int]:
    """Return the free pieces that are in the way of a part; empty if it is neither a door nor a drawer.

    Args:
        label: (F,) piece of each face. free: (N,) whether no part has a piece. lower, upper: (N, 3) corners of pieces.
    """
    way = _way(part, mesh)
    # The view looks from before the front at what comes towards it.
    views = [s for s in SIDES if way is not None and float(-s[2] @ way) >= MIN_COSINE]
    if not views:
        return []
    axes = views[0]
    near, far = (np.sort(np.stack([c @ axes.T for c in (lower, upper)]), axis=0)[k] for k in (0, 1))
    own = mesh.points[mesh.faces[part.faces].reshape(-1)] @ axes.T
    first, last = own.min(axis=0) - TOLERANCE, own.max(axis=0) + TOLERANCE
    inside = free & (near[:, :2] >= first[:2]).all(axis=1) & (far[:, :2] <= last[:2]).all(axis=1)
    inside &= (far[:, 2] >= first[2]) & (far[:, 2] <= last[2])
    if not inside.any():
        return []
    from_behind = render_depth(mesh.points, mesh.faces[part.faces], axes * np.array([[1.0], [1.0], [-1.0]]), PIXELS)
    rear = float((mesh.points @ axes[2]).max()) - from_behind.depth
    found = []
    for piece in np.flatnonzero(inside).tolist():
        image = render_depth(mesh.points, mesh.faces[label == piece], axes, PIXELS)
        seen = image.face >= 0
        at = float((mesh.points @ axes[2]).min()) + image.depth[seen]
        if seen.any() and float((rear[seen] > at + TOLERANCE).mean()) >= MIN_BLOCKED_SHARE:
            found.append(piece)
    return found


def _way(part: PartPlan, mesh: WeldedMesh) -> Floats | None:
    """Return the direction in which a front begins to open; None for other parts, and for doors that are no leaf."""
    if part.kind is PartKind.DRAWER and part.joint.kind is JointKind.SLIDE:
        return np.array(part.joint.axis)
    if part.kind is PartKind.DOOR and part.joint.kind is JointKind.HINGE and part.joint.edge is not None:
        extent = np.ptp(mesh.points[mesh.faces[part.faces].reshape(-1)], axis=0)
        return OUT if int(np.argmin(extent)) == int(np.argmax(np.abs(OUT))) else None
    return None
