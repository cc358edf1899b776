"""Which way is up: six candidates weighed by what the file says, the usual shape, the opening and the balance."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from casa_assets.geometry.hull import convex_hull
from casa_assets.geometry.measure import face_normals, solid_moments
from casa_assets.ingest.draft import Draft
from casa_assets.model.category import Build, Category, Upright
from casa_assets.model.source import RawPart

Floats = npt.NDArray[np.float64]

# asset_from_file rotations by the file axis that becomes z. The first two are the usual conversions,
# so that a glTF front (+z) becomes the asset front (-y).
UPS: dict[str, Floats] = {
    "y": np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], dtype=np.float64),
    "z": np.eye(3),
    "x": np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], dtype=np.float64),
    "minus_y": np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], dtype=np.float64),
    "minus_z": np.array([[1, 0, 0], [0, -1, 0], [0, 0, -1]], dtype=np.float64),
    "minus_x": np.array([[0, 1, 0], [0, 0, -1], [-1, 0, 0]], dtype=np.float64),
}

# Prior weight of each up axis by what is known of the file; the rest is shared by the others.
# glTF fixes y up, and most exporters obey; OBJ, PLY and STL leave it open.
PRIOR: dict[str, dict[str, float]] = {
    "declared_y": {"y": 0.93, "z": 0.04},
    "declared_z": {"z": 0.94, "y": 0.03},
    # COLLADA has a default of y up that exporters leave standing, and a tag that they write without turning anything.
    "dae_y": {"y": 0.80, "z": 0.16},
    "dae_z": {"z": 0.84, "y": 0.13},
    "declared_x": {"x": 0.90, "y": 0.04, "z": 0.04},
    "obj": {"y": 0.50, "z": 0.46},
    "stl": {"z": 0.84, "y": 0.12},
    "ply": {"z": 0.66, "y": 0.30},
    "generated": {"y": 0.80, "z": 0.17},
    "unknown": {"y": 0.5, "z": 0.45},
}


def orient(draft: Draft, category: Category, generated: bool = False) -> Draft:
    """Turn the parts so that z is up.

    Args:
        draft: in file axes.
        category: its usual shape and way of resting are the evidence.
        generated: from a text-to-3D generator, which write y up whatever the format.
    """
    vertices, faces = draft.soup()
    normals, areas = face_normals(vertices, faces)
    mids = vertices[faces].mean(axis=1)
    shell, triangles = convex_hull(vertices)
    stater = "dae" if draft.format == "dae" and draft.up in ("y", "z") else "declared"
    key = f"{stater}_{draft.up}" if draft.up else ("generated" if generated else draft.format)
    prior = PRIOR.get(key, PRIOR["unknown"])
    rest = (1 - sum(prior.values())) / (len(UPS) - len(prior))
    scores = {}
    for axis, turn in UPS.items():
        scores[axis] = (
            np.log(prior.get(axis, rest))
            + _shape_score(shell @ turn.T, category)
            + _opening_score(mids @ turn.T, normals @ turn.T, areas, category)
            + _balance_score(shell @ turn.T, triangles, category)
        )
    best = max(scores, key=lambda axis: scores[axis])
    weights = np.exp(np.array(list(scores.values())) - scores[best])
    confidence = float(1 / weights.sum())
    stated = f"the file states {draft.up} up" if draft.up else f"{draft.format} states no up axis"
    because = f"{stated}; weighed with the usual shape, opening and balance of a {category.id}"
    return draft.replace(
        parts=tuple(_turned(p, UPS[best]) for p in draft.parts),
        up="z",
        guesses=draft.guessed("up_axis", best, confidence, because),
    )


def _turned(part: RawPart, turn: Floats) -> RawPart:
    mesh = part.mesh
    normals = None if mesh.normals is None else mesh.normals @ turn.T
    return part.replace(mesh=mesh.with_vertices(mesh.vertices @ turn.T, normals))


def _shape_score(points: Floats, category: Category) -> float:
    """How well height and breadth, relative to the longest side, fit the usual ones; 0 at best, -4 at worst."""
    if category.id == "object" or category.upright is Upright.ANY:
        return 0.0
    extent = np.ptp(points, axis=0)
    usual = np.array(category.shape)
    have = extent / extent.max()
    want = usual / usual.max()
    # Heading is free: compare the height, and the sorted horizontal pair.
    have = np.array([*sorted(have[:2]), have[2]])
    want = np.array([*sorted(want[:2]), want[2]])
    miss = np.log(np.maximum(have, 0.01) / np.maximum(want, 0.01)) / np.array([0.5, 0.5, 0.3])
    return float(max(-4.0, -0.5 * (miss**2).sum()))


def _opening_score(mids: Floats, normals: Floats, areas: Floats, category: Category) -> float:
    """For vessels: surface that faces up from deep inside speaks for this axis, surface that faces down against it."""
    if category.build is not Build.VESSEL:
        return 0.0
    low, high = mids.min(axis=0), mids.max(axis=0)
    center, half = (low + high) / 2, np.maximum((high - low) / 2, 1e-12)
    off = np.linalg.norm((mids[:, :2] - center[:2]) / half[:2], axis=1)
    level = (mids[:, 2] - low[2]) / (2 * half[2])
    column = off < 0.45
    weight = areas[column] * np.abs(normals[column, 2])
    if weight.sum() <= 0:
        return 0.0
    facing_up = normals[column, 2] > 0
    # Standing upright, what faces up in the middle is the inside bottom: low. Upside down, it is the outside: high.
    depth_up = _mean(level[column][facing_up], weight[facing_up], 0.5)
    depth_down = _mean(level[column][~facing_up], weight[~facing_up], 0.5)
    return float(6 * ((1 - depth_up) - 0.5) + 3 * (0.5 - depth_down))


def _mean(values: Floats, weights: Floats, default: float) -> float:
    total = float(weights.sum())
    return float((values * weights).sum() / total) if total > 0 else default


def _balance_score(points: Floats, triangles: npt.NDArray[np.int64], category: Category) -> float:
    """It should stand on its foot: the centre of the hull above what touches the ground, and rather low."""
    if category.upright is Upright.ANY:
        return 0.0
    _, center, _ = solid_moments(points, triangles)
    height = float(np.ptp(points[:, 2]))
    foot = points[points[:, 2] < points[:, 2].min() + 0.02 * height + 1e-12][:, :2]
    extent = np.maximum(np.ptp(points[:, :2], axis=0), 1e-12)
    inside = bool(
        (foot.min(axis=0) - 0.02 * extent <= center[:2]).all()
        and (center[:2] <= foot.max(axis=0) + 0.02 * extent).all()
    )
    width = float((np.ptp(foot, axis=0) / extent).min())
    if category.upright is Upright.LIES:  # on its flat side by definition; a knife on its handle tips a little
        steep = float(np.log(max(height, 1e-12) / max(min(height, extent.min()), 1e-12)))
        return (0.0 if inside else -0.5) + 1.0 * min(width, 0.6) - 2.0 * min(steep, 1.0)
    sink = 0.5 - float(center[2] - points[:, 2].min()) / max(height, 1e-12)
    return (0.0 if inside else -1.5) + 1.0 * min(width, 0.6) + 3.0 * sink
