"""Remove visuals and pictures from an MjSpec; they take time to load and touch nothing."""

from __future__ import annotations

import mujoco


def remove_visuals(spec: mujoco.MjSpec) -> None:
    """Take visual geoms, materials, textures, and the meshes that only they used out of a specification."""
    for geom in list(spec.geoms):
        if geom.contype == 0 and geom.conaffinity == 0:
            spec.delete(geom)
    for image in [*spec.materials, *spec.textures]:
        spec.delete(image)
    used = {geom.meshname for geom in spec.geoms}
    for mesh in list(spec.meshes):
        if mesh.name not in used:
            spec.delete(mesh)
