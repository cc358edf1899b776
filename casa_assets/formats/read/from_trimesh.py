"""A trimesh mesh or scene -> RawModel, or a Bundle of it; and OFF, 3MF and XAML bundles, which trimesh reads.

Anything in a file that could make a small one large (archives, copies of copies, long lists of words) is counted
before trimesh sees it.
"""

from __future__ import annotations

import io
import math
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field, fields

import numpy as np
from lxml import etree
from PIL import Image

from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import PACKED_FAULTS, Format, Reference, sniff
from casa_assets.formats.read.guarded_xml import broken_xml, check_xml, local_name
from casa_assets.formats.read.materials import (
    Images,
    ImageUse,
    linear_from_srgb,
    roughness_of_shininess,
    srgb_bytes_from_linear,
)
from casa_assets.formats.read.raw_parts import ReadPart, check_face_count, raw_model
from casa_assets.formats.read.text import Notes, UniqueNames, normalize_text, printable
from casa_assets.mesh.trimesh_exchange import (
    MeshOrScene,
    PlacedMesh,
    TrimeshMaterial,
    count_other_geometries,
    metres_per_unit,
    placed_meshes,
    read_scene,
    up_axis,
)
from casa_assets.model import rejection_codes as codes
from casa_assets.model.asset.material import ColorSpace, Material, Texture
from casa_assets.model.source import Bundle, RawModel, Up

_BLACK = 0.02
WHITE = (1.0, 1.0, 1.0, 1.0)
# For meshes that the caller has made himself and holds in memory already.
NO_LIMITS: Mapping[str, float] = {
    "input_faces": math.inf,
    "input_texture_px": math.inf,
    "input_texture_pixels": math.inf,
}


def raw_from_trimesh(
    thing: MeshOrScene, limits: Mapping[str, float] = NO_LIMITS, name: str = "mesh", up: Up | None = None
) -> RawModel:
    """RawModel of a mesh or scene, node transforms applied; the same content gives the same model.

    Args:
        thing: its units are those that trimesh states; if it states none, they are inferred later from size and kind.
            PBR and simple materials, vertex and face colours (display values), texture coordinates and pictures are
            taken over.
        limits: input_faces, input_texture_px, input_texture_pixels; none by default.
        name: for messages.
        up: the axis that points up; None: the `up_axis` of the metadata, or y if it came from a glTF file.
    Raises:
        Rejected: also OUT_OF_BOUNDS or MIXED_UNITS.
    """
    notes = Notes()
    model = read_placed(thing, limits, notes, name, Format.TRIMESH, up)
    return model.replace(notes=notes.issues)


def bundle_from_trimesh(
    thing: MeshOrScene, limits: Mapping[str, float] = NO_LIMITS, name: str = "mesh", up: Up | None = None
) -> Bundle:
    """A mesh or scene as a Bundle without files: `load` gives back its model, `sha256` is the digest of its content.

    The digest covers arrays, materials, pictures, unit and axis, and none of trimesh's own state. Arguments and errors
    are those of `raw_from_trimesh`.
    """
    return Bundle(main=f"{name}.trimesh", files={}, model=raw_from_trimesh(thing, limits, name, up))


def read_placed(
    thing: MeshOrScene, limits: Mapping[str, float], notes: Notes, name: str, file_format: Format, up: Up | None = None
) -> RawModel:
    """RawModel of a mesh or scene; remarks go into `notes`. Raises Rejected as raw_from_trimesh."""
    if count := count_other_geometries(thing):
        notes.add(codes.FEATURE_IGNORED, "geometry", f"{count} geometries are paths or point clouds; left out")
    placed: list[PlacedMesh] = []
    faces = 0
    try:
        for placed_mesh in placed_meshes(thing):
            faces += len(placed_mesh.faces)
            check_face_count(faces, limits, name)
            placed.append(placed_mesh)
    except ValueError as error:
        raise Rejected(codes.OUT_OF_BOUNDS, f"{name}: {error}") from error
    try:
        metres = metres_per_unit(thing)
    except ValueError as error:
        raise Rejected(codes.MIXED_UNITS, f"{name}: {error}") from error
    stated = up_axis(thing)
    materials = _Materials(Images(limits, notes), notes)
    parts = []
    for one in placed:
        colors = one.colors
        if colors is not None and one.is_linear:
            colors = np.column_stack((srgb_bytes_from_linear(colors[:, :3] / 255.0), colors[:, 3]))
        material = materials.material(one.finish, colors is not None)
        parts.append(ReadPart(one.name, one.vertices, one.faces, material, one.uv, one.normals, colors))
    return raw_model(parts, notes, name, file_format, metres, up or (Up(stated) if stated else None))


class _Materials:
    def __init__(self, images: Images, notes: Notes) -> None:
        self._images, self._notes = images, notes
        self._names = UniqueNames()
        self._made: dict[tuple[object, ...], Material] = {}
        self._encoded: dict[tuple[int, ImageUse], Texture | None] = {}

    def material(self, source: TrimeshMaterial | None, is_colored: bool) -> Material:
        """Ours; grey where nothing says how it looks, white where vertex colours do."""
        key: tuple[object, ...] = (is_colored,)
        if source is not None:
            images = tuple((slot, id(image)) for slot, image in sorted(source.images.items()))
            key = tuple(images if f.name == "images" else getattr(source, f.name) for f in fields(source))
        if key not in self._made:
            self._made[key] = self._make(source, is_colored)
        return self._made[key]

    def _make(self, source: TrimeshMaterial | None, is_colored: bool) -> Material:
        if source is None:
            base = WHITE if is_colored else (0.8, 0.8, 0.8, 1.0)
            return Material(id=self._names.unique("material", "material"), base_color=base)
        name = source.name or "material"
        picture, color = source.images.get("base"), source.color
        if max(color[:3]) <= _BLACK < max(source.emissive) and (picture is None or "emissive" in source.images):
            self._notes.add(codes.EMISSIVE_AS_BASE, name, "black surface that glows: its glow is its colour")
            picture, color = source.images.get("emissive"), (*source.emissive, color[3])
        alpha: str | float = "keep"
        opacity = source.color[3]
        if source.alpha_mode == "OPAQUE":
            alpha, opacity = "drop", 1.0
        elif opacity <= 0.0:
            self._notes.add(codes.FULLY_TRANSPARENT, name, "alpha 0 would hide it; made opaque")
            alpha, opacity = "drop", 1.0
        elif source.alpha_mode == "MASK":
            alpha, opacity = min(1.0, source.alpha_cutoff / opacity), 1.0
        base_picture = self._texture(picture, f"{name}_color", ImageUse(ColorSpace.SRGB, alpha))
        raw = ImageUse(ColorSpace.RAW, "drop")
        rgb = color[:3] if source.is_linear else tuple(linear_from_srgb(c) for c in color[:3])
        if not source.is_linear and base_picture is not None:
            rgb = (1.0, 1.0, 1.0)  # as for OBJ: beside a picture the diffuse colour is a leftover as often as a tint
        # Values that the kind of material implies (glTF: 1).
        metallic, roughness = source.metallic, source.roughness
        if metallic is None:
            metallic = 1.0 if source.is_linear and not _is_bare(source) else 0.0
        if not source.is_linear:
            roughness = roughness_of_shininess(source.shininess)
        elif roughness is None:
            roughness = 0.9 if _is_bare(source) else 1.0
        return Material(
            id=self._names.unique(name, "material"),
            base_color=(*rgb, opacity),
            metallic=min(1.0, max(0.0, float(metallic))),
            roughness=min(1.0, max(0.0, float(roughness))),
            base_color_texture=base_picture,
            metallic_roughness_texture=self._texture(source.images.get("rough"), f"{name}_rough", raw),
            normal_texture=self._texture(source.images.get("normal"), f"{name}_normal", raw),
        )

    def _texture(self, image: Image.Image | None, name: str, use: ImageUse) -> Texture | None:
        if image is None:
            return None
        key = (id(image), use)
        if key not in self._encoded:
            stream = io.BytesIO()
            image.save(stream, "PNG", compress_level=1)
            data = stream.getvalue()
            self._encoded[key] = self._images.texture(f"{name}/{len(self._encoded)}", data, name, use)
        return self._encoded[key]


def _is_bare(source: TrimeshMaterial) -> bool:
    """True where a PBR material states nothing at all of how it shines; it is then matt, as for glTF."""
    stated = source.metallic, source.roughness
    return stated == (None, None) and not {"base", "rough"} & source.images.keys() and source.color == WHITE


# Components may name components, so a small file can ask for endless copies.
MAX_COPIES = 20_000
_COLORS = frozenset({"basematerials", "colorgroup", "texture2d", "texture2dgroup", "compositematerials"})
# Words of text for each face that is allowed: three numbers for each of a face's own vertices, and its corners.
WORDS_PER_FACE = 16
# Bytes of XML for each face that is allowed: a triangle and the vertices that it brings take about 80 to 130.
BYTES_PER_FACE = 200
SMALLEST_PACKAGE = 1 << 20
# Errors of trimesh's readers on files that are broken.
_FAULTS = (*PACKED_FAULTS, AttributeError, TypeError, NameError, StopIteration, SyntaxError)


@dataclass
class _Object:
    """An object: its own triangles, those read from other files among them, and the ids of objects it is made of."""

    faces: int = 0
    inner: list[str] = field(default_factory=list)


def check_package(members: Mapping[str, bytes], limits: Mapping[str, float], name: str) -> bool:
    """Count what the build of a 3MF package places; returns whether it states colours. Raises Rejected.

    Args:
        members: model files of the package by name, guarded against entities.
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
    faces = _placed_faces(objects, placed, name)
    check_face_count(faces, limits, name)
    if not faces:
        raise Rejected(codes.NO_GEOMETRY, f"{name}: its build places no triangle; export the object itself")
    return is_colored


def _placed_faces(objects: Mapping[str, _Object], placed: list[str], name: str) -> int:
    """Triangles of all that the build places, over all copies."""
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
    if sum(copies for _, copies in sums) > MAX_COPIES:
        raise Rejected(codes.BAD_SCENE_GRAPH, f"{name}: objects are copied without end; export the file again")
    return sum(faces for faces, _ in sums)


def references(data: bytes, name: str) -> list[Reference]:
    """None: what these formats name elsewhere is not read."""
    return []


def load(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of an OFF, a 3MF or a XAML file."""
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
    if check_package(members, limits, name):
        notes.add(codes.FEATURE_IGNORED, "resources", "materials, colours and pictures of a 3MF are left out")
    stored = io.BytesIO()  # trimesh takes no files but those of a zip
    with zipfile.ZipFile(stored, "w", zipfile.ZIP_STORED) as archive:
        for file, content in members.items():
            archive.writestr(zipfile.ZipInfo(file), content)
    return _read(stored.getvalue(), "3mf", Format.THREE_MF, limits, notes, name, Up.Z)


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
