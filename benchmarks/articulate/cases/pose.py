"""Lay a case of the articulation benchmark in its file in another way."""

from __future__ import annotations

from typing import Any

import numpy as np

# Axes of a file by their names.
AXES = {"+X": (1, 0, 0), "-X": (-1, 0, 0), "+Y": (0, 1, 0), "-Y": (0, -1, 0), "+Z": (0, 0, 1), "-Z": (0, 0, -1)}


def turned(case: Any, rng: np.random.Generator) -> None:
    """The case in another pose, as perturb.py makes it: yaw in quarter turns, Y up, other units, moved."""
    yaw = np.array([[[1, 0], [0, 1]], [[0, -1], [1, 0]], [[-1, 0], [0, -1]], [[0, 1], [-1, 0]]][rng.integers(4)])
    rotation = np.eye(3)
    rotation[:2, :2] = yaw
    if rng.random() < 0.6:
        rotation = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]) @ rotation
    scale = float(rng.choice([1, 100, 1000]))
    shift = rng.normal(0, 0.3, 3) * scale * case.diag

    def there(points: Any) -> Any:
        return np.asarray(points) @ rotation.T * scale + shift

    case.V = there(case.V)
    case.A = case.A * scale**2
    case.diag *= scale
    for key in ("up", "front"):
        case.J[key] = (rotation @ np.array(AXES[case.J[key]])).tolist() if case.J.get(key) else None
    for part in case.parts:
        joint = part["joint"] = dict(part["joint"])
        joint["axis"] = (rotation @ np.array(joint["axis"])).tolist()
        joint["origin"] = there([joint["origin"]])[0].tolist()
        if joint["type"] == "prismatic" and joint["range"]:
            joint["range"] = [r * scale for r in joint["range"]]
        low, high = (there([c])[0] for c in part["bbox"])
        part["bbox"] = [np.minimum(low, high).tolist(), np.maximum(low, high).tolist()]
