"""List candidate up directions: six axes, stable poses of the hull, directions that edges and faces run along."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.ingest.pose.surface_sample import SurfaceSample

# asset_from_file rotations by the file axis that becomes z. The first two are the usual conversions,
# so that a glTF front (+z) becomes the asset front (-y).
UP_ROTATIONS: dict[str, Floats] = {
    "y": np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], dtype=np.float64),
    "z": np.eye(3),
    "x": np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], dtype=np.float64),
    "minus_y": np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], dtype=np.float64),
    "minus_z": np.array([[1, 0, 0], [0, -1, 0], [0, 0, -1]], dtype=np.float64),
    "minus_x": np.array([[0, 1, 0], [0, 0, -1], [-1, 0, 0]], dtype=np.float64),
}

# Prior of each up axis by what the file states; estimates. The rest is shared by the other axes and directions. glTF
# defines y as up, and most exporters obey; OBJ, PLY and STL leave it open. Upside down comes from a wrong sign in a
# converter. No prior is so strong that the shape could not outweigh it.
UP_PRIOR: dict[str, dict[str, float]] = {
    "declared_y": {"y": 0.88, "z": 0.043, "minus_y": 0.03},
    "declared_z": {"z": 0.88, "y": 0.04, "minus_z": 0.03},
    # COLLADA's default is y up, which exporters leave as it is; others write the tag without turning the mesh.
    "dae_y": {"y": 0.69, "z": 0.16, "minus_y": 0.05},
    "dae_z": {"z": 0.72, "y": 0.13, "minus_z": 0.05},
    "declared_x": {"x": 0.86, "y": 0.035, "z": 0.035, "minus_x": 0.03},
    "obj": {"y": 0.44, "z": 0.40, "minus_y": 0.03, "minus_z": 0.03},
    "stl": {"z": 0.73, "y": 0.12, "minus_z": 0.05},
    "ply": {"z": 0.57, "y": 0.27, "minus_z": 0.04, "minus_y": 0.03},
    "generated": {"y": 0.70, "z": 0.15, "minus_y": 0.05},
    "unknown": {"y": 0.44, "z": 0.39, "minus_y": 0.03, "minus_z": 0.03},
}

# Directions closer than this count as equal; a choice.
SAME_DIRECTION_RAD = np.radians(6.0)
# Sides of the hull that are tried as feet, the largest first; a choice.
MAX_FEET = 6
# Prior of a direction that is no axis, relative to that of an axis that is not listed: modellers work along axes, while
# scans lie in any direction. An estimate.
OFF_AXIS_PRIOR = 0.4


# Modellers put the origin on the floor under a thing: of 109 meshes of ./dev bench ingest_pose 46 have it at
# the height of their lowest point, to this share of the longest side; along other axes, or at the top, hardly any have.
ORIGIN_SLACK, NATS_ON_ORIGIN = 0.01, 4.0
# A mesh that lies around its origin does so along most axes, which way up it may be.
MIDDLE_SLACK, NATS_AROUND_ORIGIN = 0.02, -0.7


def origin_evidence(points: Floats, names: list[str]) -> Floats:
    """Log likelihood of each candidate, by its name, by where the origin of the file lies in the mesh.

    Args:
        points: (N, 3) in the axes of the file, about its origin.
    """
    lower, upper = points.min(axis=0), points.max(axis=0)
    longest = float((upper - lower).max())
    out = np.zeros(len(names))
    for row, name in enumerate(names):
        if name not in UP_ROTATIONS:
            continue
        up = UP_ROTATIONS[name][2]
        bottom, top = sorted((float(lower @ up), float(upper @ up)))
        if abs(bottom) <= ORIGIN_SLACK * longest:
            out[row] = NATS_ON_ORIGIN
        elif abs(bottom + top) <= MIDDLE_SLACK * (top - bottom):
            out[row] = NATS_AROUND_ORIGIN
    return out


def priors(key: str, names: list[str]) -> Floats:
    """Log prior of each candidate, by its name."""
    known_priors = UP_PRIOR.get(key, UP_PRIOR["unknown"])
    other_prior = (1 - sum(known_priors.values())) / (len(UP_ROTATIONS) - len(known_priors))
    log_priors: Floats = np.log(
        np.array(
            [known_priors.get(n, other_prior if n in UP_ROTATIONS else other_prior * OFF_AXIS_PRIOR) for n in names]
        )
    )
    return log_priors


def candidates(cloud: SurfaceSample) -> list[tuple[str, Floats]]:
    """Names and asset_from_file rotations; the six axes first, in the order of UP_ROTATIONS."""
    out = list(UP_ROTATIONS.items())
    directions = [rotation[2] for rotation in UP_ROTATIONS.values()]
    further = [("foot", up) for up in _hull_sides(cloud)]
    _, axes = np.linalg.eigh(np.cov(cloud.samples.T))
    further += [("along", sign * axis) for axis in axes.T for sign in (1.0, -1.0)]
    for prefix, up in further:
        if all(np.arccos(np.clip(up @ other, -1, 1)) > SAME_DIRECTION_RAD for other in directions):
            directions.append(up)
            out.append((f"{prefix}_{sum(n.startswith(prefix) for n, _ in out)}", rotation_to_z(up)))
    return out


def _hull_sides(cloud: SurfaceSample) -> list[Floats]:
    """Up directions in which the hull rests on one of its larger sides, or has it on top, largest side first.

    Both, because the largest side of a bowl's hull is its rim.
    """
    corners = cloud.hull_points[cloud.hull_faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    keep = area > 1e-12
    normals, area = cross[keep] / area[keep, None], area[keep]
    sides: list[tuple[float, Floats]] = []
    is_left = np.ones(len(area), dtype=bool)
    for first in np.argsort(-area, kind="stable"):
        if not is_left[first]:
            continue
        is_same_side = is_left & (normals @ normals[first] > np.cos(SAME_DIRECTION_RAD / 2))
        is_left &= ~is_same_side
        mean = (normals[is_same_side] * area[is_same_side, None]).sum(axis=0)
        sides.append((float(area[is_same_side].sum()), -mean / np.linalg.norm(mean)))
        if len(sides) >= 4 * MAX_FEET:
            break
    sides.sort(key=lambda side: -side[0])
    return [way for _, up in sides[:MAX_FEET] for way in (up, -up)]


def rotation_to_z(up: Floats) -> Floats:
    """(3, 3) rotation that brings a unit direction to z by the shortest way from the axis of the file next to it."""
    name = max(UP_ROTATIONS, key=lambda n: float(UP_ROTATIONS[n][2] @ up))
    base = UP_ROTATIONS[name]
    a, b = base @ up, np.array([0.0, 0.0, 1.0])
    axis, cosine = np.cross(a, b), float(a @ b)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    rotation: Floats = (np.eye(3) + cross + cross @ cross / (1 + cosine)) @ base
    return rotation
