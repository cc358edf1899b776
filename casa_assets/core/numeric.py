"""Array types, rounding, rotation matrices, sRGB, and seeded random generators: the same numbers on every machine."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

# Coordinates and measures.
Floats = npt.NDArray[np.float64]
# The same of pictures, where half the memory is half the time.
Singles = npt.NDArray[np.float32]
# Indices and counts.
Ints = npt.NDArray[np.int64]
# True where something holds.
Mask = npt.NDArray[np.bool_]


def significant(value: float, digits: int) -> float:
    """`value` rounded to `digits` significant digits."""
    return float(f"{value:.{digits}g}")


def seven_digits(value: float) -> float:
    """`value` rounded to seven significant digits, which both formats can represent; 0 below 1e-9."""
    return significant(value, 7) if abs(value) > 1e-9 else 0.0


def decimals(value: float, places: int) -> float:
    """`value` rounded to `places` decimals, as Python or numpy rounds its type; -0.0 becomes 0.0."""
    return round(value, places) + 0.0


def about_axis(axis: Floats, angle: float) -> Floats:
    """(3, 3) right-handed rotation about a (3,) unit axis, angle in rad. Ref: Rodrigues' rotation formula.

    Not scipy's Rotation: its last bits differ, and asset files must stay identical.
    """
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    found: Floats = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    return found


def arc_from_z(axis: tuple[float, float, float]) -> tuple[float, float, float, float]:
    """Quaternion (w, x, y, z) of the shortest arc that turns z onto a unit vector."""
    x, y, z = axis
    if z < -1.0 + 1e-12:  # the arc has no plane; the axis is -z to rounding
        return 0.0, 1.0, 0.0, 0.0
    # Half way between a = (0, 0, 1) and b: (1 + a . b, a x b).
    length = math.sqrt((1.0 + z) * (1.0 + z) + y * y + x * x)
    return (1.0 + z) / length, -y / length, x / length, 0.0


# Jacobi on 3x3 converges quadratically; six sweeps reach the last bit.
JACOBI_SWEEPS = 16


def principal_axes(tensor: Floats) -> tuple[tuple[float, float, float], Floats]:
    """Moments and axes of a symmetric tensor by cyclic Jacobi rotations.

    LAPACK is not used: its last bits depend on the processor, and its axes flip if moments are equal. Rotations compose
    to a proper rotation, and a tensor that is already diagonal keeps its axes and their order.

    Args:
        tensor: (3, 3) symmetric, kg*m^2.
    Returns:
        Moments along the axes, and (3, 3) body_from_principal.
    """
    a = [[float(tensor[i, j]) for j in range(3)] for i in range(3)]
    v = [[float(i == j) for j in range(3)] for i in range(3)]
    for _ in range(JACOBI_SWEEPS):
        for p, q in ((0, 1), (0, 2), (1, 2)):
            if abs(a[p][q]) <= 1e-18 * (abs(a[p][p]) + abs(a[q][q])):
                a[p][q] = a[q][p] = 0.0
                continue
            # Ref: Golub and Van Loan, Matrix Computations, algorithm 8.4.1: the smaller of the two angles.
            tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q])
            t = math.copysign(1.0, tau) / (abs(tau) + math.sqrt(1.0 + tau * tau))
            c = 1.0 / math.sqrt(1.0 + t * t)
            s = t * c
            for k in range(3):
                a[k][p], a[k][q] = c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]
            for k in range(3):
                a[p][k], a[q][k] = c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]
            for k in range(3):
                v[k][p], v[k][q] = c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]
    return (a[0][0], a[1][1], a[2][2]), np.array(v)


# Conversion from display values (sRGB) to linear light and back.
#
# There are separate functions for one channel and for arrays: numpy's power differs from Python's in the last bit, and
# colours that were written before must keep their digits. Ref: IEC 61966-2-1.


def srgb_from_hex(color: str) -> tuple[float, float, float]:
    """Display values in 0..1 of `#rrggbb`."""
    red, green, blue = (int(color[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue


def linear_from_srgb(value: float) -> float:
    """One channel, display value in 0..1 -> linear light in 0..1."""
    return value / 12.92 if value <= 0.04045 else float(((value + 0.055) / 1.055) ** 2.4)


def srgb_from_linear(value: float) -> float:
    """One channel, linear light in 0..1 -> display value in 0..1."""
    return 12.92 * value if value <= 0.0031308 else float(1.055 * value ** (1 / 2.4) - 0.055)


def linear_from_srgb_array(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Display values in 0..1, any shape and precision -> linear light, the same shape and precision."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def srgb_from_linear_array(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Linear light from 0 on, any shape and precision -> display values, the same shape and precision."""
    return np.where(values <= 0.0031308, values * 12.92, 1.055 * np.maximum(values, 0) ** (1 / 2.4) - 0.055)


def rng_for(seed: int, lane: str) -> np.random.Generator:
    """The generator of one lane, such as `families/microwave/3`: one more draw for the walls does not move the cups."""
    digest = hashlib.sha256(lane.encode("utf-8")).digest()
    words = [int.from_bytes(digest[i : i + 4], "little") for i in range(0, 16, 4)]
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, *words])))


@dataclass(frozen=True)
class Forest:
    """Decision trees, each of which gives the probability of each class; the forest gives their mean.

    Attributes:
        features: names of the K input features. classes: names of the C classes. roots: (T,) first node of each tree.
        feature: (N,) feature that a node compares, -1 for a leaf.
        threshold: (N,) a row with at most this value goes left. left, right: (N,) next node.
        chances: (N, C) class probabilities at a leaf.
    """

    features: tuple[str, ...]
    classes: tuple[str, ...]
    roots: Ints
    feature: Ints
    threshold: Floats
    left: Ints
    right: Ints
    chances: Floats

    def probabilities(self, rows: Floats) -> Floats:
        """Return the (R, C) probabilities of each class for (R, K) rows."""
        at = np.tile(self.roots, (len(rows), 1))
        every = np.arange(len(rows))[:, None]
        while (inner := self.feature[at] >= 0).any():
            goes_left = rows[every, np.maximum(self.feature[at], 0)] <= self.threshold[at]
            at = np.where(inner, np.where(goes_left, self.left[at], self.right[at]), at)
        found: Floats = self.chances[at].mean(axis=1)
        return found


def forest_from_dict(data: Mapping[str, Any]) -> Forest:
    """Return the forest of a mapping with `features`, `classes` and `trees`.

    Each tree is a list of nodes, the root first. An inner node is [feature, threshold, left, right], with indices of
    nodes within the tree; a leaf is [[p, ...]], the C probabilities in percent.

    Raises:
        ValueError: something is missing, or an index is out of range.
    """
    try:
        features, classes = tuple(map(str, data["features"])), tuple(map(str, data["classes"]))
        counts = [len(tree) for tree in data["trees"]]
        roots = np.cumsum([0, *counts])[:-1]
        inner = [([*node, 0.0] if len(node) == 4 else [-1.0, 0, 0, 0, 1.0]) for tree in data["trees"] for node in tree]
        leaves = [node[0] for tree in data["trees"] for node in tree if len(node) == 1]
        table, found = np.array(inner, dtype=np.float64), np.array(leaves, dtype=np.float64)
    except (KeyError, TypeError, IndexError) as error:
        raise ValueError(f"not a forest: {error!r}") from None
    is_leaf = table[:, 4] > 0
    chances = np.zeros((len(table), len(classes)))
    chances[is_leaf] = found / found.sum(axis=1, keepdims=True)
    feature = table[:, 0].astype(np.int64)
    start = np.repeat(roots, counts)
    left, right = (start + table[:, k].astype(np.int64) for k in (2, 3))
    at, last = np.arange(len(table)), np.repeat(roots + counts, counts)
    nodes = ~is_leaf
    is_sound = (feature < len(features)).all() and all(
        ((side > at) & (side < last))[nodes].all() for side in (left, right)
    )
    if not is_sound:
        raise ValueError("a forest with an index that points nowhere")
    return Forest(features, classes, roots, feature, table[:, 1], left, right, chances)
