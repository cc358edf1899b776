"""Find which components of a surface touch each other, and the groups that do."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from casa_assets.core.typing import Floats, Ints, Mask
from casa_assets.geometry.solid.coverage import samples_with_faces
from casa_assets.ingest.repair.components import Components

# Surfaces nearer than this share of the longest side touch; a choice, above the distance of the samples.
TOUCH_SHARE = 0.012
SAMPLES = 40_000
FEW_SAMPLES = 300


class Contacts:
    """Contacts between the components of a surface.

    Attributes:
        components: of the surface. pairs: (K, 2) components that touch, each pair once.
    """

    def __init__(self, components: Components, touch_share: float = TOUCH_SHARE) -> None:
        self.components = components
        reach = touch_share * float(np.ptp(components.points, axis=0).max())
        samples, face = samples_with_faces(components.points, components.faces, SAMPLES)
        # A small component may have got few samples or none: corners of so many of its faces join them.
        few = np.bincount(components.label[face], minlength=components.count) < FEW_SAMPLES
        faces = np.bincount(components.label, minlength=components.count)
        by_label = np.argsort(components.label, kind="stable")
        rank = np.empty_like(by_label)
        rank[by_label] = np.arange(len(by_label)) - np.repeat(np.cumsum(faces) - faces, faces)
        step = np.maximum(1, faces // FEW_SAMPLES)[components.label]
        corners = few[components.label] & (rank % step == 0)
        places = np.concatenate((samples, components.points[components.faces[corners]].reshape(-1, 3)))
        label = np.concatenate((components.label[face], np.repeat(components.label[corners], 3)))
        cells = np.column_stack((np.round(places / max(reach / 2, 1e-30)).astype(np.int64), label))
        first = np.unique(cells, axis=0, return_index=True)[1]
        places, label = places[first], label[first]
        near = cKDTree(places).query_pairs(reach, output_type="ndarray")
        touching = np.sort(label[near], axis=1)
        self.pairs: Ints = np.unique(touching[touching[:, 0] != touching[:, 1]], axis=0)

    def groups(self, among: Mask) -> list[Ints]:
        """Components that hang together by contact, without those that are not `among` (N,); largest group first."""
        count = self.components.count
        kept = self.pairs[among[self.pairs].all(axis=1)]
        graph = coo_matrix((np.ones(len(kept), dtype=np.int8), (kept[:, 0], kept[:, 1])), shape=(count, count))
        label = connected_components(graph, directed=False)[1]
        found = [np.flatnonzero(among & (label == k)) for k in np.unique(label[among])]
        return sorted(found, key=lambda rows: (-float(self.extents(rows).max()), int(rows[0])))

    def extents(self, rows: Ints) -> Floats:
        """(3,) sides of the box around some components."""
        lower, upper = self.components.lower[rows], self.components.upper[rows]
        sides: Floats = upper.max(axis=0) - lower.min(axis=0)
        return sides
