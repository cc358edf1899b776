"""Texture coordinates measured from a given corner, so that tiles and boards of neighbouring solids line up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from casa_assets.families.kit.solids.skin import flat_uv, uv_offset
from casa_assets.families.kit.solids.solid import Solid
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.model.record import Vec3


def anchor_uv(solid: Solid, name: str, corner: Vec3, along: Vec3, face: Vec3) -> Solid:
    """Return the solid with texture coordinates that start at a corner.

    Args:
        name: under which the solid alone is added: `solid_mesh` shifts the picture of each name, which is taken
            back here.
        corner: where the picture's lower left corner lies, frame of the solid, metres.
        along: unit vector that the picture's height runs along.
        face: unit normal of the faces that are laid so; all others are laid flat wherever they are.
    """
    up, normal = np.array(along), np.array(face)
    across = np.cross(up, normal)
    uv_m = flat_uv(solid.points, solid.faces, up)
    chosen = face_normals(solid.points, solid.faces)[0] @ normal > 0.999
    corners = solid.points[solid.faces[chosen]] - np.array(corner)
    uv_m[chosen] = np.stack([corners @ across, corners @ up], axis=2)
    return replace(solid, uv_m=uv_m - uv_offset(f"{name}/0"))
