"""OFF, 3MF and XAML bundles -> RawModel: read by trimesh, bounded before and after.

Anything that could make a small file large (archives, copies of copies, long lists of words) is counted before trimesh
sees it.
"""

from __future__ import annotations

import io
import struct
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field

from lxml import etree

from casa_assets.errors import Rejected
from casa_assets.geometry.mesh.trimesh_exchange import read_scene
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.formats import Format, Reference, sniff
from casa_assets.ingest.load.from_trimesh import read_placed
from casa_assets.ingest.load.guarded_xml import broken_xml, check_xml, local_name
from casa_assets.ingest.load.notes import Notes, printable
from casa_assets.ingest.load.raw_parts import check_face_count
from casa_assets.ingest.load.text import normalize_text
from casa_assets.model.source import Bundle, RawModel, Up

# Components may name components, so a small file can ask for endless copies.
MAX_COPIES = 20_000
_COLORS = frozenset({"basematerials", "colorgroup", "texture2d", "texture2dgroup", "compositematerials"})
# Words of text for each face that is allowed: three numbers for each of a face's own vertices, and its corners.
WORDS_PER_FACE = 16
# Bytes of XML for each face that is allowed: a triangle and the vertices that it brings take about 80 to 130.
BYTES_PER_FACE = 200
SMALLEST_PACKAGE = 1 << 20
# What trimesh's readers raise on files that are broken.
_FAULTS = (
    ValueError,
    LookupError,
    AttributeError,
    TypeError,
    NameError,
    ArithmeticError,
    RuntimeError,
    OSError,
    StopIteration,
    SyntaxError,
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
)


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


def references(data: bytes, name: str) -> list[Reference]:
    """None: what these formats name elsewhere is not read."""
    return []


def load(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of an OFF, a 3MF or a XAML file.

    Raises:
        Rejected: EXCHANGE_UNREADABLE, TOO_LARGE, XML_ENTITY, XML_DEPTH, BAD_XML, TRUNCATED, BAD_SCENE_GRAPH, and what
            RawModels in memory are refused for.
    """
    name = printable(bundle.main)
    data = bundle.files[bundle.main]
    readers = {Format.OFF: _off, Format.THREE_MF: _package, Format.XAML: _xaml}
    try:
        return readers[sniff(data, name)](data, limits, notes, name)
    except etree.XMLSyntaxError as error:
        raise broken_xml(error, name) from error


def _off(data: bytes, limits: Mapping[str, float], notes: Notes, name: str) -> RawModel:
    """OFF or COFF; it declares neither unit nor up axis, and its colours are left out."""
    text = normalize_text(data, name)
    if text.lstrip()[:4] == b"COFF":
        notes.add(codes.FEATURE_IGNORED, "COFF", "colours of vertices are left out")
    words = sum(text.count(space) for space in (b" ", b"\t", b"\n"))
    if words > WORDS_PER_FACE * limits["input_faces"]:
        message = f"{name}: {words} words, more than {limits['input_faces']:.0f} faces need; simplify the mesh first"
        raise Rejected(codes.TOO_LARGE, message)
    return _read(text, "off", Format.OFF, limits, notes, name)


def _package(data: bytes, limits: Mapping[str, float], notes: Notes, name: str) -> RawModel:
    """A 3MF package: millimetres or what it states, z up; its colours and pictures are left out."""
    members = _unpacked(data, limits, name)
    for member in members.values():
        check_xml(member, name)
    stated = package_size(members, limits, name)
    if stated.is_colored:
        notes.add(codes.FEATURE_IGNORED, "resources", "materials, colours and pictures of a 3MF are left out")
    return _read(_packed(members), "3mf", Format.THREE_MF, limits, notes, name, Up.Z)


def _xaml(data: bytes, limits: Mapping[str, float], notes: Notes, name: str) -> RawModel:
    """A XAML scene as SolidWorks exports it: metres; y up, as WPF draws it."""
    check_xml(data, name)
    words = 0
    for _, element in etree.iterparse(io.BytesIO(data), resolve_entities=False, no_network=True, huge_tree=True):
        words += sum(text.count(" ") + text.count(",") for text in map(str, element.attrib.values()))
        if local_name(element) == "GeometryModel3D" and any(
            local_name(a) == "GeometryModel3D" for a in element.iterancestors()
        ):
            raise Rejected(codes.BAD_SCENE_GRAPH, f"{name}: models stand within models; export the file again")
    if words > WORDS_PER_FACE * limits["input_faces"]:
        message = f"{name}: {words} numbers, more than {limits['input_faces']:.0f} faces need; simplify the mesh first"
        raise Rejected(codes.TOO_LARGE, message)
    return _read(data, "xaml", Format.XAML, limits, notes, name, Up.Y).replace(metres_per_unit=1.0)


def _read(
    data: bytes, kind: str, found: Format, limits: Mapping[str, float], notes: Notes, name: str, up: Up | None = None
) -> RawModel:
    try:
        scene = read_scene(data, kind)
    except _FAULTS as error:
        message = (
            f"{name}: trimesh cannot read it ({type(error).__name__}: {printable(str(error), 80)}); export it as GLB"
        )
        raise Rejected(codes.EXCHANGE_UNREADABLE, message) from error
    check_face_count(sum(len(getattr(g, "faces", ())) for g in scene.geometry.values()), limits, name)
    return read_placed(scene, limits, notes, name, found, up)


def _unpacked(data: bytes, limits: Mapping[str, float], name: str) -> dict[str, bytes]:
    """The model files of a 3MF package, and nothing else of it.

    A member never yields more than its header declares, so the sum of what is declared bounds what is unpacked.
    """
    most = BYTES_PER_FACE * limits["input_faces"] + SMALLEST_PACKAGE
    out: dict[str, bytes] = {}
    total = 0
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            for info in archive.infolist():
                if not info.filename.lower().endswith(".model"):
                    continue
                total += info.file_size
                if total > most:
                    message = f"{name}: unpacks to more than {most:.0f} bytes; simplify it first or raise --max-faces"
                    raise Rejected(codes.TOO_LARGE, message)
                with archive.open(info) as stream:
                    out[info.filename] = stream.read(info.file_size)
    except _FAULTS as error:
        message = f"{name}: the archive cannot be unpacked ({printable(str(error), 80)}); fetch it again"
        raise Rejected(codes.EXCHANGE_UNREADABLE, message) from error
    return out


def _packed(members: Mapping[str, bytes]) -> bytes:
    """A zip of these members, stored, for a reader that takes no other."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as archive:
        for name, data in members.items():
            archive.writestr(zipfile.ZipInfo(name), data)
    return out.getvalue()
