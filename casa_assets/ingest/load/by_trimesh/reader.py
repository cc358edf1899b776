"""OFF, 3MF and XAML bundles -> RawModel: read by trimesh, bounded before and after.

What could make a small file large (archives, copies of copies, long lists of words) is counted before trimesh sees it.
"""

from __future__ import annotations

import io
import struct
import zipfile
import zlib
from collections.abc import Mapping

from lxml import etree

from casa_assets.errors import Rejected
from casa_assets.geometry.mesh.trimesh_exchange import read_scene
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.by_trimesh.from_trimesh import read_placed
from casa_assets.ingest.load.by_trimesh.threemf import package_size
from casa_assets.ingest.load.collada.guarded_xml import check_xml, local_name
from casa_assets.ingest.load.formats import Format
from casa_assets.ingest.load.notes import Notes, printable
from casa_assets.ingest.load.raw_parts import check_face_count
from casa_assets.ingest.load.text import normalize_text
from casa_assets.model.ingest.source import Bundle, RawModel, Up

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


def read_off(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of an OFF or COFF file; it declares neither unit nor up axis, and its colours are left out.

    Raises:
        Rejected: EXCHANGE_UNREADABLE, TOO_LARGE, and what RawModels in memory are refused for.
    """
    name = printable(bundle.main)
    text = normalize_text(bundle.files[bundle.main], name)
    if text.lstrip()[:4] == b"COFF":
        notes.add(codes.FEATURE_IGNORED, "COFF", "colours of vertices are left out")
    words = sum(text.count(space) for space in (b" ", b"\t", b"\n"))
    if words > WORDS_PER_FACE * limits["input_faces"]:
        message = f"{name}: {words} words, more than {limits['input_faces']:.0f} faces need; simplify the mesh first"
        raise Rejected(codes.TOO_LARGE, message)
    return _read(text, "off", Format.OFF, limits, notes, name)


def read_3mf(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of a 3MF package: millimetres or what it states, z up; its colours and pictures are left out.

    Raises:
        Rejected: EXCHANGE_UNREADABLE, TOO_LARGE, XML_ENTITY, XML_DEPTH, BAD_XML, TRUNCATED, BAD_SCENE_GRAPH, and what
            RawModels in memory are refused for.
    """
    name = printable(bundle.main)
    members = _unpacked(bundle.files[bundle.main], limits, name)
    for member in members.values():
        check_xml(member, name)
    stated = package_size(members, limits, name)
    if stated.is_colored:
        notes.add(codes.FEATURE_IGNORED, "resources", "materials, colours and pictures of a 3MF are left out")
    return _read(_packed(members), "3mf", Format.THREE_MF, limits, notes, name, Up.Z)


def read_xaml(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of a XAML scene as SolidWorks exports it: metres; y up, as WPF draws it.

    Raises:
        Rejected: EXCHANGE_UNREADABLE, TOO_LARGE, XML_ENTITY, XML_DEPTH, BAD_XML, TRUNCATED, BAD_SCENE_GRAPH, and what
            RawModels in memory are refused for.
    """
    name = printable(bundle.main)
    data = bundle.files[bundle.main]
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
