"""Find repeating textures that are not shown at their true size (VIS009)."""

from __future__ import annotations

import numpy as np

from casa_assets.checks.asset.applicability import visuals_of
from casa_assets.checks.check import Measurement, largest
from casa_assets.model.asset.asset import Asset, Visual
from casa_assets.model.record import Vec2

# Share of a mesh's area that has to be right: seams of a body that is turned or swept leave slivers.
RIGHT_AREA_SHARE = 0.99
MIN_AREA_M2 = 1e-9
# No triangle larger than a square millimetre, not even of the others, shows its picture at half the size or at one and
# a half. Our choice.
TORN_STRETCH, TORN_AREA_M2 = 0.5, 1e-6


def texture_scale_is_true(asset: Asset, limit: float) -> Measurement:
    """VIS009: worst deviation of the texture's scale from 1, over 99 % of a mesh's area."""
    tiles = {m.id: m.tile_m for m in asset.materials}
    stretches, problems = [], []
    for pointer, _, visual in visuals_of(asset):
        tile = tiles[visual.material]
        if tile is None:
            continue
        if visual.mesh.uv is None:
            problems.append((pointer, "shows a picture that repeats but has no texture coordinates"))
            continue
        stretch = _stretch(visual, tile)
        stretches.append(stretch)
        if stretch > limit:
            message = f"stretches its picture by {stretch:.1%}; texture coordinates are metres over tile"
            problems.append((pointer, message))
    if problems and not stretches:
        return Measurement(problems=tuple(problems))
    return largest(stretches, problems, "nothing of it shows a picture that repeats")


def _stretch(visual: Visual, tile: Vec2) -> float:
    """Largest |singular value - 1| of the map from surface to picture in metres, leaving out 1 % of the area."""
    mesh = visual.mesh
    assert mesh.uv is not None
    corners = mesh.vertices[mesh.faces]
    flat = mesh.uv[mesh.faces] * np.array(tile)
    edge_a, edge_b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(edge_a, edge_b)
    area = np.linalg.norm(normal, axis=1) / 2
    keep = area > MIN_AREA_M2
    if not keep.any():
        return 0.0
    edge_a, edge_b, area, normal = edge_a[keep], edge_b[keep], area[keep], normal[keep]
    length = np.linalg.norm(edge_a, axis=1)
    x = edge_a / length[:, None]
    y = np.cross(normal / (2 * area)[:, None], x)
    # Columns: the two edges in the plane of the face, and in the picture.
    face = np.stack(
        [
            np.stack([length, np.einsum("ij,ij->i", edge_b, x)], 1),
            np.stack([0 * length, np.einsum("ij,ij->i", edge_b, y)], 1),
        ],
        1,
    )
    shown = np.stack([(flat[:, 1] - flat[:, 0])[keep], (flat[:, 2] - flat[:, 0])[keep]], axis=2)
    scales = np.linalg.svd(shown @ np.linalg.inv(face), compute_uv=False)
    off = np.abs(scales - 1).max(axis=1)
    torn = float(off[area > TORN_AREA_M2].max(initial=0.0))
    if torn > TORN_STRETCH:
        return torn
    order = np.argsort(off)
    # A triangle counts where it begins within the share, so that of a few large ones all do.
    counted = np.cumsum(area[order]) - area[order] < RIGHT_AREA_SHARE * area.sum()
    return float(off[order][counted].max(initial=0.0))
