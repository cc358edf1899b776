"""Nodes of VRML 2.0 and X3D, and those of geometry -> polygons with what is said of their corners."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from casa_assets.core.numeric import Floats, Ints
from casa_assets.ingest.load.polygons import fan, strip
from casa_assets.ingest.load.raw_parts import Bytes, rgba

# Scenes are a dozen deep. Text is read by functions that call each other, four for a level, and Python ends at 1000.
DEEPEST = 150
# Sides of a round shape; a choice.
SIDES = 32
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
            return np.array([_number(word) for word in words])

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


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return float("nan")


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
    if node.kind in _SETS:
        names, cut = _SETS[node.kind]
        index = node.integers("index") if names else np.arange(len(_points(node)))
        corners, counts = cut(node, index)
        return _indexed(node, corners, counts, np.arange(len(corners)), is_plain=True)
    if node.kind in _SOLIDS:
        return _SOLIDS[node.kind](node)
    return None


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


def _threes(_: Node, index: Ints) -> tuple[Ints, Ints]:
    count = len(index) // 3
    return index[: 3 * count], np.full(count, 3)


def _fours(_: Node, index: Ints) -> tuple[Ints, Ints]:
    count = len(index) // 4
    return index[: 4 * count], np.full(count, 4)


def _runs(node: Node, index: Ints, field: str) -> list[Ints]:
    """Runs of corners: parted by -1, or of the lengths that a field has."""
    if node.kind.startswith("Indexed"):
        corners, counts, _ = _rows(index)
        return np.split(corners, np.cumsum(counts)[:-1]) if len(counts) else []
    ends = np.cumsum(np.clip(node.integers(field), 0, len(index)))
    return list(np.split(index, ends[ends <= len(index)]))


def _strips(node: Node, index: Ints) -> tuple[Ints, Ints]:
    found = [run[strip(len(run))].reshape(-1) for run in _runs(node, index, "stripCount")]
    return _threes(node, np.concatenate([np.zeros(0, dtype=np.int64), *found]))


def _fans(node: Node, index: Ints) -> tuple[Ints, Ints]:
    found = [run[fan(len(run))].reshape(-1) for run in _runs(node, index, "fanCount")]
    return _threes(node, np.concatenate([np.zeros(0, dtype=np.int64), *found]))


Cut = Callable[[Node, Ints], tuple[Ints, Ints]]
# Kind -> whether it has an index, and how it is cut into polygons.
_SETS: Mapping[str, tuple[bool, Cut]] = {
    "IndexedTriangleSet": (True, _threes),
    "TriangleSet": (False, _threes),
    "IndexedQuadSet": (True, _fours),
    "QuadSet": (False, _fours),
    "IndexedTriangleStripSet": (True, _strips),
    "TriangleStripSet": (False, _strips),
    "IndexedTriangleFanSet": (True, _fans),
    "TriangleFanSet": (False, _fans),
}


def _box(node: Node) -> Faces:
    size = node.vector("size", (2.0, 2.0, 2.0))
    points = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return Faces(points, np.array(quads).reshape(-1), np.full(6, 4))


def _turned(profile: list[tuple[float, float]]) -> Faces:
    """A profile of (radius, height), from the top down, turned about y; where a radius is 0 the end is closed."""
    angle = np.arange(SIDES) * (2.0 * math.pi / SIDES)
    rings = [np.column_stack((r * np.sin(angle), np.full(SIDES, h), r * np.cos(angle))) for r, h in profile]
    quads = []
    for ring in range(len(profile) - 1):
        for side in range(SIDES):
            a, b = ring * SIDES + side, ring * SIDES + (side + 1) % SIDES
            quads.append((a, a + SIDES, b + SIDES, b))
    return Faces(np.concatenate(rings), np.array(quads).reshape(-1), np.full(len(quads), 4))


def _cylinder(node: Node) -> Faces:
    r, h = node.number("radius", 1.0), node.number("height", 2.0) / 2
    ends = (
        ([(0.0, h)] if node.flag("top", default=True) else []),
        ([(0.0, -h)] if node.flag("bottom", default=True) else []),
    )
    return _turned([*ends[0], (r, h), (r, -h), *ends[1]])


def _cone(node: Node) -> Faces:
    r, h = node.number("bottomRadius", 1.0), node.number("height", 2.0) / 2
    return _turned([(0.0, h), (r, -h), *([(0.0, -h)] if node.flag("bottom", default=True) else [])])


def _sphere(node: Node) -> Faces:
    r = node.number("radius", 1.0)
    steps = [math.pi * k / (SIDES // 2) for k in range(SIDES // 2 + 1)]
    return _turned([(r * math.sin(a), r * math.cos(a)) for a in steps])


_SOLIDS: Mapping[str, Callable[[Node], Faces]] = {
    "Box": _box,
    "Cylinder": _cylinder,
    "Cone": _cone,
    "Sphere": _sphere,
}
