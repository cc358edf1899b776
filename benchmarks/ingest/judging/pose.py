"""Whether a mesh was set upright: by the true axis of its file, by symmetry, by how its category rests; and copies."""

from __future__ import annotations

from enum import StrEnum

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from casa_assets.ingest.draft import Draft
from casa_assets.ingest.up_axis import UP_ROTATIONS, outline_score, sample_surface
from casa_assets.model.registry.category import Category, MatterFill, RestingPose

Floats = npt.NDArray[np.float64]

SAME_DEG = 10.0  # two directions closer than this are one
SAME_SHAPE = 0.02  # of the longest side: surfaces closer than this for 95 % of their points look the same
FLAT = 1.3  # a thing lies where its height is no more than this times its least extent
LAY = 3.0  # nats by which the outline of a pose is more usual than another: the other one lies, say
YAWS = 12
POINTS = 900


class Grade(StrEnum):
    """How a pose compares with the true one."""

    EXACT = "exact"  # up is up
    SAME = "same shape"  # another way up, and nobody could tell from the shape
    ANY = "any pose"  # the category rests in any pose
    LIES = "lies"  # flat as its category does, on its other side
    STANDS = "stands"  # as its category does, where the file has it lying
    HEAD = "on its head"  # wrong: along the right axis, the other end up
    WRONG = "wrong"


# What is done to a mesh before it is given in again, in the axes of its file: the upside-down one, both that lie
# along the axes, and one that nobody modelled: let fall.
def about(axis: int, degrees: float) -> Floats:
    """(3, 3) rotation about a file axis."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn[i, i], turn[i, j], turn[j, i], turn[j, j] = c, -s, s, c
    return turn


COPIES: dict[str, Floats] = {
    "upside down": about(0, 180),
    "on its side": about(0, 90),
    "on its other side": about(2, 90) @ about(1, 90),
    "askew": about(0, 37) @ about(2, 52) @ about(1, 20),
}


def copy(draft: Draft, turn: Floats) -> Draft:
    """The same mesh, turned in its file."""
    parts = []
    for part in draft.parts:
        mesh = part.mesh
        normals = None if mesh.normals is None else mesh.normals @ turn.T
        parts.append(part.replace(mesh=mesh.with_vertices(mesh.vertices @ turn.T, normals)))
    return draft.replace(parts=tuple(parts))


def rotation(before: Draft, after: Draft) -> Floats:
    """(3, 3) rotation that took one to the other, by their vertices."""
    a, b = before.surface.vertices, after.surface.vertices
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    left, _, right = np.linalg.svd(b.T @ a)
    flip = np.diag([1, 1, np.sign(np.linalg.det(left @ right))])
    turn: Floats = left @ flip @ right
    return turn


def spread_points(draft: Draft) -> Floats:
    """(POINTS, 3) points over the surface, centred on the box around it, longest side 1."""
    samples = sample_surface(draft.surface.vertices, draft.surface.faces).samples
    picked = samples[:: max(1, len(samples) // POINTS)]
    low, high = samples.min(axis=0), samples.max(axis=0)
    out: Floats = (picked - (low + high) / 2) / float((high - low).max())
    return out


def same_shape(one: Floats, other: Floats, yaws: int = YAWS) -> bool:
    """Whether two surfaces, both z up, are the same for some turn about z."""
    tree = cKDTree(other)
    for k in range(yaws):
        turned = one @ about(2, 360 * k / yaws).T
        middle = (turned.min(axis=0) + turned.max(axis=0)) / 2
        if float(np.quantile(tree.query(turned - middle)[0], 0.95)) < SAME_SHAPE:
            return True
    return False


def grade(points: Floats, turn: Floats, up: str, category: Category) -> Grade:
    """Grade a pose.

    Args:
        points: of `spread_points`, in the axes of the file. turn: asset_from_file. up: true up axis of the file.
    """
    true = UP_ROTATIONS[up]
    if np.degrees(np.arccos(np.clip(turn[2] @ true[2], -1, 1))) < SAME_DEG:
        return Grade.EXACT
    if category.upright is RestingPose.ANY:
        return Grade.ANY
    if same_shape(points @ turn.T, points @ true.T):
        return Grade.SAME
    if category.upright is RestingPose.LIES and category.build is not MatterFill.VESSEL:
        _, axes = np.linalg.eigh(np.cov(points.T))
        least = min(*(float(np.ptp(points @ a)) for a in axes.T), *(float(np.ptp(points[:, k])) for k in range(3)))
        if float(np.ptp(points @ turn[2])) <= FLAT * least:
            return Grade.LIES
    if category.upright is RestingPose.STANDS and category.build is MatterFill.FILLED:
        ours, file = (outline_score(np.ptp(points @ t.T, axis=0), category) for t in (turn, true))
        if ours > file + LAY:
            return Grade.STANDS
    return Grade.HEAD if turn[2] @ true[2] < -np.cos(np.radians(SAME_DEG)) else Grade.WRONG
