"""GLB and glTF 2.0 -> RawModel: one part per primitive and instance, node transforms baked."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import Format, Reference, Role
from casa_assets.formats.read.gltf_document import (
    Accessors,
    JsonObject,
    data_uri,
    dropped_extensions,
    open_document,
)
from casa_assets.formats.read.materials import Images, ImageUse, rgba_of_linear
from casa_assets.formats.read.raw_parts import (
    ReadPart,
    check_face_count,
    fan,
    raw_model,
    strip,
    transformed,
    used_vertices,
)
from casa_assets.formats.read.text import Notes, UniqueNames, printable
from casa_assets.model import rejection_codes as codes
from casa_assets.model.asset.material import ColorSpace, Material, Texture
from casa_assets.model.source import Bundle, RawModel, Up

_BLACK = 0.02


@dataclass(frozen=True)
class Mapping2D:
    """Texture coordinate set of a picture and its transform (KHR_texture_transform).

    Attributes:
        uv_set: n of TEXCOORD_n.
        offset, scale: in glTF texture space (origin at the upper left).
        rotation: rad, counter-clockwise.
    """

    uv_set: int = 0
    offset: tuple[float, float] = (0.0, 0.0)
    scale: tuple[float, float] = (1.0, 1.0)
    rotation: float = 0.0

    def apply(self, uv: Floats) -> Floats:
        """(V, 2) glTF texture coordinates -> ours, origin at the lower left; turned as three.js and Blender do."""
        c, s = math.cos(self.rotation), math.sin(self.rotation)
        u, v = uv[:, 0] * self.scale[0], uv[:, 1] * self.scale[1]
        moved_u = c * u + s * v + self.offset[0]
        moved_v = -s * u + c * v + self.offset[1]
        return np.column_stack((moved_u, 1.0 - moved_v))


# A material and the mapping of its pictures (None if they have no mapping).
Surface = tuple[Material, Mapping2D | None]


@dataclass
class Surfaces:
    """Reads each material of one document once."""

    document: JsonObject
    accessors: Accessors
    files: Mapping[str, bytes]
    images: Images
    notes: Notes
    names: UniqueNames = field(default_factory=UniqueNames)
    _read: dict[int | None, Surface] = field(default_factory=dict)

    def surface(self, index: int | None) -> Surface:
        """Surface of material `index`; the glTF default where None."""
        if index not in self._read:
            if index is None:
                # Ref: glTF 2.0, 3.9.6: the default material is white; here rough and not metallic
                material = Material(id=self.names.unique("default", "material"), base_color=(1.0, 1.0, 1.0, 1.0))
                self._read[index] = material, None
            else:
                self._read[index] = self._surface(self.document.pick(index, "materials"))
        return self._read[index]

    def _surface(self, node: JsonObject) -> Surface:
        pbr = node.child("pbrMetallicRoughness")
        old = node.child("extensions").child("KHR_materials_pbrSpecularGlossiness")
        if old.value:
            color_node, color = old.child("diffuseTexture"), old.numbers("diffuseFactor", (1.0, 1.0, 1.0, 1.0))
            metallic, roughness = 0.0, 1.0 - old.number("glossinessFactor", 1.0)
            rough_node = JsonObject({}, old.place)
        else:
            color_node, color = pbr.child("baseColorTexture"), pbr.numbers("baseColorFactor", (1.0, 1.0, 1.0, 1.0))
            metallic, roughness = pbr.number("metallicFactor", 1.0), pbr.number("roughnessFactor", 1.0)
            rough_node = pbr.child("metallicRoughnessTexture")
        if not pbr.value and not old.value:
            metallic, roughness = 0.0, 0.9
        color_node, color = self._emissive(node, color_node, color)
        alpha, color = self._alpha(node, color)
        name = node.text("name") or "material"
        base_picture = self._picture(color_node, f"{name}_color", ImageUse(ColorSpace.SRGB, alpha))
        rough_picture = self._picture(rough_node, f"{name}_rough", ImageUse(ColorSpace.RAW, "drop"))
        normal_picture = self._picture(node.child("normalTexture"), f"{name}_normal", ImageUse(ColorSpace.RAW, "drop"))
        mapping, base, rough, normal = self._one_mapping(node.place, base_picture, rough_picture, normal_picture)
        metallic, roughness, r, g, b, a = (min(1.0, max(0.0, value)) for value in (metallic, roughness, *color))
        material = Material(
            id=self.names.unique(name, "material"),
            base_color=(r, g, b, a),
            metallic=metallic,
            roughness=roughness,
            base_color_texture=base,
            metallic_roughness_texture=rough,
            normal_texture=normal,
        )
        return material, mapping

    def _emissive(
        self, node: JsonObject, picture: JsonObject, color: tuple[float, ...]
    ) -> tuple[JsonObject, tuple[float, ...]]:
        """A black surface whose picture glows is an unlit export: the picture is its colour."""
        glow = node.numbers("emissiveFactor", (0.0, 0.0, 0.0))
        is_black = max(color[:3]) <= _BLACK
        if not is_black or max(glow) <= _BLACK or (picture.value and not node.has("emissiveTexture")):
            return picture, color
        self.notes.add(codes.EMISSIVE_AS_BASE, node.place, "black surface that glows: its glow is its colour")
        return node.child("emissiveTexture"), (*glow, color[3])

    def _alpha(self, node: JsonObject, color: tuple[float, ...]) -> tuple[str | float, tuple[float, ...]]:
        mode = node.text("alphaMode") or "OPAQUE"
        if mode == "OPAQUE":
            return "drop", (*color[:3], 1.0)
        if color[3] <= 0.0:
            self.notes.add(codes.FULLY_TRANSPARENT, node.place, "alpha 0 would hide it; made opaque")
            return "drop", (*color[:3], 1.0)
        if mode == "MASK":
            return min(1.0, node.number("alphaCutoff", 0.5) / color[3]), (*color[:3], 1.0)
        return "keep", color

    def _picture(self, node: JsonObject, name: str, look: ImageUse) -> tuple[Texture, Mapping2D] | None:
        if not node.has("index"):
            return None
        texture = self.document.pick(node.count("index"), "textures")
        extensions = texture.child("extensions")
        # best first: images of an extension, then the one for programs that do not know it
        nodes = (extensions.child("EXT_texture_webp"), extensions.child("KHR_texture_basisu"), texture)
        sources = [node.count("source") for node in nodes if node.has("source")]
        if not sources:
            self.notes.add(codes.IMAGE_UNREADABLE, texture.place, "a texture without a readable image; left out")
        for source in sources:
            image = self.document.pick(source, "images")
            data = self._image_bytes(image)
            made = data and self.images.texture(f"image {source}", data, image.text("name") or name, look)
            if made:
                moved = node.child("extensions").child("KHR_texture_transform")
                offset, scale = moved.numbers("offset", (0.0, 0.0)), moved.numbers("scale", (1.0, 1.0))
                uv_set = moved.count("texCoord", node.count("texCoord", 0))
                mapping = Mapping2D(uv_set, (offset[0], offset[1]), (scale[0], scale[1]), moved.number("rotation", 0.0))
                return made, mapping
        return None

    def _image_bytes(self, image: JsonObject) -> bytes | None:
        uri = "" if image.has("bufferView") else image.text("uri")
        try:
            if image.has("bufferView"):
                return self.accessors.view_bytes(image.count("bufferView"))
            return data_uri(uri, image.place) if uri.startswith("data:") else self.files.get(uri)
        except Rejected as error:
            self.notes.add(codes.IMAGE_UNREADABLE, image.place, f"embedded image left out: {error.message}")
            return None

    def _one_mapping(
        self, place: str, *pictures: tuple[Texture, Mapping2D] | None
    ) -> tuple[Mapping2D | None, Texture | None, Texture | None, Texture | None]:
        """The leading picture's mapping; pictures laid out otherwise are left out with a note."""
        lead = next((p[1] for p in pictures if p is not None), None)
        for picture in pictures:
            if picture is not None and picture[1] != lead:
                self.notes.add(codes.UV_SET_MIXED, place, f"{picture[0].name} uses other texture coordinates; left out")
        base, rough, normal = (p[0] if p is not None and p[1] == lead else None for p in pictures)
        return lead, base, rough, normal


MAX_NAMES = 16
# A quaternion shorter than this states no rotation.
_SHORTEST = 1e-9
_INSTANCING = "EXT_mesh_gpu_instancing"
# Copies that are read of one file, a choice: more of them say nothing new of what the file holds.
MAX_COPIES = 256
# Columns of a copy that the file leaves out.
_STILL: tuple[tuple[str, tuple[float, ...]], ...] = (
    ("TRANSLATION", (0.0, 0.0, 0.0)),
    ("ROTATION", (0.0, 0.0, 0.0, 1.0)),
    ("SCALE", (1.0, 1.0, 1.0)),
)
_TRIANGLES, _STRIP, _FAN = 4, 5, 6


@dataclass(frozen=True)
class MeshInstance:
    """A mesh at its place.

    Attributes:
        node: index of the node, or None for a mesh that no node carries.
        mesh: index of the mesh.
        world_from_mesh: (4, 4), file units.
        names: of the nodes from the root down to this one; a node without a name is called by its number.
        copy_number: from 1, of a copy that a list of places makes; 0 without one.
    """

    node: int | None
    mesh: int
    world_from_mesh: Floats
    names: tuple[str, ...] = ()
    copy_number: int = 0


def local_matrix(node: JsonObject, notes: Notes) -> Floats:
    """(4, 4) parent_from_node, file units."""
    if node.has("matrix"):
        return np.array(node.numbers("matrix", (0.0,) * 16)).reshape(4, 4).T
    x, y, z, w = node.numbers("rotation", (0.0, 0.0, 0.0, 1.0))
    if x * x + y * y + z * z + w * w < _SHORTEST**2:
        notes.add(codes.BAD_ROTATION, node.place, "the rotation quaternion is zero; read as no rotation")
    translation, scale = node.numbers("translation", (0.0, 0.0, 0.0)), node.numbers("scale", (1.0, 1.0, 1.0))
    return placing_matrix(translation, (x, y, z, w), scale)


def placing_matrix(translation: Sequence[float], rotation: Sequence[float], scale: Sequence[float]) -> Floats:
    """(4, 4) parent_from_node of a translation, a quaternion x, y, z, w (of no length: no turn) and a scale."""
    x, y, z, w = rotation
    length = float(np.sqrt(x * x + y * y + z * z + w * w))
    if length < _SHORTEST:
        x, y, z, w, length = 0.0, 0.0, 0.0, 1.0, 1.0
    x, y, z, w = x / length, y / length, z / length, w / length
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    out = np.eye(4)
    out[:3, :3] = turn * np.array(scale)
    out[:3, 3] = translation
    return out


def _index(value: object, node: JsonObject) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise Rejected(codes.BAD_SCHEMA, f"glTF {node.place}: {str(value)[:20]!r} is no node index; export it again")
    return value


class _Reader:
    def __init__(self, bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> None:
        self._limits, self._notes, self._name = limits, notes, printable(bundle.main)
        self.document, binary = open_document(bundle.files[bundle.main], self._name)
        self._accessors = Accessors(self.document, binary, bundle.files, limits)
        self._surfaces = Surfaces(self.document, self._accessors, bundle.files, Images(limits, notes), notes)
        self._nodes = self.document.items("nodes")
        self._world_from_node: dict[int, Floats] = {}
        self._faces = 0
        self.placed, self.copies = self._with_copies(self._placed())

    def _placed(self) -> list[MeshInstance]:
        """Meshes of the shown scene; else those of all root nodes, else all meshes bare, each with a note."""
        nodes, document = self._nodes, self.document
        if document.array("scenes"):
            scene = document.pick(document.count("scene", 0), "scenes")
            placed = self._walk([_index(value, scene) for value in scene.array("nodes")])
            if placed or not document.array("meshes"):
                return placed
        message = "no mesh stands in the shown scene; all meshes of the file are used"
        self._notes.add(codes.MESH_OUTSIDE_SCENE, "scenes", message)
        children = {_index(child, node) for node in nodes for child in node.array("children")}
        placed = self._walk([i for i in range(len(nodes)) if i not in children])
        if placed:
            return placed
        if nodes and len(children) >= len(nodes):
            message = "glTF nodes: every node has a parent, so they form a cycle; export it again"
            raise Rejected(codes.BAD_SCENE_GRAPH, message)
        return [MeshInstance(None, i, np.eye(4)) for i in range(len(document.items("meshes")))]

    def _walk(self, roots: list[int]) -> list[MeshInstance]:
        """Placed meshes below some nodes, and the world matrix of every node there."""
        worlds = self._world_from_node = {}
        placed: list[MeshInstance] = []
        above: tuple[str, ...] = ()
        stack = [(root, np.eye(4), above) for root in reversed(roots)]
        meshes, count = len(self.document.array("meshes")), len(self._nodes)
        while stack:
            index, parent, above = stack.pop()
            if index >= count:
                raise Rejected(codes.OUT_OF_BOUNDS, f"glTF nodes: index {index} of {count}; export the file again")
            if index in worlds:
                message = f"glTF nodes/{index}: reached twice (a cycle or a shared child); export the file again"
                raise Rejected(codes.BAD_SCENE_GRAPH, message)
            node = self._nodes[index]
            with np.errstate(over="ignore", invalid="ignore"):
                worlds[index] = parent @ local_matrix(node, self._notes)
            # A chain of nodes may be as deep as the file is long: names of a few levels are kept.
            names = (*above, node.text("name") or f"node_{index}") if len(above) < MAX_NAMES else above
            if node.has("mesh"):
                mesh = node.count("mesh")
                if mesh >= meshes:
                    raise Rejected(codes.OUT_OF_BOUNDS, f"glTF {node.place}/mesh: {mesh} of {meshes}; export it again")
                placed.append(MeshInstance(index, mesh, worlds[index], names))
            stack.extend((_index(child, node), worlds[index], names) for child in reversed(node.array("children")))
        return placed

    def _with_copies(self, graph: list[MeshInstance]) -> tuple[list[MeshInstance], int]:
        """A placed mesh for each copy that a node asks for, counted from 1, and how many these are in all.

        Of a file no more than `MAX_COPIES` are read, with a note.
        """
        placed: list[MeshInstance] = []
        copies = left_out = 0
        for one in graph:
            node = JsonObject({}, "") if one.node is None else self.document.pick(one.node, "nodes")
            if not node.child("extensions").has(_INSTANCING):
                placed.append(one)
                continue
            attributes = node.child("extensions").child(_INSTANCING).child("attributes")
            columns = {
                name: self._accessors.floats(attributes.count(name), (len(still),))
                for name, still in _STILL
                if attributes.has(name)
            }
            count = min((len(rows) for rows in columns.values()), default=0)
            read = min(count, MAX_COPIES - copies)
            left_out += count - read
            copies += read
            for i in range(read):
                row = [columns[name][i].tolist() if name in columns else list(still) for name, still in _STILL]
                world = one.world_from_mesh @ placing_matrix(*row)
                placed.append(replace(one, world_from_mesh=world, copy_number=i + 1))
        if copies:
            message = f"{copies} copies of meshes ({_INSTANCING}) are read as things of their own"
            message += f"; {left_out} more are left out" if left_out else ""
            self._notes.add(codes.FEATURE_IGNORED, "nodes", message)
        return (placed, copies) if copies else (graph, 0)

    def joints(self) -> int:
        """Joints of the largest skin that moves a placed mesh."""
        nodes = [self.document.pick(one.node, "nodes") for one in self.placed if one.node is not None]
        skins = {node.count("skin") for node in nodes if node.has("skin")}
        return max((len(self.document.pick(skin, "skins").array("joints")) for skin in skins), default=0)

    def parts(self) -> list[ReadPart]:
        """All triangles of all placed meshes."""
        out: list[ReadPart] = []
        for placed in self.placed:
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
            self._notes.add(codes.FEATURE_IGNORED, primitive.place, "a primitive without POSITION; left out")
            return None
        self._accessors.unpack(primitive)
        if primitive.array("targets"):
            self._notes.add(codes.FEATURE_IGNORED, "meshes", "morph targets are left out; the rest shape is read")
        count = self._accessors.count(attributes.count("POSITION"))
        faces = self._triangles(primitive, count)
        self._faces += len(faces)
        check_face_count(self._faces, self._limits, self._name)
        vertices = self._accessors.floats(attributes.count("POSITION"), (3,))
        if len(faces) == 0:
            # the vertices are only counted, since a point cloud is no empty file
            return ReadPart(label, vertices[:1], faces, self._surfaces.surface(None)[0])
        used, faces = used_vertices(faces, len(vertices))
        vertices = vertices[used]
        index = primitive.count("material") if primitive.has("material") else None
        material, mapping = self._surfaces.surface(index)
        normals = self._attribute(attributes, "NORMAL", (3,), used)
        skinned = self._rest_vertices(placed, attributes, used, vertices)
        if skinned is not None:
            self._notes.add(codes.FEATURE_IGNORED, "skins", "a rigged mesh: read in its rest pose, without its rig")
            vertices, normals, is_mirrored = skinned, None, False
        else:
            vertices, normals, is_mirrored = transformed(vertices, normals, placed.world_from_mesh)
        uv = self._attribute(attributes, f"TEXCOORD_{mapping.uv_set if mapping else 0}", (2,), used)
        if uv is not None:
            with np.errstate(invalid="ignore", over="ignore"):
                uv = mapping.apply(uv) if mapping else np.column_stack((uv[:, 0], 1.0 - uv[:, 1]))
        colors = self._attribute(attributes, "COLOR_0", (3, 4), used)
        if colors is not None and not np.isfinite(colors).all():
            self._notes.add(codes.BAD_COLOR, attributes.place, "vertex colours hold NaN; left out")
            colors = None
        return ReadPart(
            name=label,
            vertices=vertices,
            faces=faces[:, ::-1] if is_mirrored else faces,
            material=material,
            uv=uv,
            normals=normals,
            colors=None if colors is None else rgba_of_linear(colors),  # glTF vertex colours are linear
        )

    def _attribute(self, attributes: JsonObject, key: str, widths: tuple[int, ...], used: Ints) -> Floats | None:
        if not attributes.has(key):
            return None
        values = self._accessors.floats(attributes.count(key), widths)
        if len(values) <= int(used[-1]):
            message = f"{key} has {len(values)} rows, fewer than the vertices; left out"
            self._notes.add(codes.BAD_VALUE, attributes.place, message)
            return None
        return values[used]

    def _triangles(self, primitive: JsonObject, count: int) -> Ints:
        """(F, 3) indices into the vertices of the primitive."""
        mode = primitive.count("mode", _TRIANGLES)
        if mode not in (_TRIANGLES, _STRIP, _FAN):
            self._notes.add(codes.FEATURE_IGNORED, primitive.place, "points or lines, not a surface; left out")
            return np.zeros((0, 3), dtype=np.int64)
        claimed = self._accessors.count(primitive.count("indices")) if primitive.has("indices") else count
        check_face_count(claimed // 3 if mode == _TRIANGLES else claimed, self._limits, self._name)
        if primitive.has("indices"):
            index = primitive.count("indices")
            flat = self._accessors.integers(index)
            if len(flat) and not 0 <= int(flat.min()) <= int(flat.max()) < count:
                message = f"glTF accessors/{index}: vertex {int(flat.max())} of {count}; export the file again"
                raise Rejected(codes.OUT_OF_BOUNDS, message)
        else:
            flat = np.arange(count, dtype=np.int64)
        if mode == _TRIANGLES:
            return flat[: len(flat) // 3 * 3].reshape(-1, 3)
        if mode == _FAN:
            return flat[fan(len(flat))]
        faces = flat[strip(len(flat))]
        # strips are stitched with repeated vertices, which are no faces
        is_face = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 0] != faces[:, 2])
        return np.asarray(faces[is_face])

    def _rest_vertices(
        self, placed: MeshInstance, attributes: JsonObject, used: Ints, vertices: Floats
    ) -> Floats | None:
        """(V, 3) vertices moved by their joints at rest, file frame; None if the mesh is not rigged, or not readably.

        Ref: glTF 2.0, 3.7.3: the node of a skinned mesh does not move it, its joints do.
        """
        if placed.node is None or not attributes.has("JOINTS_0") or not attributes.has("WEIGHTS_0"):
            return None
        node = self.document.pick(placed.node, "nodes")
        if not node.has("skin"):
            return None
        matrices = self._joint_matrices(self.document.pick(node.count("skin"), "skins"))
        joints = self._accessors.floats(attributes.count("JOINTS_0"), (4,))
        weights = self._accessors.floats(attributes.count("WEIGHTS_0"), (4,))
        if matrices is None or min(len(joints), len(weights)) <= int(used[-1]):
            return None
        joints, weights = joints[used].astype(np.int64), weights[used]
        total = weights.sum(axis=1)
        is_weighted = np.isfinite(weights).all() and not (total <= 1e-6).any()
        if not is_weighted or not 0 <= joints.min() <= joints.max() < len(matrices):
            return None
        weights = weights / total[:, None]
        out = np.zeros_like(vertices)
        for k in range(4):
            m = matrices[joints[:, k]]
            out += weights[:, k, None] * (np.einsum("vij,vj->vi", m[:, :3, :3], vertices) + m[:, :3, 3])
        return out

    def _joint_matrices(self, skin: JsonObject) -> Floats | None:
        """(J, 4, 4) file_from_bind of every joint, or None if a joint is outside the scene."""
        worlds_of = self._world_from_node
        joints = [j for j in skin.array("joints") if isinstance(j, int) and j in worlds_of]
        if not joints or len(joints) != len(skin.array("joints")):
            return None
        worlds = np.array([worlds_of[j] for j in joints])
        if skin.has("inverseBindMatrices"):
            inverse = self._accessors.floats(skin.count("inverseBindMatrices"), (16,))
            if len(inverse) < len(joints):
                return None
            worlds = worlds @ inverse[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)
        return worlds if np.isfinite(worlds).all() else None


def references(data: bytes, name: str) -> list[Reference]:
    """Buffers and pictures that are separate files. Raises Rejected as `open_document`."""
    document, _ = open_document(data, name)
    buffers = [Reference(b.text("uri"), Role.BUFFER) for b in document.items("buffers")]
    return buffers + [Reference(i.text("uri"), Role.IMAGE) for i in document.items("images")]


def load(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of a GLB or glTF: metres, y up, as the specification has it."""
    reader = _Reader(bundle, limits, notes)
    for extension in dropped_extensions(reader.document):
        notes.add(codes.FEATURE_IGNORED, printable(extension, 60), "a glTF extension that is not taken over; left out")
    if reader.document.array("animations"):
        notes.add(codes.FEATURE_IGNORED, "animations", "animations are left out; the rest pose is read")
    found = Format.GLB if bundle.files[bundle.main].startswith(b"glTF") else Format.GLTF
    joints = reader.joints()
    return raw_model(reader.parts(), notes, printable(bundle.main), found, 1.0, Up.Y, joints, reader.copies)
