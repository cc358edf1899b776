"""Render a raw model, of which no MJCF exists: the appearance of a rejected input."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from casa_assets.errors import CasaError
from casa_assets.model.asset.material import Texture
from casa_assets.model.ingest.source import RawModel, RawPart, Up
from casa_assets.preview import studio, tonemap
from casa_assets.preview.camera import View, fit
from casa_assets.preview.raw import point_splatting, raw_materials
from casa_assets.preview.still import add_highlights

# Above this MuJoCo takes longer to read a mesh than the picture is worth.
_MANY_FACES = 150_000
_STANDARD = View(size_px=320, passes=16)


def render_model(model: RawModel, view: View = _STANDARD) -> bytes:
    """PNG of a raw model, stood up by the axis that its file declares (glTF: y), else z.

    Raises:
        CasaError: it has no triangle, or nothing can draw.
    """
    return render_mesh(model.parts, model.up or Up.Z, view)


def render_mesh(parts: Sequence[RawPart], up: Up = Up.Z, view: View = _STANDARD) -> bytes:
    """PNG of raw parts in file units; size does not matter, broken and flat meshes are drawn as they are.

    Args:
        parts: meshes with materials.
        up: axis of the file that points up.
        view: direction and size.
    Raises:
        CasaError: there is no triangle to draw.
    """
    stood = _stand_up([p for p in parts if len(p.mesh.faces)], up)
    if not stood:
        raise CasaError("there is no triangle to draw")
    faces = sum(len(p.mesh.faces) for p in stood)
    painted = any(p.mesh.colors is not None for p in stood)
    if faces <= _MANY_FACES and not painted:
        try:
            return _with_mujoco(stood, view)
        except (ValueError, CasaError):
            # MuJoCo refuses flat meshes and the like, or there is no OpenGL: the picture is drawn by hand.
            pass
    return tonemap.png(point_splatting.draw(stood, view))


def _stand_up(parts: Sequence[RawPart], up: Up) -> list[RawPart]:
    """The parts with z up, about the origin, the longest side 1 m; unused vertices do not count."""
    turn = {Up.X: [[0, -1, 0], [0, 0, -1], [1, 0, 0]], Up.Y: [[1, 0, 0], [0, 0, -1], [0, 1, 0]], Up.Z: np.eye(3)}[up]
    clouds = [p.mesh.vertices @ np.array(turn).T for p in parts]
    if not parts:
        return []
    used = np.concatenate([c[np.unique(p.mesh.faces)] for c, p in zip(clouds, parts, strict=True)])
    lower, upper = used.min(axis=0), used.max(axis=0)
    scale = 1.0 / max(float((upper - lower).max()), 1e-300)
    return [
        p.replace(mesh=p.mesh.replace(vertices=(c - (lower + upper) / 2.0) * scale, normals=None))
        for c, p in zip(clouds, parts, strict=True)
    ]


def _with_mujoco(parts: Sequence[RawPart], view: View) -> bytes:
    """PNG by MuJoCo from a spec in memory. Raises ValueError where it refuses a mesh."""
    spec = mujoco.MjSpec()
    for i, part in enumerate(parts):
        _add(spec, part, i)
    add_highlights(spec)
    studio.add_studio(spec, view.size_px)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    points = studio.place_floor(model, data)
    return tonemap.png(studio.render(model, data, points, fit(points, view), view, both_sides=True))


def _add(spec: Any, part: RawPart, i: int) -> None:
    """One part as a mesh, a material and a geom of the spec."""
    mesh = spec.add_mesh()
    mesh.name = f"mesh{i}"
    kept, faces = np.unique(part.mesh.faces, return_inverse=True)
    mesh.uservert = part.mesh.vertices[kept].astype(np.float32).ravel()
    mesh.userface = faces.astype(np.int32).ravel()
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    if part.mesh.uv is not None:
        # MuJoCo's images begin at the top, ours at the lower left.
        uv = part.mesh.uv[kept].astype(np.float32) * [1.0, -1.0] + [0.0, 1.0]
        mesh.usertexcoord = uv.astype(np.float32).ravel()
        mesh.userfacetexcoord = faces.astype(np.int32).ravel()
    material = spec.add_material()
    material.name = f"look{i}"
    material.rgba = list(raw_materials.srgb(part.material))
    material.metallic, material.roughness = part.material.metallic, part.material.roughness
    if part.material.base_color_texture is not None and part.mesh.uv is not None:
        texture = spec.add_texture()
        texture.name = f"image{i}"
        _fill(texture, part.material.base_color_texture)
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = texture.name
    geom = spec.worldbody.add_geom()
    geom.type, geom.meshname, geom.material = mujoco.mjtGeom.mjGEOM_MESH, mesh.name, material.name
    geom.group = studio.VISUAL_GROUP
    geom.contype = geom.conaffinity = 0


def _fill(texture: Any, picture: Texture) -> None:
    """The image as data of an MjsTexture, made smaller where it is large."""
    pixels = raw_materials.opened(picture)
    texture.type = mujoco.mjtTexture.mjTEXTURE_2D
    texture.width, texture.height, texture.nchannel = pixels.shape[1], pixels.shape[0], 3
    texture.data = pixels.tobytes()
