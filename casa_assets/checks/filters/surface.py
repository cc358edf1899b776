"""Find open, inconsistently wound, flat or scattered surfaces, and models with a ground (FLT)."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from casa_assets.checks.check import Measurement, not_applicable, required_limit
from casa_assets.checks.filters.welded_surface import WeldedSurface, welded_surface, why_no_surface
from casa_assets.checks.package.package import Package
from casa_assets.core.typing import Floats, Mask
from casa_assets.geometry.mesh.topology import edge_counts
from casa_assets.model.asset.asset import Asset
from casa_assets.model.registry.category import Category, MatterFill, RestingPose

# A piece thinner than this part of its own width is flat.
FLAT = 0.005
# The share of a flat piece that is seen from both sides, from which on it is a card and no side of a box.
TWO_SIDED = 0.3
# Parts stand apart where no cube of this part of the longest side, nor a neighbour of it, joins them.
APART = 0.03
# What reaches over less than this part of the longest side is a crumb and no part.
LARGE = 0.3
# The lowest part of the height in which a ground lies, and where what stands on it begins.
GROUND, ABOVE = 0.04, 0.12
# So many times broader for its height than a usual one of its category a thing is that stands on a ground.
BROADER = 1.5


def surface_is_opaque(asset: Asset, limit: float | None) -> Measurement:
    """FLT001: share of what is seen from all around that shows backs of faces."""
    found = welded_surface(asset)
    if found is None:
        return why_no_surface(asset)
    share = float(found.seen.behind.mean())
    message = f"{share:.1%} of what is seen are backs of faces; close the holes, or give the walls a thickness"
    return Measurement(share, (("links/object/visuals", message),) if share > required_limit(limit) else ())


def no_side_is_missing(package: Package, limit: float | None) -> Measurement:
    """FLT002: share of the outline of a solid object that shows backs of faces, from the worst side."""
    found = welded_surface(package.asset)
    if found is None:
        return why_no_surface(package.asset)
    if package.category.build not in (MatterFill.SOLID, MatterFill.FILLED):
        return not_applicable(f"a {package.category.id} may be hollow and open")
    worst = int(found.seen.behind.argmax())
    share, sight = float(found.seen.behind[worst]), found.seen.away[worst]
    message = f"seen from {_side(-sight)} {share:.0%} of it is an open hollow, and a {package.category.id} is full"
    problem = (("links/object/visuals", f"{message}; close that side"),)
    return Measurement(share, problem if share > required_limit(limit) else ())


def winding_is_consistent(asset: Asset, limit: float | None) -> Measurement:
    """FLT003: share of the length of inner edges whose two faces wind against each other."""
    found = welded_surface(asset)
    if found is None:
        return why_no_surface(asset)
    ends, uses, balance = edge_counts(found.faces)
    length = np.linalg.norm(found.points[ends[:, 0]] - found.points[ends[:, 1]], axis=1)
    inner = length[uses == 2].sum()
    if inner <= 0:
        return not_applicable("no two of its faces share an edge")
    share = float(length[(uses == 2) & (balance != 0)].sum() / inner)
    message = f"neighbours face opposite ways along {share:.1%} of the edges; make the winding consistent"
    return Measurement(share, (("links/object/visuals", message),) if share > required_limit(limit) else ())


def no_flat_cards(asset: Asset, limit: float | None) -> Measurement:
    """FLT004: share of what is seen that lies on flat sheets seen from both sides."""
    found = welded_surface(asset)
    if found is None:
        return why_no_surface(asset)
    seen = found.seen.front | found.seen.back
    piece = found.piece[found.seen.face]
    cards = [k for k in np.flatnonzero(_flat(found)) if _is_card(found, piece == k)]
    share = float(np.isin(piece[seen], cards).mean()) if seen.any() else 0.0
    message = f"{share:.0%} of what is seen are flat cards, which vanish from the side; model it in the round"
    return Measurement(share, (("links/object/visuals", message),) if share > required_limit(limit) else ())


def mesh_is_connected(asset: Asset, limit: float | None) -> Measurement:
    """FLT005: number of large parts that stand apart from each other; a rigid object is one."""
    found = welded_surface(asset)
    if found is None:
        return why_no_surface(asset)
    count = _parts(found)
    message = (
        f"{count} large parts stand apart, though they move as one; give each object a file of its own, or join them"
    )
    return Measurement(float(count), (("links/object/visuals", message),) if count > required_limit(limit) else ())


def no_ground_plane(package: Package, limit: float | None) -> Measurement:
    """FLT006: factor by which the lowest layer is wider than all above it, where that is unusual."""
    found = welded_surface(package.asset)
    if found is None:
        return why_no_surface(package.asset)
    if package.category.upright is not RestingPose.STANDS or package.category.fixed:
        return not_applicable(f"a {package.category.id} does not stand by itself")
    points = found.seen.samples
    height = points[:, 2] - points[:, 2].min()
    tall = float(height.max())
    low, above = points[height <= GROUND * tall], points[height >= ABOVE * tall]
    if not len(above) or not len(low):
        return not_applicable("it is flat, with nothing above its lowest layer")
    if _is_usually_so_wide(points, package.category):
        return not_applicable(f"a {package.category.id} is usually as broad for its height")
    wide = np.ptp(low[:, :2], axis=0) / np.maximum(np.ptp(above[:, :2], axis=0), 1e-9)
    number = float(wide.min())
    message = f"stands on a ground that is {number:.1f} times wider than itself; export it without"
    return Measurement(number, (("links/object/visuals", message),) if number > required_limit(limit) else ())


def _side(toward: Floats) -> str:
    """Name of the side that a direction looks from."""
    names = ("the right", "behind", "above"), ("the left", "the front", "below")
    axis = int(np.abs(toward).argmax())
    return names[0 if toward[axis] > 0 else 1][axis]


def _flat(found: WeldedSurface) -> Mask:
    """(C,) which pieces are flat."""
    count = int(found.piece.max()) + 1
    flat = np.zeros(count, dtype=bool)
    order = np.argsort(found.piece, kind="stable")
    for k, rows in enumerate(np.split(order, np.cumsum(np.bincount(found.piece, minlength=count))[:-1])):
        corners = found.points[found.faces[rows]].reshape(-1, 3)
        _, axes = np.linalg.eigh(np.cov(corners.T))
        thin, wide, _ = np.ptp(corners @ axes, axis=0)
        flat[k] = thin <= FLAT * wide
    return flat


def _is_card(found: WeldedSurface, rows: Mask) -> bool:
    """True if a flat piece is seen from both sides, by its back or because it has faces to both."""
    front, back = found.seen.front[rows], found.seen.back[rows]
    if not (front | back).any():
        return False
    faces = found.faces[np.unique(found.seen.face[rows])]
    corners = found.points[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    both_ways = bool((normals @ normals[int(np.linalg.norm(normals, axis=1).argmax())] < 0).any())
    return float((front & back).mean()) > TWO_SIDED or (both_ways and float(front.mean()) > 2 * TWO_SIDED)


def _parts(found: WeldedSurface) -> int:
    """Number of connected groups of occupied cells that reach far."""
    samples = found.seen.samples
    cell = APART * found.longest
    at = np.floor((samples - samples.min(axis=0)) / cell).astype(np.int64)
    cubes = np.zeros(at.max(axis=0) + 1, dtype=bool)
    cubes[tuple(at.T)] = True
    label, _ = ndimage.label(cubes, np.ones((3, 3, 3)))
    boxes = ndimage.find_objects(label)
    return sum(max(s.stop - s.start for s in box) * APART > LARGE for box in boxes)


def _is_usually_so_wide(points: Floats, category: Category) -> bool:
    """True if a usual thing of the category is nearly as broad for its height as this one."""
    size = np.ptp(points, axis=0)
    x, y, z = (side.typical for side in category.extents)
    return category.id != "object" and float(size[:2].max()) / float(size[2]) <= BROADER * max(x, y) / z
