"""FBX, text or binary -> RawModel: one part for each material of each placed mesh."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import ufbx

from casa_assets.core.numeric import Floats
from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import Format, Reference, Role
from casa_assets.formats.read.materials import Look, Materials, linear_from_srgb
from casa_assets.formats.read.raw_parts import (
    ReadPart,
    check_face_count,
    cut_polygons,
    part_of_corners,
    raw_model,
    rgba,
    transformed,
)
from casa_assets.formats.read.text import Notes, printable
from casa_assets.model import rejection_codes as codes
from casa_assets.model.asset.material import Material
from casa_assets.model.source import Bundle, RawModel, Up

_TURNED = {1: Up.X, 3: Up.Y, 5: Up.Z}
DEEPEST_NODE = 1000

# The lists of ufbx 0.0.5 hand out elements without counting the reference, so that Python frees them too early. What
# is counted here then points into a scene that may not go before it, so a scene stays until the process ends, which in
# a run is after one input.
_count_reference = ctypes.pythonapi.Py_IncRef
_count_reference.argtypes, _count_reference.restype = [ctypes.py_object], None


def open_fbx(data: bytes, name: str) -> ufbx.Scene:
    """The scene of an FBX; no file that it names is opened. Raises Rejected SCENE_UNREADABLE, TRUNCATED."""
    try:
        scene = ufbx.load_memory(
            data,
            load_external_files=False,
            evaluate_caches=False,
            ignore_animation=True,
            node_depth_limit=DEEPEST_NODE,
            file_format=ufbx.FileFormat.FBX,
        )
    except (ufbx.TruncatedFileError, ufbx.EmptyFileError) as error:
        raise Rejected(codes.TRUNCATED, f"{name}: the FBX ends before it is complete; fetch it again") from error
    except (ufbx.UfbxError, ValueError, MemoryError) as error:
        why = printable(str(error), 80) or type(error).__name__
        message = f"{name}: the FBX cannot be read ({why}); open it in Blender and export it as GLB"
        raise Rejected(codes.SCENE_UNREADABLE, message) from error
    _count_reference(scene)
    return scene


def references(data: bytes, name: str) -> list[Reference]:
    """Pictures that are not packed into the FBX, as written there. Raises Rejected as `open_fbx`."""
    textures = _held(open_fbx(data, name).textures)
    return [Reference(_file_name(texture), Role.IMAGE) for texture in textures if not texture.content]


def load(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of an FBX: its stated unit (the format has one always) and up axis."""
    name = printable(bundle.main)
    scene = open_fbx(bundle.files[bundle.main], name)
    left_out = {
        "skin_deformers": "a rigged mesh: read as it was modelled, without its rig",
        "blend_deformers": "morph targets are left out; the rest shape is read",
        "anim_curves": "animations are left out; the rest pose is read",
        "nurbs_surfaces": "NURBS surfaces are left out; convert them to meshes",
    }
    for what, message in left_out.items():
        if len(getattr(scene, what)):
            notes.add(codes.FEATURE_IGNORED, what, message)
    reader = _Reader(bundle.files, limits, notes, name)
    parts = [part for node in _held(scene.nodes) if node.mesh is not None for part in reader.parts(node)]
    metres, up = float(scene.settings.unit_meters), int(scene.settings.axes.up)
    if up in _TURNED:
        notes.add(codes.FEATURE_IGNORED, "axes", f"states that minus {_TURNED[up].value} points up; read as if plus")
    stated = metres if np.isfinite(metres) and metres > 0.0 else None
    joints = max((len(skin.clusters) for skin in _held(scene.skin_deformers)), default=0)
    ups = {0: Up.X, 2: Up.Y, 4: Up.Z, **_TURNED}
    return raw_model(parts, notes, name, Format.FBX, stated, ups.get(up), joints)


class _Reader:
    def __init__(self, files: Mapping[str, bytes], limits: Mapping[str, float], notes: Notes, name: str) -> None:
        self._files, self._limits, self._notes, self._name = files, limits, notes, name
        self._materials = Materials(limits, notes)
        self._faces = 0

    def parts(self, node: Any) -> Iterator[ReadPart]:
        """A part for each material of a node's mesh, moved to its place in the file."""
        mesh, label = node.mesh, node.name or node.mesh.name or "mesh"
        self._faces += int(mesh.num_triangles)
        check_face_count(self._faces, self._limits, self._name)
        points = np.array(mesh.vertices, dtype=np.float64).reshape(-1, 3)
        corners = np.array(mesh.vertex_indices, dtype=np.int64).reshape(-1)
        spans = np.array(mesh.faces, dtype=np.int64).reshape(-1, 2)
        counts = spans[:, 1]  # ufbx numbers corners face after face
        triangles, owner = cut_polygons(points, corners, counts, self._limits, self._notes, self._name)
        points, _, is_mirrored = transformed(points, None, _matrix(node.geometry_to_world))
        normals = _corner_values(mesh.vertex_normal, len(corners), 3)
        if normals is not None:
            _, normals, _ = transformed(normals[:1], normals, _matrix(node.geometry_to_world))
        uv = _corner_values(mesh.vertex_uv, len(corners), 2)
        colors = _corner_values(mesh.vertex_color, len(corners), 4)
        shades = None if colors is None else rgba(np.nan_to_num(colors) * 255.0)
        if is_mirrored:
            triangles = triangles[:, ::-1]
        slots = np.array(mesh.face_material, dtype=np.int64).reshape(-1)
        slot = slots[owner] if len(slots) == len(spans) else np.zeros(len(owner), dtype=np.int64)
        materials = list(_held(node.materials))
        for number in np.unique(slot):
            chosen = triangles[slot == number]
            material = self._material(materials, int(number), shades is not None)
            yield part_of_corners(label, points, corners, chosen, material, uv, normals, shades)
        if not len(slot):
            yield ReadPart(label, points[:1], triangles, self._material((), 0, is_colored=False))

    def _material(self, materials: Sequence[Any], number: int, is_colored: bool) -> Material:
        if number >= len(materials):
            look = Look("material", (1.0, 1.0, 1.0)) if is_colored else Look("material")
            return self._materials.material(("none", is_colored), lambda: look)
        source = materials[number]
        return self._materials.material(int(source.element_id), lambda: self._look(source))

    def _look(self, source: Any) -> Look:
        pbr, fbx = source.pbr, source.fbx
        base, factor = pbr.base_color, pbr.base_factor
        share = float(factor.value_vec4.x) if factor.has_value else 1.0
        value = base.value_vec4
        # Display values, as programs write them; a colour of the modern kind is linear.
        is_pbr = bool(source.features.pbr.enabled)
        color = [float(value.x), float(value.y), float(value.z)] if base.has_value else [0.8] * 3
        texture = base.texture or fbx.diffuse_color.texture
        picture = None
        # packed into the file, or next to it
        if texture is not None and (content := bytes(texture.content) or self._files.get(_file_name(texture), b"")):
            picture = _file_name(texture) or texture.name or f"picture {texture.element_id}", content
            color, share = [1.0, 1.0, 1.0], 1.0
        opacity = float(pbr.opacity.value_vec4.x) if pbr.opacity.has_value else 1.0
        red, green, blue = (c * share if is_pbr else linear_from_srgb(c * share) for c in color)
        return Look(
            name=source.name or "material",
            color=(red, green, blue),
            opacity=opacity,
            metallic=float(pbr.metalness.value_vec4.x) if is_pbr and pbr.metalness.has_value else 0.0,
            roughness=float(pbr.roughness.value_vec4.x) if is_pbr and pbr.roughness.has_value else 0.6,
            picture=picture,
        )


def _held(elements: Any) -> Iterator[Any]:
    """The elements of a list of ufbx, with a reference counted for each."""
    for number in range(len(elements)):
        element = elements[number]
        _count_reference(element)
        yield element


def _file_name(texture: Any) -> str:
    """Path of a picture as written, the relative one where there are two."""
    return str(texture.relative_filename or texture.filename or "").replace("\\", "/")


def _matrix(columns: Any) -> Floats:
    out = np.eye(4)
    out[:3, :] = np.array([tuple(column) for column in columns], dtype=np.float64).T
    return out


def _corner_values(attribute: Any, count: int, width: int) -> Floats | None:
    """(count, width) values of each corner, or None if they are missing or too few."""
    if not attribute.exists:
        return None
    values = np.array(attribute.values, dtype=np.float64).reshape(-1, width)
    places = np.array(attribute.indices, dtype=np.int64).reshape(-1)
    if not count or len(places) != count or not len(values):
        return None
    if int(places.min()) < 0 or int(places.max()) >= len(values):
        return None
    return values[places]
