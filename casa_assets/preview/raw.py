"""Render a raw model, of which no MJCF exists: the appearance of a rejected input."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from PIL import Image

from casa_assets.core.color import srgb_from_linear_array
from casa_assets.core.typing import Floats
from casa_assets.model.asset.material import Material, Texture
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.ingest.source import RawModel, RawPart, Up
from casa_assets.preview import studio, tonemap
from casa_assets.preview.camera import View, fit
from casa_assets.preview.still import CannotDraw, add_highlights
from casa_assets.preview.tonemap import Pixels

_STANDARD = View(size_px=320, passes=16)
# Above this many faces MuJoCo takes longer to read a mesh than the picture is worth: vertices are moved onto a grid of
# so many steps along the longest side, about one for each pixel, and faces that become alike are drawn once.
_MANY_FACES, _GRID_STEPS = 150_000, 256
_SMALL_FACES = 20_000  # from so many on each is small
_LEAST_VERTICES = 4  # of a mesh that MuJoCo reads
_LARGEST_PX = 1024  # of an image


def render_model(model: RawModel, view: View = _STANDARD) -> bytes:
    """PNG of a raw model, stood up by the axis that its file declares (glTF: y), else z.

    Raises:
        CasaError: it has no triangle, or nothing can draw.
    """
    return render_mesh(model.parts, model.up or Up.Z, view)


def render_mesh(parts: Sequence[RawPart], up: Up = Up.Z, view: View = _STANDARD) -> bytes:
    """PNG of raw parts in file units; size does not matter, broken and flat meshes are drawn from both sides.

    Args:
        parts: meshes with materials.
        up: axis of the file that points up.
        view: direction and size.
    Raises:
        CannotDraw: there is no triangle to draw, or MuJoCo cannot read them. NoRenderer: there is no OpenGL.
    """
    stood = _stand_up([p for p in parts if len(p.mesh.faces)], up)
    if not stood:
        raise CannotDraw("there is no triangle to draw")
    spec = mujoco.MjSpec()
    many = sum(len(p.mesh.faces) for p in stood) > _MANY_FACES
    for i, part in enumerate(stood):
        _add(spec, part.replace(mesh=_coarsened(part.mesh)) if many else part, i)
    add_highlights(spec)
    studio.add_studio(spec, view.size_px)
    try:
        model = spec.compile()
    except ValueError as error:
        raise CannotDraw(str(error).replace("\n", " ")) from error
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    points = studio.place_floor(model, data)
    return tonemap.png(studio.render(model, data, points, fit(points, view), view, both_sides=True))


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


def _coarsened(mesh: Mesh) -> Mesh:
    """A mesh of 1 m, the vertices in each cell of the grid merged into their mean, with colour and uv of the first."""
    cells = np.rint(mesh.vertices * _GRID_STEPS).astype(np.int64)
    keys = (cells[:, 0] * 4 * _GRID_STEPS + cells[:, 1]) * 4 * _GRID_STEPS + cells[:, 2]
    _, first, number, count = np.unique(keys, return_index=True, return_inverse=True, return_counts=True)
    vertices = mesh.vertices.copy()
    vertices[first] = np.stack([np.bincount(number, axis) for axis in vertices.T], axis=1) / count[:, None]
    faces = first[number[mesh.faces]]
    alike = np.sort(faces, axis=1)
    kept = np.unique(alike, axis=0, return_index=True)[1]
    kept = kept[(np.diff(alike[kept], axis=1) > 0).all(axis=1)]
    # Nothing is left of a thing that is smaller than a cell.
    return mesh.replace(vertices=vertices, faces=faces[kept].astype(np.int32) if len(kept) else mesh.faces[:1])


def _add(spec: Any, part: RawPart, i: int) -> None:
    """One part as a mesh, a material and a geom of the spec."""
    mesh = spec.add_mesh()
    mesh.name = f"mesh{i}"
    kept, faces = np.unique(part.mesh.faces, return_inverse=True)
    vertices = part.mesh.vertices[kept].astype(np.float32)
    spare = np.repeat(vertices[:1], max(0, _LEAST_VERTICES - len(vertices)), axis=0)
    mesh.uservert = np.concatenate([vertices, spare]).ravel()
    mesh.userface = faces.astype(np.int32).ravel()
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    pixels, uv, uv_faces = None, np.zeros((0, 2)), faces
    if part.material.base_color_texture is not None and part.mesh.uv is not None:
        pixels, uv = _opened(part.material.base_color_texture), part.mesh.uv[kept]
    elif part.mesh.colors is not None:
        pixels, uv = _palette(part.mesh)
        uv_faces = np.arange(len(uv))
    material = spec.add_material()
    material.name = f"look{i}"
    material.rgba = list(_srgb(part.material))
    material.metallic, material.roughness = part.material.metallic, part.material.roughness
    if pixels is not None:
        # MuJoCo's images begin at the top, ours at the lower left.
        mesh.usertexcoord = (uv * [1.0, -1.0] + [0.0, 1.0]).astype(np.float32).ravel()
        mesh.userfacetexcoord = uv_faces.astype(np.int32).ravel()
        texture = spec.add_texture()
        texture.name = f"image{i}"
        texture.type = mujoco.mjtTexture.mjTEXTURE_2D
        texture.width, texture.height, texture.nchannel = pixels.shape[1], pixels.shape[0], 3
        texture.data = pixels.tobytes()
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = texture.name
    geom = spec.worldbody.add_geom()
    geom.type, geom.meshname, geom.material = mujoco.mjtGeom.mjGEOM_MESH, mesh.name, material.name
    geom.group = studio.VISUAL_GROUP
    geom.contype = geom.conaffinity = 0


def _palette(mesh: Mesh) -> tuple[Pixels, Floats]:
    """An image with 2 x 2 pixels for each face, and (3 F, 2) places of the corners of the faces in it.

    OpenGL mixes the pixels as the colours of the corners mix within the face: the fourth one completes a plane.
    Faces as small as a pixel of the picture would be mixed with others, and have one colour.
    """
    assert mesh.colors is not None
    side = int(np.ceil(np.sqrt(len(mesh.faces))))
    first, second, third = (mesh.colors[mesh.faces[:, k], :3].astype(np.int16) for k in range(3))
    blocks = np.zeros((side * side, 4, 3), dtype=np.uint8)
    blocks[: len(first)] = np.clip(np.stack([first, second, third, second + third - first], axis=1), 0, 255)
    pixels = blocks.reshape(side, side, 2, 2, 3).swapaxes(1, 2).reshape(2 * side, 2 * side, 3)
    row, column = np.divmod(np.arange(len(first)), side)
    within = [[0, 0], [1, 0], [0, -1]] if len(first) < _SMALL_FACES else [[0.5, -0.5]] * 3
    corners = np.stack([2 * column, 2 * (side - row) - 1], axis=1)[:, None] + np.array(within)
    return pixels, (corners.reshape(-1, 2) + 0.5) / (2 * side)


def _opened(texture: Texture) -> Pixels:
    """(H, W, 3) pixels, first row at the top, at most 1024 on a side."""
    with Image.open(io.BytesIO(texture.png)) as source:
        picture = source.convert("RGB")
    picture.thumbnail((_LARGEST_PX, _LARGEST_PX), Image.Resampling.BOX)
    return np.asarray(picture)


def _srgb(material: Material) -> Floats:
    """(4,) base colour as a screen shows it, 0..1; alpha no lower than what can be seen."""
    rgb = np.array(material.base_color[:3])
    curve = srgb_from_linear_array(rgb)
    return np.array([*curve, max(material.base_color[3], 0.15)])
