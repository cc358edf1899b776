"""GLB or glTF bundle -> RawModel: one part per primitive and instance, node transforms baked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.core.typing import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.formats import Format
from casa_assets.ingest.load.gltf.accessor import Accessors
from casa_assets.ingest.load.gltf.container import dropped_extensions, open_document
from casa_assets.ingest.load.gltf.draco import unpack
from casa_assets.ingest.load.gltf.graph import MeshInstance, SceneGraph, read_graph
from casa_assets.ingest.load.gltf.instancing import with_instances
from casa_assets.ingest.load.gltf.skin import joint_count, rest_vertices
from casa_assets.ingest.load.gltf.surface import Surfaces
from casa_assets.ingest.load.gltf.tree import JsonObject
from casa_assets.ingest.load.image import Images, srgb_bytes_from_linear
from casa_assets.ingest.load.notes import Notes, printable
from casa_assets.ingest.load.raw_parts import ReadPart, check_face_count, raw_model, transformed, used_vertices
from casa_assets.model.ingest.source import Bundle, RawModel, Up

_TRIANGLES, _STRIP, _FAN = 4, 5, 6


@dataclass
class _Reader:
    document: JsonObject
    accessors: Accessors
    surfaces: Surfaces
    graph: SceneGraph
    limits: Mapping[str, float]
    notes: Notes
    name: str
    faces: int = 0

    def parts(self) -> list[ReadPart]:
        """All triangles of all placed meshes."""
        out: list[ReadPart] = []
        for placed in self.graph.placed:
            mesh = self.document.pick(placed.mesh, "meshes")
            label = mesh.text("name")
            if placed.node is not None:
                label = self.document.pick(placed.node, "nodes").text("name") or label
            for primitive in mesh.items("primitives"):
                part = self._primitive(primitive, placed, label or f"mesh_{placed.mesh}")
                if part is not None:
                    part.nodes, part.copy_number = placed.names, placed.copy_number
                    out.append(part)
        return out

    def _primitive(self, primitive: JsonObject, placed: MeshInstance, label: str) -> ReadPart | None:
        attributes = primitive.child("attributes")
        if not attributes.has("POSITION"):
            self.notes.add(codes.FEATURE_IGNORED, primitive.place, "a primitive without POSITION; left out")
            return None
        unpack(primitive, self.accessors)
        self._remark(primitive)
        count = self.accessors.count(attributes.count("POSITION"))
        faces = self._triangles(primitive, count)
        self.faces += len(faces)
        check_face_count(self.faces, self.limits, self.name)
        vertices = self.accessors.floats(attributes.count("POSITION"), (3,))
        if len(faces) == 0:
            # the vertices are only counted, for telling a point cloud from an empty file
            return ReadPart(label, vertices[:1], faces, self.surfaces.surface(None).material)
        return self._baked(primitive, placed, label, faces)

    def _baked(self, primitive: JsonObject, placed: MeshInstance, label: str, faces: Ints) -> ReadPart:
        attributes = primitive.child("attributes")
        vertices = self.accessors.floats(attributes.count("POSITION"), (3,))
        used, faces = used_vertices(faces, len(vertices))
        vertices = vertices[used]
        index = primitive.count("material") if primitive.has("material") else None
        surface = self.surfaces.surface(index)
        normals = self._attribute(attributes, "NORMAL", (3,), used)
        vertices, normals, is_mirrored = self._placed(placed, attributes, used, vertices, normals)
        uv = self._attribute(attributes, f"TEXCOORD_{surface.mapping.uv_set if surface.mapping else 0}", (2,), used)
        if uv is not None:
            with np.errstate(invalid="ignore", over="ignore"):
                uv = surface.mapping.apply(uv) if surface.mapping else np.column_stack((uv[:, 0], 1.0 - uv[:, 1]))
        return ReadPart(
            name=label,
            vertices=vertices,
            faces=faces[:, ::-1] if is_mirrored else faces,
            material=surface.material,
            uv=uv,
            normals=normals,
            colors=self._colors(attributes, used),
        )

    def _placed(
        self, placed: MeshInstance, attributes: JsonObject, used: Ints, vertices: Floats, normals: Floats | None
    ) -> tuple[Floats, Floats | None, bool]:
        """Vertices and normals in the frame of the file, and whether the transform mirrors."""
        skinned = rest_vertices(self.document, self.accessors, self.graph, placed, attributes, used, vertices)
        if skinned is not None:
            self.notes.add(codes.FEATURE_IGNORED, "skins", "a rigged mesh: read in its rest pose, without its rig")
            return skinned, None, False
        return transformed(vertices, normals, placed.world_from_mesh)

    def _attribute(self, attributes: JsonObject, key: str, widths: tuple[int, ...], used: Ints) -> Floats | None:
        if not attributes.has(key):
            return None
        values = self.accessors.floats(attributes.count(key), widths)
        if len(values) <= int(used[-1]):
            message = f"{key} has {len(values)} rows, fewer than the vertices; left out"
            self.notes.add(codes.BAD_VALUE, attributes.place, message)
            return None
        return values[used]

    def _colors(self, attributes: JsonObject, used: Ints) -> npt.NDArray[np.uint8] | None:
        """(V, 4) sRGB bytes; glTF vertex colours are linear."""
        values = self._attribute(attributes, "COLOR_0", (3, 4), used)
        if values is None:
            return None
        if not np.isfinite(values).all():
            self.notes.add(codes.BAD_COLOR, attributes.place, "vertex colours hold NaN; left out")
            return None
        out = np.full((len(values), 4), 255, dtype=np.uint8)
        out[:, :3] = srgb_bytes_from_linear(values[:, :3])
        if values.shape[1] == 4:
            out[:, 3] = np.rint(np.clip(values[:, 3], 0.0, 1.0) * 255.0).astype(np.uint8)
        return out

    def _triangles(self, primitive: JsonObject, count: int) -> Ints:
        """(F, 3) indices into the vertices of the primitive."""
        mode = primitive.count("mode", _TRIANGLES)
        if mode not in (_TRIANGLES, _STRIP, _FAN):
            self.notes.add(codes.FEATURE_IGNORED, primitive.place, "points or lines, not a surface; left out")
            return np.zeros((0, 3), dtype=np.int64)
        check_face_count(self._claimed_faces(primitive, count, mode), self.limits, self.name)
        if primitive.has("indices"):
            index = primitive.count("indices")
            flat = self.accessors.integers(index)
            if len(flat) and not 0 <= int(flat.min()) <= int(flat.max()) < count:
                message = f"glTF accessors/{index}: vertex {int(flat.max())} of {count}; export the file again"
                raise Rejected(codes.OUT_OF_BOUNDS, message)
        else:
            flat = np.arange(count, dtype=np.int64)
        return _from_mode(flat, mode)

    def _claimed_faces(self, primitive: JsonObject, count: int, mode: int) -> int:
        indices = self.accessors.count(primitive.count("indices")) if primitive.has("indices") else count
        return indices // 3 if mode == _TRIANGLES else indices

    def _remark(self, primitive: JsonObject) -> None:
        if primitive.array("targets"):
            self.notes.add(codes.FEATURE_IGNORED, "meshes", "morph targets are left out; the rest shape is read")


def _from_mode(flat: Ints, mode: int) -> Ints:
    if mode == _TRIANGLES:
        return flat[: len(flat) // 3 * 3].reshape(-1, 3)
    if len(flat) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    if mode == _FAN:
        return np.column_stack((np.full(len(flat) - 2, flat[0]), flat[1:-1], flat[2:]))
    faces = np.column_stack((flat[:-2], flat[1:-1], flat[2:]))
    faces[1::2] = faces[1::2][:, [1, 0, 2]]
    # strips are stitched with repeated vertices, which are no faces
    real = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 0] != faces[:, 2])
    out: Ints = faces[real]
    return out


def read_gltf(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of a GLB or glTF: metres, y up, as the specification has it.

    Raises:
        Rejected: SRC codes of container, scene graph, accessors and geometry.
    """
    name = printable(bundle.main)
    data = bundle.files[bundle.main]
    document, binary = open_document(data, name)
    accessors = Accessors(document, binary, bundle.files, limits)
    surfaces = Surfaces(document, accessors, bundle.files, Images(limits, notes), notes)
    graph, instances = with_instances(document, accessors, read_graph(document, notes), notes)
    for extension in dropped_extensions(document):
        notes.add(codes.FEATURE_IGNORED, printable(extension, 60), "a glTF extension that is not taken over; left out")
    if document.array("animations"):
        notes.add(codes.FEATURE_IGNORED, "animations", "animations are left out; the rest pose is read")
    reader = _Reader(document, accessors, surfaces, graph, limits, notes, name)
    found = Format.GLB if data.startswith(b"glTF") else Format.GLTF
    joints = joint_count(document, graph)
    return raw_model(reader.parts(), notes, name, found, 1.0, Up.Y, joints, instances)
