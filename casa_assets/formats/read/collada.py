"""COLLADA bundle -> RawModel: a part per primitive and instance, transforms baked, unit and up axis handed on."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import Format, Reference, Role
from casa_assets.formats.read.guarded_xml import (
    Element,
    children,
    count_of,
    find_path,
    floats_of,
    integers_of,
    local_name,
    number_of,
    parse_xml,
    text_of,
)
from casa_assets.formats.read.materials import Images, ImageUse, linear_from_srgb
from casa_assets.formats.read.raw_parts import (
    ReadPart,
    check_face_count,
    cut_whole,
    fan,
    merged_corners,
    raw_model,
    rgba,
    strip,
    transformed,
    turn,
)
from casa_assets.formats.read.text import Notes, UniqueNames, printable
from casa_assets.model import rejection_codes as codes
from casa_assets.model.asset.material import ColorSpace, Material
from casa_assets.model.source import Bundle, RawModel, Up

_BLACK = 0.02
SURFACES = ("triangles", "polylist", "polygons", "tristrips", "trifans")
# instance_node may share nodes, so a small file can ask for endless copies
MAX_NODES = 20_000
DEEPEST_NODE = 400
# Levels of nodes whose names are kept.
MAX_NAMES = 16


@dataclass
class Document:
    """A COLLADA tree and its elements by id."""

    root: Element
    by_id: dict[str, Element]

    def target(self, url: str | None) -> Element | None:
        """Element that `#id` names, or None."""
        return self.by_id.get((url or "").removeprefix("#"))


def open_dae(data: bytes, name: str) -> Document:
    """Tree of a COLLADA file. Raises Rejected as `parse_xml`, and WRONG_TYPE where it is no COLLADA."""
    root = parse_xml(data, name)
    if local_name(root) != "COLLADA":
        raise Rejected(
            codes.WRONG_TYPE, f"{name}: XML, but not COLLADA (its root is {printable(local_name(root), 30)})"
        )
    by_id: dict[str, Element] = {}
    for element in root.iter():
        key = element.get("id")
        if key:
            by_id.setdefault(key, element)
    return Document(root, by_id)


# A material and the texture coordinates symbol of its picture (empty where it has none).
Surface = tuple[Material, str]


@dataclass
class Surfaces:
    """Reads each material of one document once."""

    document: Document
    files: Mapping[str, bytes]
    images: Images
    notes: Notes
    names: UniqueNames = field(default_factory=UniqueNames)
    _read: dict[str, Surface] = field(default_factory=dict)

    def surface(self, url: str | None) -> Surface:
        """Surface of the material that `#id` refers to, or a grey one if it does not exist."""
        key = url or ""
        if key not in self._read:
            node = self.document.target(url)
            if node is None:
                if key:
                    message = f"material {printable(key, 40)!r} is not described; a grey one is used"
                    self.notes.add(codes.MATERIAL_MISSING, key, message)
                self._read[key] = Material(id=self.names.unique(key.removeprefix("#"), "material")), ""
            else:
                self._read[key] = self._surface(node)
        return self._read[key]

    def _surface(self, node: Element) -> Surface:
        name = node.get("name") or node.get("id") or "material"
        instance = find_path(node, "instance_effect")
        effect = self.document.target(instance.get("url") if instance is not None else None)
        profile = find_path(effect, "profile_COMMON")
        shader = next(children(find_path(profile, "technique"), "phong", "lambert", "blinn", "constant"), None)
        if profile is None or shader is None:
            self.notes.add(codes.MATERIAL_MISSING, name, "a material without a common effect; a grey one is used")
            return Material(id=self.names.unique(name, "material")), ""
        slot = self._color_slot(shader)
        file, texcoord = self._file(profile, find_path(slot, "texture"))
        transparent = find_path(shader, "transparent")
        look = ImageUse(ColorSpace.SRGB, "keep" if find_path(transparent, "texture") is not None else "drop")
        data = self.files.get(file)
        texture = None if data is None else self.images.texture(file, data, f"{name}_color", look)
        color = (1.0, 1.0, 1.0)
        if texture is None:
            values = floats_of(find_path(slot, "color"))
            is_color = len(values) >= 3 and bool(np.isfinite(values[:3]).all())
            if not is_color and find_path(slot, "color") is not None:
                self.notes.add(codes.BAD_VALUE, f"{name}/diffuse", "the colour is not three numbers; grey is used")
            r, g, b = (linear_from_srgb(float(v)) for v in values[:3]) if is_color else (0.8, 0.8, 0.8)
            color = (r, g, b)
        material = Material(
            id=self.names.unique(name, "material"),
            base_color=(*color, self._alpha(shader, transparent, name)),
            roughness=self._roughness(shader, name),
            base_color_texture=texture,
        )
        return material, texcoord if texture is not None else ""

    def _color_slot(self, shader: Element) -> Element | None:
        """Diffuse, or what glows where the diffuse colour is black (unlit exports)."""
        diffuse, emission = find_path(shader, "diffuse"), find_path(shader, "emission")
        if find_path(diffuse, "texture") is not None or emission is None:
            return diffuse
        glow = floats_of(find_path(emission, "color"))[:3]
        glows = find_path(emission, "texture") is not None or (len(glow) == 3 and bool((glow > _BLACK).any()))
        plain = floats_of(find_path(diffuse, "color"))[:3]
        if glows and (diffuse is None or (len(plain) == 3 and bool((plain <= _BLACK).all()))):
            message = "black surface that glows: its glow is its colour"
            self.notes.add(codes.EMISSIVE_AS_BASE, local_name(shader), message)
            return emission
        return diffuse

    def _alpha(self, shader: Element, transparent: Element | None, name: str) -> float:
        """Opacity in (0, 1]. Ref: COLLADA 1.4.1, "Determining Transparency (Opacity) in COLLADA"."""
        if transparent is None:
            return 1.0
        amount = floats_of(find_path(shader, "transparency", "float"))
        share = float(amount[0]) if len(amount) and np.isfinite(amount[0]) else 1.0
        color = floats_of(find_path(transparent, "color"))
        alpha = 1.0
        if len(color) == 4 and np.isfinite(color).all():
            if transparent.get("opaque", "A_ONE") == "RGB_ZERO":
                alpha = 1.0 - share * float(color[:3].mean())
            else:
                alpha = share * float(color[3])
        if alpha <= 0.0:
            self.notes.add(codes.FULLY_TRANSPARENT, name, "transparency would hide it; made opaque")
            return 1.0
        return min(1.0, alpha)

    def _roughness(self, shader: Element, name: str) -> float:
        """0..1 guessed from the Phong exponent. Ref: Blinn-Phong, exponent = 2 / roughness^4 - 2."""
        values = floats_of(find_path(shader, "shininess", "float"))
        if not len(values):
            return 0.6
        if not np.isfinite(values[0]) or values[0] < 0:
            self.notes.add(codes.BAD_VALUE, f"{name}/shininess", "shininess is not a number >= 0; ignored")
            return 0.6
        # many exporters write 0..1 where an exponent is meant; those say nothing
        exponent = float(values[0])
        return 0.6 if exponent <= 1.0 else float(min(0.9, max(0.2, (2.0 / (exponent + 2.0)) ** 0.25)))

    def _file(self, profile: Element, texture: Element | None) -> tuple[str, str]:
        """File name as written, and the texture coordinates symbol."""
        if texture is None:
            return "", ""
        params = {p.get("sid", ""): p for p in children(profile, "newparam")}
        params.update({p.get("sid", ""): p for p in children(find_path(profile, "technique"), "newparam")})
        key = texture.get("texture", "")
        sampler = find_path(params.get(key), "sampler2D")
        if sampler is not None:
            direct = find_path(sampler, "instance_image")
            if direct is not None:
                key = direct.get("url", "").removeprefix("#")
            else:
                surface = find_path(params.get(text_of(find_path(sampler, "source"))), "surface", "init_from")
                key = text_of(surface)
        return image_file(self.document.target(key)), texture.get("texcoord", "")


def image_file(image: Element | None) -> str:
    """File name of an <image>, as written; empty if it has no file name."""
    place = find_path(image, "init_from")
    inner = find_path(place, "ref")
    return text_of(inner if inner is not None else place)


@dataclass
class Primitive:
    """Triangles of one primitive, node frame not yet applied.

    Attributes:
        symbol: material symbol, to be bound by the instance.
        vertices: (V, 3); faces: (F, 3).
        normals: (V, 3) or None; colors: (V, 4) uint8 or None.
        uvs: TEXCOORD set number -> (V, 2), origin at the lower left.
    """

    symbol: str
    vertices: Floats
    faces: Ints
    normals: Floats | None = None
    colors: npt.NDArray[np.uint8] | None = None
    uvs: dict[int, Floats] = field(default_factory=dict)


@dataclass(frozen=True)
class _Input:
    semantic: str
    table: Floats
    offset: int
    number: int


def _triangle_count(primitive: Element) -> int:
    """Most triangles that a primitive can come to, from its own numbers."""
    kind = local_name(primitive)
    if kind == "polylist":
        return int(np.maximum(integers_of(find_path(primitive, "vcount")) - 2, 0).sum())
    stride = max((count_of(i, "offset", 0) for i in children(primitive, "input")), default=0) + 1
    corners = [len(integers_of(p)) // stride for p in children(primitive, "p")]
    return sum(corners) // 3 if kind == "triangles" else sum(max(0, n - 2) for n in corners)


def _piece(document: Document, primitive: Element, notes: Notes) -> Primitive | None:
    inputs = _inputs(document, primitive)
    position = next((i for i in inputs if i.semantic == "POSITION"), None)
    if position is None:
        return None
    stride = max(count_of(i, "offset", 0) for i in children(primitive, "input")) + 1
    corners, lengths = _corners(primitive, stride, notes)
    if not len(lengths):
        return None
    for one in inputs:
        column = corners[:, one.offset]
        if len(column) and not 0 <= int(column.min()) <= int(column.max()) < len(one.table):
            where = f"COLLADA <{local_name(primitive)}>: index {int(column.max())} of {len(one.table)}"
            raise Rejected(codes.OUT_OF_BOUNDS, f"{where} in {one.semantic}; export the file again")
    if dropped := int((lengths < 3).sum()):
        notes.add(codes.FACE_DROPPED, "polygons", f"{dropped} faces with fewer than three corners were dropped")
    starts = np.cumsum(lengths) - lengths
    picks, _, fanned = cut_whole(position.table[:, :3], corners[:, position.offset], starts, lengths, lengths >= 3)
    if fanned:
        notes.add(codes.POLYGON_FAN, "polygons", f"{fanned} concave or crossed faces were cut as fans")
    return _assembled(primitive.get("material", ""), inputs, corners[picks.reshape(-1)]) if len(picks) else None


def _assembled(symbol: str, inputs: list[_Input], corners: Ints) -> Primitive:
    first, faces = merged_corners([corners[:, o] for o in sorted({i.offset for i in inputs})])
    rows = corners[first]
    found = Primitive(symbol, np.zeros((0, 3)), faces)
    for one in inputs:
        values = one.table[rows[:, one.offset]]
        if one.semantic == "POSITION":
            found.vertices = values[:, :3]
        elif one.semantic == "NORMAL" and values.shape[1] >= 3:
            found.normals = values[:, :3]
        elif one.semantic == "TEXCOORD" and values.shape[1] >= 2:
            found.uvs.setdefault(one.number, values[:, :2])
        elif one.semantic == "COLOR" and values.shape[1] >= 3 and np.isfinite(values).all():
            found.colors = rgba(values[:, :4] * 255.0)
    return found


def _inputs(document: Document, primitive: Element) -> list[_Input]:
    """Inputs of a primitive; VERTEX is replaced by what its <vertices> holds."""
    out: list[_Input] = []
    for one in children(primitive, "input"):
        offset, number = count_of(one, "offset", 0), count_of(one, "set", 0)
        target = document.target(one.get("source"))
        if one.get("semantic") == "VERTEX":
            for inner in children(target, "input"):
                table = _table(document.target(inner.get("source")))
                out.append(_Input(inner.get("semantic", ""), table, offset, count_of(inner, "set", 0)))
        else:
            out.append(_Input(one.get("semantic", ""), _table(target), offset, number))
    wide = {"POSITION": 3, "NORMAL": 3, "TEXCOORD": 1, "COLOR": 3}
    return [i for i in out if i.semantic in wide and len(i.table) and i.table.shape[1] >= wide[i.semantic]]


def _table(source: Element | None) -> Floats:
    """(N, stride) rows of a <source>; no rows if it is missing or empty."""
    if source is None:
        return np.zeros((0, 3))
    flat = floats_of(find_path(source, "float_array"))
    accessor = find_path(source, "technique_common", "accessor")
    stride = max(1, count_of(accessor, "stride", 1)) if accessor is not None else 3
    start = count_of(accessor, "offset", 0) if accessor is not None else 0
    rows = flat[start:]
    return rows[: len(rows) // stride * stride].reshape(-1, stride)


def _corners(primitive: Element, stride: int, notes: Notes) -> tuple[Ints, Ints]:
    """(C, stride) index rows of all corners, and the number of corners of each polygon."""
    kind = local_name(primitive)
    lists = [integers_of(p) for p in children(primitive, "p")]
    if kind == "polygons":
        holed = [integers_of(find_path(h, "p")) for h in children(primitive, "ph")]
        if holed:
            notes.add(codes.FEATURE_IGNORED, "polygons", "holes in polygons are filled")
        lists += holed
    rows = [flat[: len(flat) // stride * stride].reshape(-1, stride) for flat in lists]
    if not rows:
        return np.zeros((0, stride), dtype=np.int64), np.zeros(0, dtype=np.int64)
    if kind == "tristrips":
        rows = [r[strip(len(r)).reshape(-1)] for r in rows]
    elif kind == "trifans":
        rows = [r[fan(len(r)).reshape(-1)] for r in rows]
    whole = np.concatenate(rows)
    if kind == "polygons":
        return whole, np.array([len(r) for r in rows], dtype=np.int64)
    if kind == "polylist":
        lengths = integers_of(find_path(primitive, "vcount"))
        fits = (lengths >= 0) & (np.cumsum(lengths) <= len(whole))
        if not fits.all():
            message = f"{int((~fits).sum())} polygons past the index list were dropped"
            notes.add(codes.FACE_DROPPED, "polylist", message)
            lengths = lengths[: int(np.argmin(fits))]
        return whole[: int(lengths.sum())], lengths
    return whole[: len(whole) // 3 * 3], np.full(len(whole) // 3, 3, dtype=np.int64)


@dataclass
class _Reader:
    document: Document
    surfaces: Surfaces
    limits: Mapping[str, float]
    notes: Notes
    name: str
    parts: list[ReadPart] = field(default_factory=list)
    faces: int = 0
    joints: int = 0
    _pieces: dict[Element, list[Primitive]] = field(default_factory=dict)

    def walk(self, roots: list[Element]) -> None:
        """Every geometry that the nodes place."""
        above: tuple[str, ...] = ()
        stack = [(node, np.eye(4), 0, above) for node in reversed(roots)]
        visited = 0
        while stack:
            node, parent, depth, above = stack.pop()
            visited += 1
            if visited > MAX_NODES or depth > DEEPEST_NODE:
                message = f"{self.name}: nodes are nested or copied without end; export the file again"
                raise Rejected(codes.BAD_SCENE_GRAPH, message)
            world = parent @ node_matrix(node, self.notes)
            label = node.get("name") or node.get("id") or ""
            names = (*above, label or f"node_{visited}") if len(above) < MAX_NAMES else above
            start = len(self.parts)
            for child in children(node, "instance_geometry"):
                self.geometry(self.document.target(child.get("url")), child, world, label)
            for child in children(node, "instance_controller"):
                self._controller(child, world, label)
            for part in self.parts[start:]:
                part.nodes = names
            inner = [(n, world, depth + 1, names) for n in children(node, "node")]
            for child in children(node, "instance_node"):
                target = self.document.target(child.get("url"))
                if target is not None and local_name(target) == "node":
                    inner.append((target, world, depth + 1, names))
            stack.extend(reversed(inner))

    def geometry(self, geometry: Element | None, instance: Element | None, world: Floats, label: str) -> None:
        """Add the parts of one placed geometry."""
        mesh = find_path(geometry, "mesh")
        if geometry is None or mesh is None:
            return
        if mesh not in self._pieces:
            # Counted before any triangle of a primitive is made.
            pieces, count = [], self.faces
            for element in children(mesh, *SURFACES):
                count += _triangle_count(element)
                check_face_count(count, self.limits, self.name)
                read = _piece(self.document, element, self.notes)
                pieces += [] if read is None else [read]
            self._pieces[mesh] = pieces
        bound = {b.get("symbol", ""): b for b in children(find_path(instance, "bind_material", "technique_common"))}
        name = label or geometry.get("name") or geometry.get("id") or "part"
        for primitive in self._pieces[mesh]:
            self.faces += len(primitive.faces)
            check_face_count(self.faces, self.limits, self.name)
            binding = bound.get(primitive.symbol)
            # Files without bind_material name the material itself as the symbol.
            url = binding.get("target") if binding is not None else primitive.symbol and f"#{primitive.symbol}"
            material, texcoord = self.surfaces.surface(url)
            vertices, normals, is_mirrored = transformed(primitive.vertices, primitive.normals, world)
            faces = primitive.faces[:, ::-1] if is_mirrored else primitive.faces
            uv = _chosen_uv(primitive, texcoord, binding)
            self.parts.append(ReadPart(name, vertices, faces, material, uv, normals, primitive.colors))
        if not self._pieces[mesh]:
            inputs = children(find_path(mesh, "vertices"), "input")
            sources = [i.get("source") for i in inputs if i.get("semantic") == "POSITION"]
            has_vertices = bool(sources) and len(_table(self.document.target(sources[0]))) > 0
            # the vertices are only counted, since a point cloud is no empty file
            bare = np.zeros((int(has_vertices), 3))
            self.parts.append(ReadPart(name, bare, np.zeros((0, 3), dtype=np.int64), Material(id="none")))

    def _controller(self, instance: Element, world: Floats, label: str) -> None:
        skin = find_path(self.document.target(instance.get("url")), "skin")
        if skin is None:
            return
        self.notes.add(codes.FEATURE_IGNORED, "skin", "a rigged mesh: read in its bind shape, without its rig")
        names = find_path(skin, "source", "Name_array")
        count = "" if names is None else names.get("count", "")
        self.joints = max(self.joints, int(count) if count.isdigit() else 1)
        shape = floats_of(find_path(skin, "bind_shape_matrix"))
        if len(shape) == 16 and np.isfinite(shape).all():
            world = world @ shape.reshape(4, 4)
        self.geometry(self.document.target(skin.get("source")), instance, world, label)


def _chosen_uv(primitive: Primitive, texcoord: str, binding: Element | None) -> Floats | None:
    """The set that the picture's texcoord symbol is bound to, else the first."""
    for binding_input in children(binding, "bind_vertex_input"):
        if binding_input.get("semantic") == texcoord and binding_input.get("input_set", "0").isdigit():
            wanted = int(binding_input.get("input_set", "0"))
            if wanted in primitive.uvs:
                return primitive.uvs[wanted]
    return primitive.uvs[min(primitive.uvs)] if primitive.uvs else None


def node_matrix(node: Element, notes: Notes) -> Floats:
    """(4, 4) parent_from_node: the product of the node's transforms in file order, file units."""
    out = np.eye(4)
    for child in children(node, "matrix", "translate", "rotate", "scale"):
        values = floats_of(child)
        wanted = {"matrix": 16, "translate": 3, "rotate": 4, "scale": 3}[local_name(child)]
        if len(values) != wanted or not np.isfinite(values).all():
            notes.add(codes.BAD_VALUE, f"node/{local_name(child)}", f"not {wanted} numbers; ignored")
            continue
        step = np.eye(4)
        if wanted == 16:
            step = values.reshape(4, 4)
        elif local_name(child) == "translate":
            step[:3, 3] = values
        elif local_name(child) == "scale":
            step[:3, :3] = np.diag(values)
        else:
            step[:3, :3] = turn(values[:3], math.radians(float(values[3])))
        out = out @ step
    return out


def _unit_and_up(document: Document, notes: Notes) -> tuple[float | None, Up]:
    """Metres per unit where the file states it, and the up axis (COLLADA: y where it is not stated)."""
    asset = find_path(document.root, "asset")
    unit = find_path(asset, "unit")
    ups = {"X_UP": Up.X, "Y_UP": Up.Y, "Z_UP": Up.Z}
    metres: float | None = None
    if unit is not None and unit.get("meter") is not None:
        metres = number_of(unit.get("meter", ""))
        if not 0 < metres < math.inf:
            text = printable(unit.get("meter", ""), 20)
            notes.add(codes.BAD_VALUE, "asset/unit", f"meter={text!r} is no length; ignored")
            metres = None
    return metres, ups.get(text_of(find_path(asset, "up_axis")).upper(), Up.Y)


def references(data: bytes, name: str) -> list[Reference]:
    """Pictures, as written. Raises Rejected as `open_dae`."""
    libraries = children(open_dae(data, name).root, "library_images")
    images = (image for library in libraries for image in children(library, "image"))
    return [Reference(image_file(image), Role.IMAGE) for image in images]


def load(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of a COLLADA file, vertices in file units and axes."""
    name = printable(bundle.main)
    document = open_dae(bundle.files[bundle.main], name)
    surfaces = Surfaces(document, bundle.files, Images(limits, notes), notes)
    reader = _Reader(document, surfaces, limits, notes, name)
    instance = find_path(document.root, "scene", "instance_visual_scene")
    scene = document.target(instance.get("url")) if instance is not None else None
    if scene is None:
        scene = find_path(document.root, "library_visual_scenes", "visual_scene")
    reader.walk(list(children(scene, "node")))
    if not any(len(r.faces) for r in reader.parts):
        geometries = list(children(find_path(document.root, "library_geometries"), "geometry"))
        if geometries and not reader.parts:
            message = "no mesh stands in the scene; all meshes of the file are used"
            notes.add(codes.MESH_OUTSIDE_SCENE, "scene", message)
            for geometry in geometries:
                reader.geometry(geometry, None, np.eye(4), "")
    if find_path(document.root, "library_animations") is not None:
        notes.add(codes.FEATURE_IGNORED, "animations", "animations are left out; the rest pose is read")
    metres, up = _unit_and_up(document, notes)
    return raw_model(reader.parts, notes, name, Format.DAE, metres, up, reader.joints)
