"""Weld the visible mesh of an ingested asset into one surface, and view it from all around."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from casa_assets.checks.asset.applicability import NO_VISUALS, is_loose_mesh, merged_mesh
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
        component: (F,) connected component of each face. areas: (F,) square metres.
        visibility: what pictures from all around show of it.
    """

    points: Floats
    faces: Ints
    component: Ints
    areas: Floats
    visibility: Visibility

    @property
    def longest(self) -> float:
        """Longest side of the box around it, metres."""
        return float(np.ptp(self.visibility.samples, axis=0).max())


def welded_surface(asset: Asset) -> WeldedSurface | Measurement:
    """The surface of a loose mesh, or the result of a filter that has none to look at."""
    if not is_loose_mesh(asset):
        return not_applicable(NOT_LOOSE)
    surface = _weld_visuals(asset.root.visuals) if asset.root.visuals else None
    return not_applicable(NO_VISUALS) if surface is None else surface


@lru_cache(maxsize=4)
def _weld_visuals(visuals: tuple[Visual, ...]) -> WeldedSurface | None:
    vertices, faces = merged_mesh(visuals)
    points, welded = weld(vertices)
    faces = welded[faces]
    _, areas = face_normals(points, faces)
    if areas.sum() <= 0:
        return None
    component = face_components(faces, len(points))
    return WeldedSurface(points, faces, component, areas, measure_visibility(points, faces))
