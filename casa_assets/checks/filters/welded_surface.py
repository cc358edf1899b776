"""Weld the visible mesh of an ingested asset into one surface, and view it from all around."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from casa_assets.checks.asset.built import is_loose_mesh
from casa_assets.checks.check import Measurement, not_applicable
from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.mesh.topology import face_components, weld
from casa_assets.geometry.mesh.visibility import Visibility, measure_visibility
from casa_assets.model.asset.asset import Asset, Visual

NOT_LOOSE = "it did not come as one loose mesh"


@dataclass(frozen=True)
class WeldedSurface:
    """A surface.

    Attributes:
        points, faces: (P, 3) welded, metres, and (F, 3); faces in the order of the visuals.
        piece: (F,) connected piece of each face. areas: (F,) square metres.
        seen: what pictures from all around show of it.
    """

    points: Floats
    faces: Ints
    piece: Ints
    areas: Floats
    seen: Visibility

    @property
    def longest(self) -> float:
        """Longest side of the box around it, metres."""
        return float(np.ptp(self.seen.samples, axis=0).max())


def welded_surface(asset: Asset) -> WeldedSurface | None:
    """The surface of a loose mesh; None where an asset is something else, or shows nothing."""
    if not is_loose_mesh(asset) or not asset.root.visuals:
        return None
    return _skin(asset.root.visuals)


def why_no_surface(asset: Asset) -> Measurement:
    """Reason why an asset has no welded surface."""
    return not_applicable("nothing of it is seen" if is_loose_mesh(asset) else NOT_LOOSE)


@lru_cache(maxsize=4)
def _skin(visuals: tuple[Visual, ...]) -> WeldedSurface | None:
    starts = np.cumsum([0, *(len(v.mesh.vertices) for v in visuals)])
    faces = np.concatenate([v.mesh.faces + s for v, s in zip(visuals, starts, strict=False)]).astype(np.int64)
    points, place = weld(np.concatenate([v.mesh.vertices for v in visuals]))
    ids = place[faces]
    _, areas = face_normals(points, ids)
    if areas.sum() <= 0:
        return None
    return WeldedSurface(points, ids, face_components(ids, len(points)), areas, measure_visibility(points, ids))
