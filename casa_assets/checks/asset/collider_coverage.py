"""Find visible surfaces that no collision shape covers (AST016)."""

from __future__ import annotations

import numpy as np

from casa_assets.checks.asset.applicability import merged_mesh
from casa_assets.checks.check import Measurement, all_at_most
from casa_assets.geometry.solid.coverage import distances_outside_hulls, surface_samples
from casa_assets.geometry.solid.tessellate import tessellate
from casa_assets.model.asset.asset import Asset, Link

# Points of the visible surface that are looked at. Our choice.
SAMPLES = 4000
# A point is uncovered where it is farther than this from every collision shape: metres, or this part of the longest
# side of the link where that is more. Both are twice what the boxes around the two may differ by (AST009).
REACH_M = 0.008
REACH_RATIO = 0.04


def visible_surface_is_covered(asset: Asset, limit: float) -> Measurement:
    """AST016: largest share of a link's visible surface that is away from every collision shape, 0..1."""
    shares = {f"links/{k.name}/colliders": _uncovered_share(k) for k in asset.links if k.visuals and k.colliders}
    message = "{:.0%} of what is seen lies outside every collision shape; add shapes, or close the holes of the mesh"
    return all_at_most(shares, limit, message, "none of its links is both seen and touched")


def _uncovered_share(link: Link) -> float:
    vertices, faces = merged_mesh(link.visuals)
    reach = max(REACH_M, REACH_RATIO * float(np.ptp(vertices, axis=0).max()))
    uncovered = surface_samples(vertices, faces, SAMPLES)
    for collider in link.colliders:
        # What one shape covers need not be held against the others.
        hull = tessellate(collider.shape, collider.pose)[0]
        uncovered = uncovered[distances_outside_hulls(uncovered, [hull]) > reach]
        if not len(uncovered):
            break
    return len(uncovered) / SAMPLES
