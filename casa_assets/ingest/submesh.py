"""Some faces of a mesh as a separate mesh."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Ints
from casa_assets.model.asset.mesh import Mesh


def submesh(mesh: Mesh, faces: Ints, keep_normals: bool = True) -> Mesh:
    """The mesh with these faces alone, and the vertices that they use in the order that they had.

    Args:
        faces: (F, 3) indices into the vertices of the mesh.
    """
    used, local = np.unique(faces, return_inverse=True)
    return Mesh(
        vertices=mesh.vertices[used],
        faces=local.reshape(-1, 3),
        uv=None if mesh.uv is None else mesh.uv[used],
        normals=None if mesh.normals is None or not keep_normals else mesh.normals[used],
        colors=None if mesh.colors is None else mesh.colors[used],
    )
