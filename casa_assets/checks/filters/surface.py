"""Find open, inconsistently wound, flat or scattered surfaces, and models with a ground (FLT)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import ndimage

from casa_assets.checks.check import NO_VISUALS, Measurement, at_most, is_loose_mesh, merged_mesh, not_applicable
from casa_assets.checks.package import Package
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.mesh.surface import face_normals
from casa_assets.mesh.topology import edge_counts, face_components, weld
from casa_assets.mesh.visibility import Visibility, measure_visibility
from casa_assets.model.asset.asset import Asset, Visual
from casa_assets.model.registry.category import MatterFill, RestingPose

# Welded surface -------------------------------------------------------------------------------------------------------
# Weld the visible mesh of an ingested asset into one surface, and view it from all around.

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


# Surface --------------------------------------------------------------------------------------------------------------

# All lengths are parts of another length. Choices, tried on spoilt meshes by benchmarks/ingest/filters.py.
# A component thinner than this part of its own width is flat.
FLATNESS = 0.005
# The share of a flat component that is seen from both sides, from which on it is a card and no side of a box.
TWO_SIDED_SHARE = 0.3
# Parts stand apart where no voxel of this part of the longest side, nor a neighbour of it, joins them.
VOXEL = 0.03
# What reaches over less than this part of the longest side is a crumb and no part.
LARGE_PART = 0.3
# The lowest part of the height, in which a ground lies, and where what stands on it begins.
GROUND_TOP, OBJECT_BOTTOM = 0.04, 0.12
# An object that stands on a ground is so many times broader for its height than is usual for its category.
BROADER_THAN_USUAL = 1.5
VISUALS = "links/object/visuals"
# Of the positive and of the negative direction of each axis.
SIDES = ("the right", "behind", "above"), ("the left", "the front", "below")


def surface_is_opaque(asset: Asset, limit: float) -> Measurement:
    """FLT001: share of what is seen from all around that shows backs of faces."""
    surface = welded_surface(asset)
    if isinstance(surface, Measurement):
        return surface
    share = float(surface.visibility.behind.mean())
    message = f"{share:.1%} of what is seen are backs of faces; close the holes, or give the walls a thickness"
    return at_most(share, limit, VISUALS, message)


def no_side_is_missing(package: Package, limit: float) -> Measurement:
    """FLT002: share of the outline of a solid object that shows backs of faces, from the worst side."""
    surface, category = welded_surface(package.asset), package.category
    if isinstance(surface, Measurement):
        return surface
    if category.build not in (MatterFill.SOLID, MatterFill.FILLED):
        return not_applicable(f"a {category.id} may be hollow and open")
    worst = int(surface.visibility.behind.argmax())
    share, toward = float(surface.visibility.behind[worst]), -surface.visibility.away[worst]
    axis = int(np.abs(toward).argmax())
    side = SIDES[0 if toward[axis] > 0 else 1][axis]
    message = f"seen from {side} {share:.0%} of it is an open hollow, and a {category.id} is full"
    return at_most(share, limit, VISUALS, f"{message}; close that side")


def winding_is_consistent(asset: Asset, limit: float) -> Measurement:
    """FLT003: share of the length of inner edges whose two faces wind against each other."""
    surface = welded_surface(asset)
    if isinstance(surface, Measurement):
        return surface
    ends, uses, balance = edge_counts(surface.faces)
    lengths = np.linalg.norm(surface.points[ends[:, 0]] - surface.points[ends[:, 1]], axis=1)
    inner = lengths[uses == 2].sum()
    if inner <= 0:
        return not_applicable("no two of its faces share an edge")
    share = float(lengths[(uses == 2) & (balance != 0)].sum() / inner)
    message = f"neighbours face opposite ways along {share:.1%} of the edges; make the winding consistent"
    return at_most(share, limit, VISUALS, message)


def no_flat_cards(asset: Asset, limit: float) -> Measurement:
    """FLT004: share of what is seen that lies on flat sheets seen from both sides."""
    surface = welded_surface(asset)
    if isinstance(surface, Measurement):
        return surface
    seen = surface.visibility.front | surface.visibility.back
    component = surface.component[surface.visibility.face]
    cards = [k for k in np.flatnonzero(_flat_components(surface)) if _is_card(surface, component == k)]
    share = float(np.isin(component[seen], cards).mean()) if seen.any() else 0.0
    message = f"{share:.0%} of what is seen are flat cards, which vanish from the side; model it in the round"
    return at_most(share, limit, VISUALS, message)


def mesh_is_connected(asset: Asset, limit: float) -> Measurement:
    """FLT005: number of large parts that are separate from each other; a rigid object is one."""
    surface = welded_surface(asset)
    if isinstance(surface, Measurement):
        return surface
    samples = surface.visibility.samples
    at = np.floor((samples - samples.min(axis=0)) / (VOXEL * surface.longest)).astype(np.int64)
    occupied = np.zeros(at.max(axis=0) + 1, dtype=bool)
    occupied[tuple(at.T)] = True
    label, _ = ndimage.label(occupied, np.ones((3, 3, 3)))
    boxes = ndimage.find_objects(label)
    parts = sum(max(s.stop - s.start for s in box) * VOXEL > LARGE_PART for box in boxes)
    message = f"{parts} large parts stand apart, though they move as one"
    return at_most(float(parts), limit, VISUALS, f"{message}; give each object a file of its own, or join them")


def no_ground_plane(package: Package, limit: float) -> Measurement:
    """FLT006: factor by which the lowest layer is wider than all above it, where that is unusual."""
    surface, category = welded_surface(package.asset), package.category
    if isinstance(surface, Measurement):
        return surface
    if category.upright is not RestingPose.STANDS or category.fixed:
        return not_applicable(f"a {category.id} does not stand by itself")
    points = surface.visibility.samples
    height = points[:, 2] - points[:, 2].min()
    tallest = float(height.max())
    lowest, above = points[height <= GROUND_TOP * tallest], points[height >= OBJECT_BOTTOM * tallest]
    if not len(above) or not len(lowest):
        return not_applicable("it is flat, with nothing above its lowest layer")
    size = np.ptp(points, axis=0)
    x, y, z = (extent.typical for extent in category.extents)
    if category.id != "object" and float(size[:2].max()) / float(size[2]) <= BROADER_THAN_USUAL * max(x, y) / z:
        return not_applicable(f"a {category.id} is usually as broad for its height")
    ratio = float((np.ptp(lowest[:, :2], axis=0) / np.maximum(np.ptp(above[:, :2], axis=0), 1e-9)).min())
    message = f"stands on a ground that is {ratio:.1f} times wider than itself; export it without"
    return at_most(ratio, limit, VISUALS, message)


def _flat_components(surface: WeldedSurface) -> Mask:
    """(C,) which components are flat."""
    components = int(surface.component.max()) + 1
    flat = np.zeros(components, dtype=bool)
    order = np.argsort(surface.component, kind="stable")
    ends = np.cumsum(np.bincount(surface.component, minlength=components))[:-1]
    for k, rows in enumerate(np.split(order, ends)):
        corners = surface.points[surface.faces[rows]].reshape(-1, 3)
        _, axes = np.linalg.eigh(np.cov(corners.T))
        thickness, width, _ = np.ptp(corners @ axes, axis=0)
        flat[k] = thickness <= FLATNESS * width
    return flat


def _is_card(surface: WeldedSurface, rows: Mask) -> bool:
    """True if a flat component is seen from both sides, by its back or because it has faces to both.

    Args:
        rows: (N,) which samples lie on the component.
    """
    front, back = surface.visibility.front[rows], surface.visibility.back[rows]
    if not (front | back).any():
        return False
    corners = surface.points[surface.faces[np.unique(surface.visibility.face[rows])]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    faces_both_ways = bool((normals @ normals[int(np.linalg.norm(normals, axis=1).argmax())] < 0).any())
    if float((front & back).mean()) > TWO_SIDED_SHARE:
        return True
    return faces_both_ways and float(front.mean()) > 2 * TWO_SIDED_SHARE
