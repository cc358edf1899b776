"""Find repeating textures that are not shown at their true size (VIS009)."""

from __future__ import annotations

import numpy as np

from casa_assets.checks.check import Measurement, not_applicable
from casa_assets.model.asset.asset import Asset, Visual
from casa_assets.model.record import Vec2

# Share of a mesh's area that has to be right: seams of a body that is turned or swept leave slivers.
AREA = 0.99
LEAST_AREA_M2 = 1e-9
# Even those are not torn: no triangle of a square millimetre shows its picture at half the size or at one and a half.
TORN, TORN_AREA_M2 = 0.5, 1e-6


def texture_scale_is_true(asset: Asset, limit: float | None) -> Measurement:
    """VIS009: worst deviation of the texture's scale from 1, over 99 % of a mesh's area."""
    assert limit is not None
    tiles = {m.id: m.tile_m for m in asset.materials}
    problems, worst = [], None
    for link in asset.links:
        for visual in link.visuals:
            tile = tiles[visual.material]
            if tile is None:
                continue
            pointer = f"links/{link.name}/visuals/{visual.name}"
            if visual.mesh.uv is None:
                problems.append((pointer, "shows a picture that repeats but has no texture coordinates"))
                continue
            off = _stretch(visual, tile)
            worst = off if worst is None else max(worst, off)
            if off > limit:
                problems.append(
                    (pointer, f"stretches its picture by {off:.1%}; texture coordinates are metres over tile")
                )
    if worst is None and not problems:
        return not_applicable("nothing of it shows a picture that repeats")
    return Measurement(worst, tuple(problems))


def _stretch(visual: Visual, tile: Vec2) -> float:
    """Largest |singular value - 1| of the map from surface to picture in metres, leaving out 1 % of the area."""
    mesh = visual.mesh
    assert mesh.uv is not None
    corners = mesh.vertices[mesh.faces]
    flat = mesh.uv[mesh.faces] * np.array(tile)
    edge_a, edge_b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(edge_a, edge_b)
    area = np.linalg.norm(normal, axis=1) / 2
    keep = area > LEAST_AREA_M2
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
    if torn > TORN:
        return torn
    order = np.argsort(off)
    # Each triangle that begins within the share counts: of a few large ones, all.
    inside = np.cumsum(area[order]) - area[order] < AREA * area.sum()
    return float(off[order][inside].max(initial=0.0))
