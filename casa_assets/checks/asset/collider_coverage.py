"""Find visible surfaces that no collision shape covers (AST016)."""

from __future__ import annotations

import numpy as np

from casa_assets.checks.check import Measurement, largest
from casa_assets.geometry.solid.coverage import distances_outside_hulls, surface_samples
from casa_assets.geometry.solid.tessellate import tessellate
from casa_assets.model.asset.asset import Asset, Link

SAMPLES = 4000
# Farther than this from every collision shape, metres or part of the longest side of the link, is bare: twice what
# the boxes around the two may differ by.
REACH_M = 0.008
REACH_RATIO = 0.04


def visible_surface_is_covered(asset: Asset, limit: float | None) -> Measurement:
    """AST016: largest share of a link's visible surface that is away from every collision shape, 0..1."""
    assert limit is not None, "the row names a limit"
    found = {k.name: _bare(k) for k in asset.links if k.visuals and k.colliders}
    message = "{:.0%} of what is seen lies outside every collision shape; add shapes, or close the holes of the mesh"
    problems = tuple((f"links/{name}/colliders", message.format(bare)) for name, bare in found.items() if bare > limit)
    return largest(found.values(), problems, "none of its links is both seen and touched")


def _bare(link: Link) -> float:
    meshes = [v.mesh for v in link.visuals]
    starts = np.cumsum([0] + [len(m.vertices) for m in meshes[:-1]])
    vertices = np.concatenate([m.vertices for m in meshes])
    faces = np.concatenate([m.faces.astype(np.int64) + s for m, s in zip(meshes, starts, strict=True)])
    reach = max(REACH_M, REACH_RATIO * float(np.ptp(vertices, axis=0).max()))
    bare = surface_samples(vertices, faces, SAMPLES)
    for collider in link.colliders:
        # What one shape covers no other has to.
        bare = bare[distances_outside_hulls(bare, [tessellate(collider.shape, collider.pose)[0]]) > reach]
        if not len(bare):
            break
    return len(bare) / SAMPLES
