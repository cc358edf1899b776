"""List candidate up directions: six axes, stable poses of the hull, directions that edges and faces run along."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.ingest.pose.cloud import SurfaceSample

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

# Prior weight of each up axis by what is known of the file; what is left is shared by the other axes and directions.
# glTF fixes y up, and most exporters obey; OBJ, PLY and STL leave it open. The other way up is what a wrong sign in a
# converter makes. What is seen of the thing has to be able to speak against all of these.
UP_PRIOR: dict[str, dict[str, float]] = {
    "declared_y": {"y": 0.80, "z": 0.07, "minus_y": 0.05},
    "declared_z": {"z": 0.82, "y": 0.05, "minus_z": 0.05},
    # COLLADA has a default of y up that exporters leave standing, and a tag that they write without turning anything.
    "dae_y": {"y": 0.69, "z": 0.16, "minus_y": 0.05},
    "dae_z": {"z": 0.72, "y": 0.13, "minus_z": 0.05},
    "declared_x": {"x": 0.80, "y": 0.05, "z": 0.05, "minus_x": 0.04},
    "obj": {"y": 0.44, "z": 0.40, "minus_y": 0.03, "minus_z": 0.03},
    "stl": {"z": 0.73, "y": 0.12, "minus_z": 0.05},
    "ply": {"z": 0.57, "y": 0.27, "minus_z": 0.04, "minus_y": 0.03},
    "generated": {"y": 0.70, "z": 0.15, "minus_y": 0.05},
    "unknown": {"y": 0.44, "z": 0.39, "minus_y": 0.03, "minus_z": 0.03},
}

# Directions closer than this are one, radians.
SAME_DIRECTION_RAD = np.radians(6.0)
# So many faces of the hull, the largest, are tried as feet.
MOST_FEET = 6
# Prior weight of a direction that is no axis, relative to that of an axis that nobody speaks for: modellers work along
# axes, scans and simulations that somebody let fall do not.
OFF_AXIS_PRIOR = 0.4


def priors(key: str, names: list[str]) -> Floats:
    """Log prior of each candidate, by its name."""
    stated = UP_PRIOR.get(key, UP_PRIOR["unknown"])
    rest = (1 - sum(stated.values())) / (len(UP_ROTATIONS) - len(stated))
    odds: Floats = np.log(
        np.array([stated.get(n, rest if n in UP_ROTATIONS else rest * OFF_AXIS_PRIOR) for n in names])
    )
    return odds


def candidates(cloud: SurfaceSample) -> list[tuple[str, Floats]]:
    """Names and asset_from_file rotations; the six axes first, in the order of UP_ROTATIONS."""
    found = list(UP_ROTATIONS.items())
    taken = [turn[2] for turn in UP_ROTATIONS.values()]
    ways = [("foot", up) for up in _feet(cloud)]
    _, axes = np.linalg.eigh(np.cov(cloud.samples.T))
    ways += [("along", sign * axis) for axis in axes.T for sign in (1.0, -1.0)]
    for kind, up in ways:
        if all(np.arccos(np.clip(up @ other, -1, 1)) > SAME_DIRECTION_RAD for other in taken):
            taken.append(up)
            found.append((f"{kind}_{sum(n.startswith(kind) for n, _ in found)}", rotation_to_z(up)))
    return found


def _feet(cloud: SurfaceSample) -> list[Floats]:
    """Directions up when the hull stands on one of its larger sides, largest first, or hangs from it.

    Both, because a bowl's largest side is its rim.
    """
    corners = cloud.shell[cloud.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    keep = area > 1e-12
    normals, area = cross[keep] / area[keep, None], area[keep]
    sides: list[tuple[float, Floats]] = []
    open_ = np.ones(len(area), dtype=bool)
    for first in np.argsort(-area, kind="stable"):
        if not open_[first]:
            continue
        mine = open_ & (normals @ normals[first] > np.cos(SAME_DIRECTION_RAD / 2))
        open_ &= ~mine
        mean = (normals[mine] * area[mine, None]).sum(axis=0)
        sides.append((float(area[mine].sum()), -mean / np.linalg.norm(mean)))
        if len(sides) >= 4 * MOST_FEET:
            break
    sides.sort(key=lambda side: -side[0])
    return [way for _, up in sides[:MOST_FEET] for way in (up, -up)]


def rotation_to_z(up: Floats) -> Floats:
    """(3, 3) rotation that brings a unit direction to z by the shortest way from the axis of the file next to it."""
    name = max(UP_ROTATIONS, key=lambda n: float(UP_ROTATIONS[n][2] @ up))
    base = UP_ROTATIONS[name]
    a, b = base @ up, np.array([0.0, 0.0, 1.0])
    axis, cosine = np.cross(a, b), float(a @ b)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    turn: Floats = (np.eye(3) + cross + cross @ cross / (1 + cosine)) @ base
    return turn
