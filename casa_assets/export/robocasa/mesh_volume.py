"""Meshes in which the MuJoCo of every RoboCasa finds a volume.

MuJoCo refuses a mesh in which it finds none, even where it is only seen and weighs nothing, unless it is meant as a
shell. That word is younger than the MuJoCo 3.2.6 which RoboCasa v0.2 is bound to.
"""

from __future__ import annotations

import numpy as np

from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.mesh import Mesh

# A hundred times what MuJoCo calls too small, m^3. Ref: MuJoCo 3.2, mjMINVAL in its compiler of meshes.
LEAST_VOLUME = 1e-13
# Height of what is added behind a flat face: of its width, and in metres at most. By eye: nobody sees it.
DEPTH_SHARE, DEPTH_M = 0.1, 0.0005


def has_volume(mesh: Mesh) -> bool:
    """True if MuJoCo's oldest way of measuring finds a volume in a mesh (metres), closed or not.

    Ref: MuJoCo XML reference, asset/mesh/inertia, `legacy`: tetrahedra to the middle of all faces, without their signs.
    """
    corners = mesh.vertices[mesh.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    if not areas.sum() > 0:
        return False
    a, b, c = np.moveaxis(corners - np.average(corners.mean(axis=1), axis=0, weights=areas), 1, 0)
    return float(np.abs(np.einsum("fd,fd->f", a, np.cross(b, c))).sum()) / 6 > LEAST_VOLUME


def thickened(asset: Asset) -> Asset:
    """The asset, with a small point behind the largest face of whatever is seen of it and flat (a label, a blade)."""
    links = []
    for link in asset.links:
        flat = [not has_volume(visual.mesh) for visual in link.visuals]
        seen = [v.replace(mesh=_pointed(v.mesh)) if f else v for v, f in zip(link.visuals, flat, strict=True)]
        links.append(link.replace(visuals=tuple(seen)) if any(flat) else link)
    return asset.replace(links=tuple(links))


def _pointed(mesh: Mesh) -> Mesh:
    """With a pyramid on the back of its largest face."""
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(normals, axis=1)
    largest = int(np.argmax(np.round(doubled, 12)))
    if not doubled[largest] > 0:
        return mesh
    normal = normals[largest] / doubled[largest]
    depth = min(DEPTH_SHARE * float(np.sqrt(doubled[largest])), DEPTH_M)
    a, b, c = (int(i) for i in mesh.faces[largest])
    tip = len(mesh.vertices)
    return Mesh(
        vertices=np.vstack([mesh.vertices, corners[largest].mean(axis=0) - depth * normal]),
        faces=np.vstack([mesh.faces, [(b, a, tip), (c, b, tip), (a, c, tip)]]),
        uv=None if mesh.uv is None else np.vstack([mesh.uv, mesh.uv[[a, b, c]].mean(axis=0)]),
        normals=None if mesh.normals is None else np.vstack([mesh.normals, -normal]),
    )
