"""VRML 2.0 and X3D -> RawModel: every shape at its place, those used several times as often as they are used."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from casa_assets.core.rotation import about_axis
from casa_assets.core.typing import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.diffuse import Look, Materials
from casa_assets.ingest.load.formats import Format
from casa_assets.ingest.load.gltf.container import data_uri
from casa_assets.ingest.load.image import linear_from_srgb
from casa_assets.ingest.load.notes import Notes, printable
from casa_assets.ingest.load.polygons import cut_polygons, part_of_corners
from casa_assets.ingest.load.raw_parts import ReadPart, check_face_count, raw_model, transformed
from casa_assets.ingest.load.vrml.faces import LEFT_OUT, Faces, faces_of
from casa_assets.ingest.load.vrml.node import DEEPEST, Node
from casa_assets.ingest.load.vrml.spellings import nodes_of_text, nodes_of_xml
from casa_assets.ingest.load.wavefront.materials import roughness_of_shininess
from casa_assets.model.asset.material import Material
from casa_assets.model.ingest.source import Bundle, RawModel, Up

# Nodes with those that are used several times counted as often; a scene that uses itself has no end.
MAX_NODES = 50_000
_NEVER = frozenset({"Script", "ProtoDeclare", "ExternProtoDeclare", "ProtoBody", "MetadataSet"})


def scene_nodes(data: bytes, name: str) -> list[Node]:
    """Nodes of a VRML or X3D file. Raises Rejected as its spelling does."""
    return nodes_of_text(data, name) if data.startswith(b"#VRML") else nodes_of_xml(data, name)


def picture_names(data: bytes, name: str) -> list[str]:
    """Files of pictures, as written."""
    found: dict[str, None] = {}
    for node, _ in _placed(scene_nodes(data, name), name, Notes()):
        for texture in _textures(node.first("Appearance")):
            found.update(dict.fromkeys(texture.texts("url")))
    return list(found)


def read_vrml(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of a VRML 2.0 or X3D file: metres (or the unit that X3D states), y up, as both formats have it.

    Raises:
        Rejected: SCENE_UNREADABLE, BAD_SCENE_GRAPH, TRUNCATED, UNSUPPORTED_VERSION, BAD_XML, XML_ENTITY, XML_DEPTH,
            TOO_LARGE, NO_GEOMETRY, NO_FACES, NON_FINITE.
    """
    name = printable(bundle.main)
    data = bundle.files[bundle.main]
    nodes = scene_nodes(data, name)
    reader = _Reader(bundle.files, limits, notes, name)
    parts = [part for shape, place in _placed(nodes, name, notes) for part in reader.parts(shape, place)]
    factor = next((node.number("conversionFactor", 1.0) for node in nodes if node.kind == "unit"), 1.0)
    metres = factor if math.isfinite(factor) and factor > 0.0 else 1.0
    found = Format.VRML if data.startswith(b"#VRML") else Format.X3D
    return raw_model(parts, notes, name, found, metres, Up.Y)


def _placed(nodes: list[Node], name: str, notes: Notes) -> Iterator[tuple[Node, Floats]]:
    """Shapes and the (4, 4) matrices that place them."""
    waiting = [(node, np.eye(4), 0) for node in reversed(nodes)]
    count = 0
    while waiting:
        node, parent, depth = waiting.pop()
        count += 1
        if count > MAX_NODES or depth > DEEPEST:
            message = f"{name}: nodes use each other without end, or are nested too deep; export it again"
            raise Rejected(codes.BAD_SCENE_GRAPH, message)
        if node.kind == "Shape":
            yield node, parent
            continue
        if node.kind in _NEVER or node.kind.endswith(("Sensor", "Interpolator")):
            continue
        _remark(node, notes)
        with np.errstate(all="ignore"):
            here = parent @ _matrix(node)
        waiting += [(child, here, depth + 1) for child in reversed(_shown(node))]


def _shown(node: Node) -> list[Node]:
    """Children that are shown: one of a switch, the finest of the levels of detail."""
    children = list(node.all())
    if node.kind == "LOD":
        return children[:1]
    if node.kind == "Switch":
        choice = int(node.number("whichChoice", -1.0))
        return children[choice : choice + 1] if choice >= 0 else []
    return children


def _remark(node: Node, notes: Notes) -> None:
    if node.kind in ("Inline", "ProtoInstance"):
        notes.add(codes.FEATURE_IGNORED, node.kind, "what other files or prototypes hold is left out; merge them first")
    elif node.kind in ("HAnimHumanoid", "Skin"):
        notes.add(codes.FEATURE_IGNORED, node.kind, "a rigged mesh: read as it was modelled, without its rig")


def _matrix(node: Node) -> Floats:
    """(4, 4) parent_from_node of a Transform. Ref: ISO 19775-1, 10.4.4."""
    out = np.eye(4)
    if node.kind not in ("Transform", "HAnimJoint", "HAnimHumanoid"):
        return out
    center, scale = _step(node.vector("center", (0.0, 0.0, 0.0))), np.eye(4)
    turn, slant = _turn(node.vector("rotation", (0, 0, 1, 0))), _turn(node.vector("scaleOrientation", (0, 0, 1, 0)))
    scale[:3, :3] = np.diag(node.vector("scale", (1.0, 1.0, 1.0)))
    moved = _step(node.vector("translation", (0.0, 0.0, 0.0)))
    back = _step(-node.vector("center", (0.0, 0.0, 0.0)))
    return np.asarray(moved @ center @ turn @ slant @ scale @ slant.T @ back)


def _step(offset: Floats) -> Floats:
    out = np.eye(4)
    out[:3, 3] = offset
    return out


def _turn(axis_angle: Floats) -> Floats:
    """(4, 4) rotation about an axis of any length, angle in rad; none where the axis has no length."""
    out = np.eye(4)
    length = float(np.linalg.norm(axis_angle[:3]))
    if 1e-12 < length < 1e12 and math.isfinite(float(axis_angle[3])):
        out[:3, :3] = about_axis(axis_angle[:3] / length, float(axis_angle[3]))
    return out


class _Reader:
    """Reads the shapes of one scene."""

    def __init__(self, files: Mapping[str, bytes], limits: Mapping[str, float], notes: Notes, name: str) -> None:
        self._files, self._limits, self._notes, self._name = files, limits, notes, name
        self._materials = Materials(limits, notes)
        self._triangles: dict[int, tuple[Faces, Ints] | None] = {}
        self._faces = 0

    def parts(self, shape: Node, place: Floats) -> Iterator[ReadPart]:
        """The part of a shape, where it has a surface."""
        geometry = next((n for n in shape.all() if not n.kind.endswith(("Appearance", "Metadata"))), None)
        if geometry is None:
            return
        if id(geometry) not in self._triangles:
            self._triangles[id(geometry)] = self._cut(geometry)
        found = self._triangles[id(geometry)]
        if found is None:
            return
        faces, triangles = found
        self._faces += len(triangles)
        check_face_count(self._faces, self._limits, self._name)
        points, normals, is_mirrored = transformed(faces.points, faces.normals, place)
        if is_mirrored:
            triangles = triangles[:, ::-1]
        appearance = shape.first("Appearance")
        material = self._material(appearance, faces.colors is not None)
        label = shape.name or geometry.name or "shape"
        uv = self._laid_out(appearance, faces.uv)
        yield part_of_corners(label, points, faces.corners, triangles, material, uv, normals, faces.colors)

    def _laid_out(self, appearance: Node | None, uv: Floats | None) -> Floats | None:
        """Texture coordinates, turned over where a picture is stored so (X3D 4.1, flipVertically)."""
        if appearance is not None and appearance.first("TextureTransform") is not None:
            self._notes.add(codes.FEATURE_IGNORED, "TextureTransform", "a transform of texture coordinates is left out")
        if uv is None or not any(t.flag("flipVertically", default=False) for t in _textures(appearance)[:1]):
            return uv
        return np.column_stack((uv[:, 0], 1.0 - uv[:, 1]))

    def _cut(self, geometry: Node) -> tuple[Faces, Ints] | None:
        """Faces of a geometry, and its triangles as places in their corners; None where it has no surface."""
        faces = faces_of(geometry)
        if faces is None:
            if geometry.kind in LEFT_OUT:
                self._notes.add(codes.FEATURE_IGNORED, geometry.kind, LEFT_OUT[geometry.kind])
            return None
        triangles, _ = cut_polygons(faces.points, faces.corners, faces.counts, self._limits, self._notes, self._name)
        return faces, triangles if geometry.flag("ccw", default=True) else triangles[:, ::-1]

    def _material(self, appearance: Node | None, is_colored: bool) -> Material:
        key = (id(appearance), is_colored)
        return self._materials.knows(key) or self._materials.material(key, self._look(appearance, is_colored))

    def _look(self, appearance: Node | None, is_colored: bool) -> Look:
        source = appearance.first("Material", "PhysicalMaterial", "UnlitMaterial") if appearance is not None else None
        name = (source and source.name) or (appearance and appearance.name) or "material"
        picture = next((found for t in _textures(appearance) if (found := self._picture(t)) is not None), None)
        if source is None:
            plain = (1.0, 1.0, 1.0) if is_colored or picture else (0.8, 0.8, 0.8)
            return Look(name, plain, picture=picture)
        is_physical = source.kind == "PhysicalMaterial"
        entry = {"PhysicalMaterial": "baseColor", "UnlitMaterial": "emissiveColor"}.get(source.kind, "diffuseColor")
        given = source.vector(entry, (1.0, 1.0, 1.0) if is_physical else (0.8, 0.8, 0.8))
        red, green, blue = (float(c) if is_physical else linear_from_srgb(float(c)) for c in given)
        shine = float(np.clip(source.number("shininess", 0.2), 0.0, 1.0))
        return Look(
            name=name,
            color=(1.0, 1.0, 1.0) if is_colored or picture else (red, green, blue),
            opacity=1.0 - source.number("transparency", 0.0),
            metallic=source.number("metallic", 1.0) if is_physical else 0.0,
            roughness=source.number("roughness", 1.0) if is_physical else roughness_of_shininess(128.0 * shine),
            picture=picture,
        )

    def _picture(self, texture: Node) -> tuple[str, bytes] | None:
        for url in texture.texts("url"):
            data = self._files.get(url)
            if url.startswith("data:"):
                try:
                    data = data_uri(url, "url")
                except Rejected as error:
                    self._notes.add(codes.IMAGE_UNREADABLE, "url", f"embedded image left out: {error.message}")
            if data:
                return url[:200], data
        return None


def _textures(appearance: Node | None) -> list[Node]:
    """Colour pictures of an appearance, the leading one first."""
    if appearance is None:
        return []
    found = [n for n in appearance.all() if n.kind == "ImageTexture"]
    for holder in appearance.all():
        if holder.kind == "MultiTexture" or holder.kind.endswith("Material"):
            inner = [n for n in holder.all() if n.kind == "ImageTexture"]
            role = [n for n in inner if n.fields.get("containerField", "") in ("baseTexture", "diffuseTexture")]
            found += role or inner[:1]
    return found
