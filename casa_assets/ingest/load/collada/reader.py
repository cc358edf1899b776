"""COLLADA bundle -> RawModel: a part per primitive and instance, transforms baked, unit and up axis handed on."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from casa_assets.core.rotation import about_axis
from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.collada.guarded_xml import (
    Document,
    Element,
    children,
    find_path,
    floats_of,
    local_name,
    open_dae,
    text_of,
)
from casa_assets.ingest.load.collada.materials import Surface, Surfaces
from casa_assets.ingest.load.collada.mesh import Primitive, primitives_of, vertex_count
from casa_assets.ingest.load.formats import Format
from casa_assets.ingest.load.image import Images
from casa_assets.ingest.load.notes import Notes, printable
from casa_assets.ingest.load.raw_parts import ReadPart, check_face_count, raw_model, transformed
from casa_assets.model.asset.material import Material
from casa_assets.model.ingest.source import Bundle, RawModel, Up

Matrix = npt.NDArray[np.float64]

# instance_node may share nodes, so a small file can ask for endless copies
MAX_NODES = 20_000
DEEPEST_NODE = 400
# Names of so many levels of nodes are kept.
MAX_NAMES = 16
_UPS = {"X_UP": Up.X, "Y_UP": Up.Y, "Z_UP": Up.Z}


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

    def geometry(self, geometry: Element | None, instance: Element | None, world: Matrix, label: str) -> None:
        """Add the parts of one placed geometry."""
        mesh = find_path(geometry, "mesh")
        if geometry is None or mesh is None:
            return
        if mesh not in self._pieces:
            so_far = self.faces
            self._pieces[mesh] = primitives_of(
                self.document,
                mesh,
                self.notes,
                lambda count: check_face_count(so_far + count, self.limits, self.name),
            )
        bound = {b.get("symbol", ""): b for b in children(find_path(instance, "bind_material", "technique_common"))}
        name = label or geometry.get("name") or geometry.get("id") or "part"
        for primitive in self._pieces[mesh]:
            self.faces += len(primitive.faces)
            check_face_count(self.faces, self.limits, self.name)
            binding = bound.get(primitive.symbol)
            url = binding.get("target") if binding is not None else self._unbound(primitive.symbol)
            self.parts.append(_placed(primitive, self.surfaces.surface(url), binding, world, name))
        if not self._pieces[mesh]:
            bare = np.zeros((min(1, vertex_count(self.document, mesh)), 3))
            self.parts.append(ReadPart(name, bare, np.zeros((0, 3), dtype=np.int64), Material(id="none")))

    def _unbound(self, symbol: str) -> str | None:
        """Files without bind_material name the material itself as the symbol."""
        return f"#{symbol}" if symbol else None

    def _controller(self, instance: Element, world: Matrix, label: str) -> None:
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


def _placed(primitive: Primitive, surface: Surface, binding: Element | None, world: Matrix, name: str) -> ReadPart:
    vertices, normals, is_mirrored = transformed(primitive.vertices, primitive.normals, world)
    faces = primitive.faces[:, ::-1] if is_mirrored else primitive.faces
    uv = _chosen_uv(primitive, surface, binding)
    return ReadPart(name, vertices, faces, surface.material, uv, normals, primitive.colors)


def _chosen_uv(primitive: Primitive, surface: Surface, binding: Element | None) -> npt.NDArray[np.float64] | None:
    """The set that the picture's texcoord symbol is bound to, else the first."""
    for binding_input in children(binding, "bind_vertex_input"):
        if binding_input.get("semantic") == surface.texcoord and binding_input.get("input_set", "0").isdigit():
            wanted = int(binding_input.get("input_set", "0"))
            if wanted in primitive.uvs:
                return primitive.uvs[wanted]
    return primitive.uvs[min(primitive.uvs)] if primitive.uvs else None


def node_matrix(node: Element, notes: Notes) -> Matrix:
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
            step[:3, :3] = _turn(values[:3], math.radians(float(values[3])))
        out = out @ step
    return out


def _turn(axis: Matrix, angle: float) -> Matrix:
    """(3, 3) rotation about an axis of any length, angle in rad; none where the axis has no length."""
    length = float(np.linalg.norm(axis))
    if length < 1e-12:
        return np.eye(3)
    return about_axis(axis / length, angle)


def _roots(document: Document) -> list[Element]:
    instance = find_path(document.root, "scene", "instance_visual_scene")
    scene = document.target(instance.get("url")) if instance is not None else None
    if scene is None:
        scene = find_path(document.root, "library_visual_scenes", "visual_scene")
    return list(children(scene, "node"))


def _unit_and_up(document: Document, notes: Notes) -> tuple[float | None, Up]:
    """Metres per unit where the file states it, and the up axis (COLLADA: y where it is not stated)."""
    asset = find_path(document.root, "asset")
    unit = find_path(asset, "unit")
    metres: float | None = None
    if unit is not None and unit.get("meter") is not None:
        try:
            metres = float(unit.get("meter", ""))
        except ValueError:
            metres = None
        if metres is None or not math.isfinite(metres) or metres <= 0:
            text = printable(unit.get("meter", ""), 20)
            notes.add(codes.BAD_VALUE, "asset/unit", f"meter={text!r} is no length; ignored")
            metres = None
    return metres, _UPS.get(text_of(find_path(asset, "up_axis")).upper(), Up.Y)


def read_dae(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of a COLLADA file, vertices in file units and axes.

    Raises:
        Rejected: XML_ENTITY, XML_DEPTH, BAD_XML, TRUNCATED, WRONG_TYPE, OUT_OF_BOUNDS, BAD_SCENE_GRAPH, TOO_LARGE,
            NO_FACES, NO_GEOMETRY, NON_FINITE.
    """
    name = printable(bundle.main)
    document = open_dae(bundle.files[bundle.main], name)
    surfaces = Surfaces(document, bundle.files, Images(limits, notes), notes)
    reader = _Reader(document, surfaces, limits, notes, name)
    reader.walk(_roots(document))
    if not any(len(r.faces) for r in reader.parts):
        geometries = list(children(find_path(document.root, "library_geometries"), "geometry"))
        if geometries and not reader.parts:
            notes.add(
                codes.MESH_OUTSIDE_SCENE,
                "scene",
                "no mesh stands in the scene; all meshes of the file are used",
            )
            for geometry in geometries:
                reader.geometry(geometry, None, np.eye(4), "")
    if find_path(document.root, "library_animations") is not None:
        notes.add(codes.FEATURE_IGNORED, "animations", "animations are left out; the rest pose is read")
    metres, up = _unit_and_up(document, notes)
    return raw_model(reader.parts, notes, name, Format.DAE, metres, up, reader.joints)
