"""Evaluate a forest of decision trees, fitted by a script in benchmarks/, to get class probabilities."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from casa_assets.core.numeric import Floats, Ints


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
