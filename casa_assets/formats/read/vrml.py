"""VRML 2.0 and X3D, two spellings of one tree of nodes -> RawModel: every shape at its place, as often as it is used.

Nothing is run, and no file or address that they name is opened.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import Format, Reference, Role
from casa_assets.formats.read.gltf_document import data_uri
from casa_assets.formats.read.guarded_xml import Element, local_name, number_of, parse_xml
from casa_assets.formats.read.materials import Look, Materials, linear_from_srgb, roughness_of_shininess
from casa_assets.formats.read.raw_parts import (
    Bytes,
    ReadPart,
    check_face_count,
    cut_polygons,
    fan,
    part_of_corners,
    raw_model,
    rgba,
    strip,
    transformed,
    turn,
)
from casa_assets.formats.read.text import Notes, decode, printable
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import Bundle, RawModel, Up

# Scenes are a dozen deep. Text is read by functions that call each other, four for a level, and Python ends at 1000.
DEEPEST = 150
# Sides of a round shape; a choice.
SIDES = 32
SOLIDS = ("Box", "Cylinder", "Cone", "Sphere")
LEFT_OUT: Mapping[str, str] = {
    "Extrusion": "an extrusion without a mesh; convert it to one",
    "ElevationGrid": "a relief without a mesh; convert it to one",
    "Text": "text is left out",
    "IndexedLineSet": "lines are left out",
    "LineSet": "lines are left out",
    "PointSet": "points are left out",
    "NurbsPatchSurface": "NURBS are left out; convert them to meshes",
}


@dataclass(eq=False)
class Node:
    """A node of the scene.

    Attributes:
        kind: such as `IndexedFaceSet`.
        name: that others use it by (DEF), or empty.
        fields: name -> text of its value, numbers and strings as written.
        nodes: name of the field -> nodes in it; of X3D, whose fields may go unnamed, all under `children`.
    """

    kind: str
    name: str = ""
    fields: dict[str, str] = field(default_factory=dict)
    nodes: dict[str, list[Node]] = field(default_factory=dict)

    def all(self) -> Iterator[Node]:
        """Nodes in any field, in order."""
        for found in self.nodes.values():
            yield from found

    def first(self, *kinds: str) -> Node | None:
        """First node of one of these kinds in any field, or None."""
        return next((node for node in self.all() if node.kind in kinds), None)

    def flag(self, name: str, default: bool) -> bool:
        """Truth value; the default where it is not written."""
        return self.fields.get(name, str(default)).strip().lower() == "true"

    def floats(self, name: str) -> Floats:
        """(N,) numbers; what is not a number becomes NaN."""
        words = self.fields.get(name, "").replace(",", " ").split()
        try:
            return np.array(words, dtype=np.float64)
        except ValueError:
            return np.array([number_of(word) for word in words])

    def integers(self, name: str) -> Ints:
        """(N,) whole numbers; other words, and numbers of 2**31 or more, become -2, which is no point's index."""
        values = self.floats(name)
        is_whole = np.isfinite(values) & (np.abs(values) < 2**31)
        return np.where(is_whole, np.where(is_whole, values, 0.0), -2.0).astype(np.int64)

    def vector(self, name: str, default: tuple[float, ...]) -> Floats:
        """Numbers, as many as the default has, or the default."""
        values = self.floats(name)
        return values if len(values) == len(default) and np.isfinite(values).all() else np.array(default)

    def number(self, name: str, default: float) -> float:
        """One number, or the default."""
        return float(self.vector(name, (default,))[0])

    def texts(self, name: str) -> list[str]:
        """Strings of a list of strings, quoted or bare."""
        text = self.fields.get(name, "").strip()
        if '"' not in text:
            return [text] if text else []
        return [word for word in text.split('"')[1::2] if word]


@dataclass(frozen=True)
class Faces:
    """Polygons.

    Attributes:
        points: (P, 3). corners: (C,) point of each corner. counts: (F,) corners of each polygon.
        uv, normals, colors: (C, 2), (C, 3), (C, 4) uint8 sRGB of each corner, or None.
    """

    points: Floats
    corners: Ints
    counts: Ints
    uv: Floats | None = None
    normals: Floats | None = None
    colors: Bytes | None = None


def faces_of(node: Node) -> Faces | None:
    """Polygons of a geometry node; None if it is not a surface that is read."""
    if node.kind == "IndexedFaceSet":
        return _indexed(node, *_rows(node.integers("coordIndex")))
    kind = node.kind.removeprefix("Indexed")
    if kind in _SETS:
        index = np.arange(len(_points(node))) if kind == node.kind else node.integers("index")
        size, triangles, lengths = _SETS[kind]
        if triangles is not None:
            runs = [run[triangles(len(run))].reshape(-1) for run in _runs(node, index, lengths)]
            index = np.concatenate([np.zeros(0, dtype=np.int64), *runs])
        corners = index[: len(index) // size * size]
        counts = np.full(len(corners) // size, size)
        return _indexed(node, corners, counts, np.arange(len(corners)), is_plain=True)
    return _solid(node) if node.kind in SOLIDS else None


def _points(node: Node) -> Floats:
    found = node.first("Coordinate", "CoordinateDouble")
    flat = found.floats("point") if found is not None else np.zeros(0)
    return flat[: len(flat) // 3 * 3].reshape(-1, 3)


def _rows(index: Ints) -> tuple[Ints, Ints, Ints]:
    """Corners, corners of each polygon, and the places of the corners among numbers that -1 parts."""
    places = np.flatnonzero(index != -1)
    owner = np.cumsum(index == -1)[places]
    counts = np.bincount(owner, minlength=int(owner[-1]) + 1) if len(owner) else np.zeros(0, dtype=np.int64)
    return index[places], counts, places


def _indexed(node: Node, corners: Ints, counts: Ints, places: Ints, is_plain: bool = False) -> Faces:
    """Polygons with the texture coordinates, normals and colours that the node gives for their corners.

    Args:
        places: (C,) position of each corner among the numbers of `coordIndex`. is_plain: there is no other index.
    """

    def spread(kind: tuple[str, ...], field: str, width: int, index: str, per: str) -> Floats | None:
        found = node.first(*kind) or (node.first("MultiTextureCoordinate") or Node("")).first(*kind)
        if found is None:
            return None
        flat = found.floats(field)
        values = flat[: len(flat) // width * width].reshape(-1, width)
        wanted = np.zeros(0, dtype=np.int64) if is_plain else node.integers(index)
        if per and not node.flag(per, default=True):
            # One value for each polygon, in their order or by the numbers given.
            owner = np.repeat(np.arange(len(counts)), counts)
            given = wanted[wanted != -1]
            chosen = given[owner] if len(given) > int(owner.max(initial=-1)) else owner
        elif len(wanted):
            if len(wanted) <= int(places.max(initial=-1)):
                return None
            chosen = wanted[places]
        else:
            chosen = corners
        is_good = len(chosen) and 0 <= int(chosen.min()) <= int(chosen.max()) < len(values)
        return values[chosen] if is_good else None

    shades = spread(("Color",), "color", 3, "colorIndex", "colorPerVertex")
    if shades is None:
        shades = spread(("ColorRGBA",), "color", 4, "colorIndex", "colorPerVertex")
    return Faces(
        points=_points(node),
        corners=corners,
        counts=counts,
        uv=spread(("TextureCoordinate",), "point", 2, "texCoordIndex", ""),
        normals=spread(("Normal",), "vector", 3, "normalIndex", "normalPerVertex"),
        colors=None if shades is None else rgba(np.nan_to_num(shades) * 255.0),
    )


def _runs(node: Node, index: Ints, field: str) -> list[Ints]:
    """Runs of corners: parted by -1, or of the lengths that a field has."""
    if node.kind.startswith("Indexed"):
        corners, counts, _ = _rows(index)
        return np.split(corners, np.cumsum(counts)[:-1]) if len(counts) else []
    ends = np.cumsum(np.clip(node.integers(field), 0, len(index)))
    return list(np.split(index, ends[ends <= len(index)]))


# Kind of a set of triangles or quads -> corners of a polygon; of runs: their triangles, and the field of their lengths.
_SETS: Mapping[str, tuple[int, Callable[[int], Ints] | None, str]] = {
    "TriangleSet": (3, None, ""),
    "QuadSet": (4, None, ""),
    "TriangleStripSet": (3, strip, "stripCount"),
    "TriangleFanSet": (3, fan, "fanCount"),
}


def _solid(node: Node) -> Faces:
    """A box, or a profile of (radius, height), from the top down, turned about y; closed where a radius is 0."""
    if node.kind == "Box":
        size = node.vector("size", (2.0, 2.0, 2.0))
        points = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
        quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        return Faces(points, np.array(quads).reshape(-1), np.full(6, 4))
    is_cone = node.kind == "Cone"
    r, h = node.number("bottomRadius" if is_cone else "radius", 1.0), node.number("height", 2.0) / 2
    if node.kind == "Sphere":
        steps = [math.pi * k / (SIDES // 2) for k in range(SIDES // 2 + 1)]
        profile = [(r * math.sin(a), r * math.cos(a)) for a in steps]
    else:
        top = [(0.0, h)] if is_cone or node.flag("top", default=True) else []
        bottom = [(0.0, -h)] if node.flag("bottom", default=True) else []
        profile = [*top, *([] if is_cone else [(r, h)]), (r, -h), *bottom]
    angle = np.arange(SIDES) * (2.0 * math.pi / SIDES)
    rings = [np.column_stack((r * np.sin(angle), np.full(SIDES, h), r * np.cos(angle))) for r, h in profile]
    quads = []
    for ring in range(len(profile) - 1):
        for side in range(SIDES):
            a, b = ring * SIDES + side, ring * SIDES + (side + 1) % SIDES
            quads.append((a, a + SIDES, b + SIDES, b))
    return Faces(np.concatenate(rings), np.array(quads).reshape(-1), np.full(len(quads), 4))


_WORD = re.compile(r'"(?:[^"\\]|\\.)*"|[\[\]{}]|[^\s,"\[\]{}#]+|#[^\n]*')
_NUMBER = re.compile(r"[-+]?(\d|\.\d|inf|nan)", re.IGNORECASE)
# The document type of X3D names a file of rules and holds none itself; one with its own rules is refused.
_PLAIN_DOCTYPE = re.compile(rb"<!DOCTYPE\s+X3D\s+(PUBLIC\s+(\"[^\"<>&\[\]]*\"\s*){2}|SYSTEM\s+\"[^\"<>&\[\]]*\"\s*)>")
# Nodes with those that are used several times counted as often; a scene that uses itself has no end.
MAX_NODES = 50_000
_NEVER = frozenset({"Script", "ProtoDeclare", "ExternProtoDeclare", "ProtoBody", "MetadataSet"})


def nodes_of_xml(data: bytes, name: str) -> list[Node]:
    """Nodes of an X3D scene, and `unit` nodes of its head. Raises Rejected."""
    plain = _PLAIN_DOCTYPE.sub(b"", data[:4096], count=1) + data[4096:]
    root = parse_xml(plain, name)
    scene = next((child for child in root if local_name(child) == "Scene"), None)
    if scene is None:
        raise Rejected(codes.SCENE_UNREADABLE, f"{name}: X3D without a Scene; export it again")
    known: dict[str, Node] = {}
    top = Node("Scene")
    stack: list[tuple[Iterator[Element], Node]] = [(iter(scene), top)]
    while stack:
        element = next(stack[-1][0], None)
        if element is None:
            stack.pop()
            continue
        siblings = stack[-1][1].nodes.setdefault("children", [])
        used = element.get("USE")
        if used is not None:
            siblings += [known[used]] if used in known else []
            continue
        node = Node(local_name(element), element.get("DEF", ""), {str(k): str(v) for k, v in element.attrib.items()})
        siblings.append(node)
        if node.name:
            known[node.name] = node
        if len(stack) > DEEPEST:
            raise _too_deep(name)
        stack.append((iter(element), node))
    units = [e for e in root.iter() if local_name(e) == "unit" and e.get("category") == "length"]
    nodes = [Node("unit", "", {str(k): str(v) for k, v in e.attrib.items()}) for e in units]
    return [*top.nodes.get("children", []), *nodes]


def nodes_of_text(data: bytes, name: str) -> list[Node]:
    """Nodes of a VRML 2.0 scene. Raises Rejected UNSUPPORTED_VERSION, TRUNCATED, SCENE_UNREADABLE."""
    text = decode(data)
    if not re.match(r"#VRML V2\.0", text):
        message = f"{name}: VRML {printable(text[6:12], 10)!r}; only 2.0 (VRML97) can be read; convert it to GLB"
        raise Rejected(codes.UNSUPPORTED_VERSION, message)
    return _Words(text, name).nodes()


class _Words:
    def __init__(self, text: str, name: str) -> None:
        self._words = (w.group() for w in _WORD.finditer(text))
        self._next = ""
        self._name = name
        self._known: dict[str, Node] = {}
        self._protos: set[str] = set()
        self._take()

    def nodes(self) -> list[Node]:
        found: list[Node] = []
        while self._next:
            if self._next in ("]", "}"):
                self._take()  # one too many; programs read on, too
                continue
            node = self._statement(0)
            if node is not None:
                found.append(node)
        return found

    def _take(self) -> str:
        taken = self._next
        self._next = next((word for word in self._words if not word.startswith("#")), "")
        return taken

    def _statement(self, depth: int) -> Node | None:
        """A node, or a name for one; routes and prototypes are read over."""
        word = self._take()
        if word == "DEF":
            name = self._take()
            return self._node(self._take(), depth, name)
        if word == "USE":
            return self._known.get(self._take())
        if word == "ROUTE":
            for _ in range(3):
                self._take()
            return None
        if word in ("PROTO", "EXTERNPROTO"):
            self._protos.add(self._take())
            self._skip_brackets()
            if self._next in ("{", "[") or self._next.startswith('"'):
                self._skip_brackets()
            return None
        return self._node(word, depth, "")

    def _node(self, kind: str, depth: int, name: str) -> Node | None:
        if depth > DEEPEST:
            raise _too_deep(self._name)
        if self._next != "{":
            if not self._next:
                raise _cut(self._name)
            return None  # not a node; it is read over
        self._take()
        node = Node(kind, name)
        if name:
            self._known[name] = node
        if kind == "Script" or kind in self._protos:
            self._skip_inside()
            return node
        while self._next != "}":
            if not self._next:
                raise _cut(self._name)
            self._field(node, self._take(), depth)
        self._take()
        return node

    def _field(self, node: Node, field: str, depth: int) -> None:
        if self._next == "[":
            self._take()
            words: list[str] = []
            while self._next != "]":
                if not self._next:
                    raise _cut(self._name)
                if self._is_value(self._next):
                    words.append(self._take())
                else:
                    self._add(node, field, self._statement(depth + 1))
            self._take()
            node.fields[field] = " ".join(words)
            return
        words = []
        while self._next and self._is_value(self._next):
            words.append(self._take())
        if words:
            node.fields[field] = " ".join(words)
        elif self._next in ("{", "["):
            self._skip_brackets()
        elif field in ("ROUTE", "IS") or self._next == "NULL":
            self._take()
        elif self._next[:1].isupper():  # else another field's name follows
            self._add(node, field, self._statement(depth + 1))

    def _add(self, node: Node, field: str, child: Node | None) -> None:
        if child is not None:
            node.nodes.setdefault(field, []).append(child)

    def _is_value(self, word: str) -> bool:
        return word.startswith('"') or word in ("TRUE", "FALSE") or _NUMBER.match(word) is not None

    def _skip_brackets(self) -> None:
        """Skip one pair of brackets and all that is in it, or words up to them."""
        while self._next and self._next not in ("{", "["):
            if not self._next.startswith('"'):
                return
            self._take()
        if self._next:
            self._take()
            self._skip_inside()

    def _skip_inside(self) -> None:
        open_ = 1
        while open_:
            if not self._next:
                raise _cut(self._name)
            word = self._take()
            open_ += (word in ("{", "[")) - (word in ("}", "]"))


def _cut(name: str) -> Rejected:
    return Rejected(codes.TRUNCATED, f"{name}: the VRML ends within a node; fetch it again")


def _too_deep(name: str) -> Rejected:
    return Rejected(codes.SCENE_UNREADABLE, f"{name}: nodes nested deeper than {DEEPEST}; export it again")


def scene_nodes(data: bytes, name: str) -> list[Node]:
    """Nodes of a VRML or X3D file. Raises Rejected as its spelling does."""
    return nodes_of_text(data, name) if data.startswith(b"#VRML") else nodes_of_xml(data, name)


def references(data: bytes, name: str) -> list[Reference]:
    """Pictures, as written. Raises Rejected as `scene_nodes`, and BAD_SCENE_GRAPH."""
    shapes = (shape for shape, _ in _placed(scene_nodes(data, name), name, Notes()))
    textures = (texture for shape in shapes for texture in _textures(shape.first("Appearance")))
    return [Reference(url, Role.IMAGE) for texture in textures for url in texture.texts("url")]


def load(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of a VRML 2.0 or X3D file: metres (or the unit that X3D states), y up, as both formats have it."""
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
        if node.kind in ("Inline", "ProtoInstance"):
            message = "what other files or prototypes hold is left out; merge them first"
            notes.add(codes.FEATURE_IGNORED, node.kind, message)
        elif node.kind in ("HAnimHumanoid", "Skin"):
            message = "a rigged mesh: read as it was modelled, without its rig"
            notes.add(codes.FEATURE_IGNORED, node.kind, message)
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


def _matrix(node: Node) -> Floats:
    """(4, 4) parent_from_node of a Transform. Ref: ISO 19775-1, 10.4.4."""
    moved, center, back, spin, slant, scale = (np.eye(4) for _ in range(6))
    if node.kind not in ("Transform", "HAnimJoint", "HAnimHumanoid"):
        return moved
    moved[:3, 3] = node.vector("translation", (0.0, 0.0, 0.0))
    center[:3, 3] = node.vector("center", (0.0, 0.0, 0.0))
    back[:3, 3] = -center[:3, 3]
    for matrix, name in ((spin, "rotation"), (slant, "scaleOrientation")):
        axis_angle = node.vector(name, (0, 0, 1, 0))
        matrix[:3, :3] = turn(axis_angle[:3], float(axis_angle[3]))
    scale[:3, :3] = np.diag(node.vector("scale", (1.0, 1.0, 1.0)))
    return np.asarray(moved @ center @ spin @ slant @ scale @ slant.T @ back)


class _Reader:
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
        key = (id(appearance), faces.colors is not None)
        material = self._materials.material(key, lambda: self._look(appearance, faces.colors is not None))
        label = shape.name or geometry.name or "shape"
        if appearance is not None and appearance.first("TextureTransform") is not None:
            self._notes.add(codes.FEATURE_IGNORED, "TextureTransform", "a transform of texture coordinates is left out")
        uv = faces.uv
        # X3D 4.1: a picture that is stored upside down
        if uv is not None and any(t.flag("flipVertically", default=False) for t in _textures(appearance)[:1]):
            uv = np.column_stack((uv[:, 0], 1.0 - uv[:, 1]))
        yield part_of_corners(label, points, faces.corners, triangles, material, uv, normals, faces.colors)

    def _cut(self, geometry: Node) -> tuple[Faces, Ints] | None:
        """Faces of a geometry, and its triangles as places in their corners; None if it has no surface."""
        faces = faces_of(geometry)
        if faces is None:
            if geometry.kind in LEFT_OUT:
                self._notes.add(codes.FEATURE_IGNORED, geometry.kind, LEFT_OUT[geometry.kind])
            return None
        triangles, _ = cut_polygons(faces.points, faces.corners, faces.counts, self._limits, self._notes, self._name)
        return faces, triangles if geometry.flag("ccw", default=True) else triangles[:, ::-1]

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
