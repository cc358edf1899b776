"""Find inertia that no such body has, and meshes or pictures that are slow to load (FLT)."""

from __future__ import annotations

import numpy as np

from casa_assets.checks.asset.applicability import NO_COLLIDERS, is_loose_mesh
from casa_assets.checks.check import Measurement, at_most, not_applicable, not_run
from casa_assets.checks.filters.welded_surface import NOT_LOOSE
from casa_assets.geometry.mesh.measure import signed_volume, solid_moments
from casa_assets.geometry.solid.hull import convex_hull
from casa_assets.geometry.solid.manifold import union
from casa_assets.geometry.solid.tessellate import tessellate
from casa_assets.model.asset.asset import Asset

# Milliseconds that MuJoCo takes to load a thousand triangles, and a million pixels, as benchmarks/ingest/filters.py
# measures them on one core. The time is estimated with them and not measured, so that it is the same on any machine.
FACES_MS, PIXELS_MS = 5.0, 25.0
# Part of the greatest moment of inertia that another one may be off without being felt.
SLIGHT_SHARE = 0.05


def inertia_is_plausible(asset: Asset, limit: float) -> Measurement:
    """FLT014: factor between the inertia and that of the evenly filled shapes, on the worst axis."""
    if not is_loose_mesh(asset) or not asset.root.colliders:
        return not_applicable(NO_COLLIDERS if is_loose_mesh(asset) else NOT_LOOSE)
    link = asset.root
    surfaces = [tessellate(c.shape, c.pose) for c in link.colliders]
    solid = union(surfaces) or convex_hull(np.concatenate([s[0] for s in surfaces]))
    volume = signed_volume(*solid)
    if volume <= 0:
        return not_run("its collision shapes enclose no volume")
    tensor = solid_moments(*solid)[2]
    expected = np.linalg.eigvalsh(tensor * (link.inertial.mass / volume))
    actual = np.linalg.eigvalsh(link.inertial.tensor)
    # The moment of a knife about its own length hangs on its thickness, which meshes do not say exactly. So moments
    # that are small beside the greatest one count less.
    slight = SLIGHT_SHARE * expected.max()
    ratio = (actual + slight) / (expected + slight)
    factor = float(np.maximum(ratio, 1 / ratio).max())
    message = f"turns {factor:.1f} times harder or easier than its shapes filled evenly; measure the inertia again"
    return at_most(factor, limit, "links/object/inertial", message)


def load_time_is_bounded(asset: Asset, limit: float) -> Measurement:
    """FLT013: estimated loading time in a simulator, from triangles and pixels, milliseconds."""
    if not is_loose_mesh(asset):
        return not_applicable(NOT_LOOSE)
    faces = sum(len(v.mesh.faces) for v in asset.root.visuals)
    # MuJoCo reads the colours alone; the other pictures are read by those who load the USD.
    images = {t.file_name: t.width_px * t.height_px for m in asset.materials for t in m.textures}
    million_pixels = sum(images.values()) / 1e6
    load_ms = FACES_MS * faces / 1e3 + PIXELS_MS * sum(images.values()) / 1e6
    message = f"takes about {load_ms:.0f} ms to load ({faces} triangles, {million_pixels:.1f} million pixels)"
    return at_most(load_ms, limit, "", f"{message}; scale its pictures down")
