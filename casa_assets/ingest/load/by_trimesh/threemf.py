"""Count the triangles and copies of a 3MF package before anything is built from them."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass, field

from lxml import etree

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.collada.guarded_xml import local_name
from casa_assets.ingest.load.raw_parts import check_face_count

# Components may name components, so a small file can ask for endless copies.
MAX_COPIES = 20_000
_COLORS = frozenset({"basematerials", "colorgroup", "texture2d", "texture2dgroup", "compositematerials"})


@dataclass
class _Object:
    """An object: its own triangles, those read from other files among them, and the ids of objects it is made of."""

    faces: int = 0
    inner: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class PackageSize:
    """Size of a 3MF package once built: triangles over all copies, copies, and whether it states colours."""

    faces: int
    copies: int
    is_colored: bool


def package_size(members: Mapping[str, bytes], limits: Mapping[str, float], name: str) -> PackageSize:
    """Count what the build of a package places.

    Args:
        members: model files of the package by name, guarded against entities.
    Raises:
        Rejected: BAD_SCENE_GRAPH (copies without end, or of itself), TOO_LARGE, NO_GEOMETRY.
    """
    main = next(n for n in members if n.lower().endswith("3d/3dmodel.model"))
    objects: dict[str, _Object] = {}
    placed: list[str] = []
    triangles = {n.strip("/"): data.count(b"triangle ") for n, data in members.items()}
    is_colored = False
    outside = 0
    current = _Object()
    stream = etree.iterparse(io.BytesIO(members[main]), events=("start", "end"), resolve_entities=False, huge_tree=True)
    for event, element in stream:
        kind = local_name(element)
        if event == "end":
            if kind in ("object", "triangles", "vertices"):
                element.clear()
            continue
        is_colored |= kind in _COLORS
        if kind == "object":
            current = objects.setdefault(element.get("id", ""), _Object())
        elif kind == "triangle":
            current.faces += 1
        elif kind == "component":
            current.inner.append(element.get("objectid", ""))
            path = next((v.strip("/") for k, v in element.attrib.items() if str(k).endswith("path")), None)
            if path in triangles:
                # The reader takes in the whole file once more for each component that names it.
                outside += triangles[path]
                check_face_count(outside, limits, name)
                objects.setdefault(element.get("objectid", ""), _Object()).faces += triangles[path]
        elif kind == "item":
            placed.append(element.get("objectid", ""))
    faces, copies = _placed(objects, placed, name)
    check_face_count(faces, limits, name)
    if not faces:
        raise Rejected(codes.NO_GEOMETRY, f"{name}: its build places no triangle; export the object itself")
    return PackageSize(faces, copies, is_colored)


def _placed(objects: Mapping[str, _Object], placed: list[str], name: str) -> tuple[int, int]:
    """Triangles and copies of all that the build places."""
    known: dict[str, tuple[int, int]] = {}
    open_now: set[str] = set()

    def total(key: str) -> tuple[int, int]:
        if key in known or key not in objects:
            return known.get(key, (0, 0))
        if key in open_now or len(open_now) > 100:
            raise Rejected(codes.BAD_SCENE_GRAPH, f"{name}: objects contain each other; export the file again")
        open_now.add(key)
        inner = [total(k) for k in objects[key].inner]
        open_now.discard(key)
        known[key] = objects[key].faces + sum(f for f, _ in inner), 1 + sum(c for _, c in inner)
        return known[key]

    sums = [total(key) for key in placed]
    faces, copies = sum(f for f, _ in sums), sum(c for _, c in sums)
    if copies > MAX_COPIES:
        raise Rejected(codes.BAD_SCENE_GRAPH, f"{name}: objects are copied without end; export the file again")
    return faces, copies
