"""Make meshes that have a volume for the MuJoCo version of every RoboCasa release.

MuJoCo refuses a mesh without volume, even a visual one without mass, unless its `inertia` is `shell`. RoboCasa v0.2
needs MuJoCo 3.2.6, which does not know that value.
"""

from __future__ import annotations

import numpy as np

from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.parts import Mesh

# A hundred times what MuJoCo calls too small, m^3. Ref: MuJoCo 3.2, mjMINVAL in its compiler of meshes.
MIN_VOLUME_M3 = 1e-13
# Height of the pyramid behind a flat face: share of the face's width, and at most so many metres. A choice: too small
# to be seen.
DEPTH_SHARE, MAX_DEPTH_M = 0.1, 0.0005


def has_volume(mesh: Mesh) -> bool:
    """True if MuJoCo's oldest method finds a volume in a mesh (metres), closed or not.

    Ref: MuJoCo XML reference, asset/mesh/inertia, `legacy`: tetrahedra from the middle to all faces, without their
    signs.
    """
    corners = mesh.vertices[mesh.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    if not areas.sum() > 0:
        return False
    a, b, c = np.moveaxis(corners - np.average(corners.mean(axis=1), axis=0, weights=areas), 1, 0)
    return float(np.abs(np.einsum("fd,fd->f", a, np.cross(b, c))).sum()) / 6 > MIN_VOLUME_M3


def thickened(asset: Asset) -> Asset:
    """The asset with a small pyramid behind the largest face of every flat visual (a label, a blade)."""
    links = []
    for link in asset.links:
        is_flat = [not has_volume(visual.mesh) for visual in link.visuals]
        visuals = [
            v.replace(mesh=_with_pyramid(v.mesh)) if f else v for v, f in zip(link.visuals, is_flat, strict=True)
        ]
        links.append(link.replace(visuals=tuple(visuals)) if any(is_flat) else link)
    return asset.replace(links=tuple(links))


def _with_pyramid(mesh: Mesh) -> Mesh:
    """A mesh with a pyramid added on the back of its largest face."""
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled_areas = np.linalg.norm(normals, axis=1)
    largest = int(np.argmax(np.round(doubled_areas, 12)))
    if not doubled_areas[largest] > 0:
        return mesh
    normal = normals[largest] / doubled_areas[largest]
    depth = min(DEPTH_SHARE * float(np.sqrt(doubled_areas[largest])), MAX_DEPTH_M)
    a, b, c = (int(i) for i in mesh.faces[largest])
    tip = len(mesh.vertices)
    return Mesh(
        vertices=np.vstack([mesh.vertices, corners[largest].mean(axis=0) - depth * normal]),
        faces=np.vstack([mesh.faces, [(b, a, tip), (c, b, tip), (a, c, tip)]]),
        uv=None if mesh.uv is None else np.vstack([mesh.uv, mesh.uv[[a, b, c]].mean(axis=0)]),
        normals=None if mesh.normals is None else np.vstack([mesh.normals, -normal]),
    )
