"""USD -> RawModel: meshes at their places, instances expanded, one part for each material.

The library of USD reads files, so the layers of one input are written into a folder that is made for them and goes
with them. It follows what layers name: a path of the machine, another file format, an address. So each layer is opened
by itself first, and what it names has to be a layer that lies in that folder.
"""

from __future__ import annotations

import io
import posixpath
import re
import struct
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Sdf, Tf, Usd, UsdGeom, UsdShade

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import PACKED_FAULTS, Format, Reference, Role
from casa_assets.formats.read.materials import Look, Materials, rgba_of_linear
from casa_assets.formats.read.raw_parts import (
    Bytes,
    ReadPart,
    check_face_count,
    cut_polygons,
    part_of_corners,
    raw_model,
    transformed,
)
from casa_assets.formats.read.text import Notes, printable
from casa_assets.model import rejection_codes as codes
from casa_assets.model.asset.material import Material
from casa_assets.model.source import Bundle, RawModel, Up

MAGIC = b"PXR-USDC"
LAYERS = (MAGIC, b"#usda")
# A crate has six sections; others may come.
MAX_SECTIONS = 64
# Whole numbers take a quarter of a byte at least, and LZ4 packs 255 to one at most.
ITEMS_PER_BYTE = 4 * 255
SUFFIXES = (".usd", ".usda", ".usdc")
# Layers and pictures of one package; a choice, as is the depth of paths.
MAX_MEMBERS = 2000
DEEPEST_PRIM = 200
# Folders that a layer may lie above the main one, within what the user named.
MOST_UP = 8
# Errors of the library of USD on files that are broken.
FAULTS = (Tf.ErrorException, RuntimeError, UnicodeError, OverflowError, MemoryError, OSError)
UV = "st"
# Steps from a surface to its picture: a graph may be a circle.
MAX_STEPS = 8
# Prims of a stage with its instances expanded; references that double at each of many levels make more.
MAX_PRIMS = 20_000
_LEFT_OUT = {
    "PointInstancer": "points at which things are repeated are left out; make instances of them real",
    "BasisCurves": "curves are left out; convert them to meshes",
    "NurbsPatch": "NURBS are left out; convert them to meshes",
    **dict.fromkeys(("Cube", "Sphere", "Cylinder", "Cone", "Capsule"), "a shape without a mesh; convert it to one"),
}


def check_crate(data: bytes, name: str) -> None:
    """Look at where the sections of a crate lie, and at how many items each claims. Text layers pass. Raises Rejected.

    Ref: OpenUSD, pxr/usd/sdf/crateFile.h: magic, version, place of the table; each section begins with its count.
    """
    if not data.startswith(MAGIC):
        return
    if len(data) < 32:
        raise Rejected(codes.TRUNCATED, f"{name}: {len(data)} bytes, a USD crate has more; fetch it again")
    place = struct.unpack_from("<q", data, 16)[0]
    count = struct.unpack_from("<Q", data, place)[0] if 0 < place <= len(data) - 8 else 0
    if not 0 < count <= MAX_SECTIONS or place + 8 + 32 * count > len(data):
        raise Rejected(codes.TRUNCATED, f"{name}: the USD crate ends before its table of contents; fetch it again")
    for number in range(count):
        label, start, size = struct.unpack_from("<16sqq", data, place + 8 + 32 * number)
        if start < 0 or size < 0 or start + size > len(data):
            raise _mismatch(label, f"lies at byte {start}, past the end", name)
        items = struct.unpack_from("<Q", data, start)[0] if size >= 8 else 0
        if items > ITEMS_PER_BYTE * size:
            raise _mismatch(label, f"claims {items} items in {size} bytes", name)
        if label.startswith(b"TOKENS") and size >= 16:
            unpacked = struct.unpack_from("<Q", data, start + 8)[0]
            if unpacked > ITEMS_PER_BYTE * size:
                raise _mismatch(label, f"claims {unpacked} bytes in {size}", name)


def _mismatch(label: bytes, why: str, name: str) -> Rejected:
    section = label.rstrip(b"\0").decode("ascii", "replace")[:16]
    return Rejected(codes.LENGTH_MISMATCH, f"{name}: the section {section} of the USD crate {why}; fetch it again")


def unpacked(data: bytes, main: str, limits: Mapping[str, float], name: str) -> tuple[str, dict[str, bytes]]:
    """Main layer and members of a USDZ package; a bare layer is its own only member. Raises Rejected."""
    if not data.startswith(b"PK"):
        return main, {main: data}
    members: dict[str, bytes] = {}
    left = limits["input_bytes"]
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            for info in archive.infolist()[: MAX_MEMBERS + 1]:
                path = inside(info.filename, name, 0)
                left -= info.file_size
                if left < 0 or len(members) >= MAX_MEMBERS:
                    raise Rejected(codes.TOO_LARGE, f"{name}: unpacks to more than the limits allow; simplify it first")
                if not info.is_dir():
                    with archive.open(info) as stream:
                        members[path] = stream.read(info.file_size)
    except PACKED_FAULTS as error:
        message = f"{name}: the package cannot be unpacked ({printable(str(error), 80)}); fetch it again"
        raise Rejected(codes.BAD_ARCHIVE, message) from error
    first = next(iter(members), "")
    if not first.lower().endswith(SUFFIXES):
        raise Rejected(codes.WRONG_TYPE, f"{name}: the first file of a USDZ has to be a layer; export it again")
    return first, members


def inside(path: str, name: str, most_up: int = MOST_UP) -> str:
    """A path, normalised, that begins with no more than `most_up` steps up. Raises Rejected."""
    plain = posixpath.normpath(path.replace("\\", "/"))
    if re.search(r"^([A-Za-z][A-Za-z0-9+.-]*:|/|\\|`|~)|\[|\]|\0", path) or plain.split("/").count("..") > most_up:
        message = f"{name}: {printable(path, 80)!r} lies outside of the package; put the file into it"
        code = codes.NETWORK_URI if re.match(r"[A-Za-z][A-Za-z0-9+.-]+://", path) else codes.PATH_TRAVERSAL
        raise Rejected(code, message)
    return plain


def references(data: bytes, name: str) -> list[Reference]:
    """Layers that one layer brings in, and pictures that it names, as written there; a package holds its own.

    Raises:
        Rejected: SCENE_UNREADABLE where it is no layer, or is nested without end.
    """
    if data.startswith(b"PK"):
        return []
    pictures: dict[str, None] = {}
    with tempfile.TemporaryDirectory(prefix="casa_usd_") as folder:
        try:
            layer = _opened(data, name, Path(folder))
            for spec in _specs(layer, name):
                if isinstance(spec, Sdf.AttributeSpec) and isinstance(spec.default, Sdf.AssetPath):
                    pictures[spec.default.path] = None
            layers = [path for path in layer.GetCompositionAssetDependencies() if path]
        except FAULTS as error:
            raise broken(name) from error
    files = [path for path in pictures if path and not path.lower().endswith((*SUFFIXES, ".usdz"))]
    return [Reference(layer, Role.LAYER) for layer in layers] + [Reference(file, Role.IMAGE) for file in files]


def _opened(data: bytes, name: str, folder: Path) -> Sdf.Layer:
    """A layer by itself: nothing that it names is opened. Raises Rejected SCENE_UNREADABLE."""
    check_crate(data, name)
    copy = folder / ("layer.usdc" if data.startswith(MAGIC) else "layer.usda")
    copy.write_bytes(data)
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(copy)) if data.startswith(LAYERS) else None
    finally:
        copy.unlink()
    if layer is None:
        raise broken(name)
    return layer


def checked(layer: Sdf.Layer, path: str, members: Mapping[str, bytes], name: str) -> None:
    """Raise where a layer would bring in anything but layers of its package; clips of animation are taken out.

    Args:
        path: of the layer within the package. members: of the package.
    Raises:
        Rejected: PATH_TRAVERSAL, NETWORK_URI, MISSING_FILE, SCENE_UNREADABLE.
    """
    for spec in _specs(layer, name):
        if isinstance(spec, Sdf.PrimSpec) and spec.HasInfo("clips"):
            spec.ClearInfo("clips")  # animation in other files; what is read is the shape at rest
    for wanted in filter(None, layer.GetCompositionAssetDependencies()):  # one within the layer has no name
        inside(wanted, name)
        place = inside(posixpath.join(posixpath.dirname(path), wanted), name)
        if place not in members:
            message = f"{name}: the layer {printable(wanted, 80)!r} is missing; put it beside the file"
            raise Rejected(codes.MISSING_FILE, message)
        if not members[place].startswith(LAYERS):
            message = f"{name}: {printable(wanted, 80)!r} is no USD layer; flatten the stage and export it again"
            raise Rejected(codes.SCENE_UNREADABLE, message)


def _specs(layer: Sdf.Layer, name: str) -> Iterator[Sdf.Spec]:
    """All prims and attributes of a layer, those of variants among them."""
    waiting = list(layer.rootPrims)
    while waiting:
        prim = waiting.pop()
        if prim is None:
            raise broken(name)
        if prim.path.pathElementCount > DEEPEST_PRIM:
            raise Rejected(codes.SCENE_UNREADABLE, f"{name}: prims nested deeper than {DEEPEST_PRIM}; export it again")
        yield prim
        yield from prim.attributes
        waiting += prim.nameChildren
        for variants in prim.variantSets.values():
            waiting += [variant.primSpec for variant in variants.variants.values()]


def broken(name: str) -> Rejected:
    """The refusal of a layer that USD cannot read."""
    return Rejected(
        codes.SCENE_UNREADABLE, f"{name}: this is no readable USD layer; open it in usdview, export it again"
    )


class UsdMaterials:
    """Materials of one stage.

    Args:
        members: path within the package -> bytes, for pictures. folder: of the main layer, within the package.
    """

    def __init__(self, materials: Materials, members: Mapping[str, bytes], folder: str) -> None:
        self._materials, self._members, self._folder = materials, members, folder
        self._made: dict[object, tuple[Material, str]] = {}

    def of(self, prim: Usd.Prim, is_colored: bool) -> tuple[Material, str]:
        """Material of a mesh or of a subset of it, and the name of its texture coordinates."""
        bound = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
        key = (str(bound.GetPath()) if bound else str(prim.GetPath()), is_colored)
        if key not in self._made:
            look, uv = self._look(bound) if bound else (_display_look(prim, is_colored), UV)
            self._made[key] = self._materials.material(key, lambda: look), uv
        return self._made[key]

    def _look(self, material: UsdShade.Material) -> tuple[Look, str]:
        name = material.GetPrim().GetName()
        shader = material.ComputeSurfaceSource()[0]
        if not shader:
            return Look(name), UV
        color = _value(shader, "diffuseColor", (0.18, 0.18, 0.18))
        picture, uv = self._picture(shader, "diffuseColor")
        look = Look(
            name=name,
            color=(1.0, 1.0, 1.0) if picture else _triple(color),
            opacity=_number(_value(shader, "opacity", 1.0), 1.0),
            metallic=_number(_value(shader, "metallic", 0.0), 0.0),
            roughness=_number(_value(shader, "roughness", 0.5), 0.5),
            picture=picture,
        )
        return look, uv

    def _picture(self, shader: UsdShade.Shader, entry: str) -> tuple[tuple[str, bytes] | None, str]:
        """Key and bytes of the picture that feeds an input, and the primvar that lays it out."""
        source = _source(shader, entry)
        for _ in range(MAX_STEPS):
            if source is None or source.GetIdAttr().Get() == "UsdUVTexture":
                break
            names = [i.GetBaseName() for i in source.GetInputs()]
            source = next((s for s in (_source(source, n) for n in names) if s is not None), None)
        if source is None or source.GetIdAttr().Get() != "UsdUVTexture":
            return None, UV
        file = _value(source, "file", None)
        written = str(file.path) if isinstance(file, Sdf.AssetPath) else ""
        near = posixpath.normpath(posixpath.join(self._folder, written))
        paths = (near, posixpath.normpath(written), written)
        data = next((self._members[path] for path in paths if path in self._members), None)
        reader = _source(source, "st")
        for _ in range(MAX_STEPS):
            if reader is None or reader.GetInput("varname"):
                break
            reader = _source(reader, "in")
        uv = UV if reader is None else str(_value(reader, "varname", UV) or UV)
        return ((written, data) if data else None), uv


def named_values(prim: Usd.Prim, name: str, width: int, corners: Ints, counts: Ints) -> Floats | None:
    """(C, width) values of a primvar at each corner, or None if it is missing or has another number of values.

    Args:
        corners: (C,) point of each corner. counts: (F,) corners of each face.
    """
    api = UsdGeom.PrimvarsAPI(prim)
    primvar = api.FindPrimvarWithInheritance(name)
    if not primvar and name == UV:
        named = [p for p in api.GetPrimvars() if p.GetTypeName().role == "TextureCoordinate"]
        primvar = named[0] if named else primvar
    if not primvar or not len(corners):
        return None
    at = Usd.TimeCode.EarliestTime()
    values = _array(primvar.Get(at), width)
    if primvar.IsIndexed():
        indices = np.asarray(primvar.GetIndices(at) or [], dtype=np.int64).reshape(-1)
        if not len(values) or not len(indices) or not 0 <= int(indices.min()) <= int(indices.max()) < len(values):
            return None
        values = values[indices]
    spread = {
        UsdGeom.Tokens.faceVarying: np.arange(len(corners)),
        UsdGeom.Tokens.uniform: np.repeat(np.arange(len(counts)), np.maximum(counts, 0))[: len(corners)],
        UsdGeom.Tokens.constant: np.zeros(len(corners), dtype=np.int64),
    }.get(primvar.GetInterpolation(), corners)
    is_good = len(spread) == len(corners) and 0 <= int(spread.min()) <= int(spread.max()) < len(values)
    return values[spread] if is_good else None


def _display_look(prim: Usd.Prim, is_colored: bool) -> Look:
    """Look of a mesh without a material: its display colour, where it is one for the whole mesh."""
    if is_colored:
        return Look("material", (1.0, 1.0, 1.0))
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor")
    raw = primvar.Get(Usd.TimeCode.EarliestTime()) if primvar else None
    shades = _array(raw, 3)
    return Look("display_color", _triple(shades[0])) if len(shades) else Look("material")


def _source(shader: UsdShade.Shader, entry: str) -> UsdShade.Shader | None:
    connected = shader.GetInput(entry)
    sources = connected.GetConnectedSources()[0] if connected else []
    if not sources:
        return None
    found = UsdShade.Shader(sources[0].source.GetPrim())
    return found if found else None


def _value(shader: UsdShade.Shader, entry: str, default: Any) -> Any:
    """Value of an input, through interfaces of materials; the default if no value is given."""
    connected = shader.GetInput(entry)
    if not connected:
        return default
    attributes = UsdShade.Utils.GetValueProducingAttributes(connected)
    value = attributes[0].Get(Usd.TimeCode.EarliestTime()) if attributes else None
    return default if value is None else value


def _triple(value: Any) -> tuple[float, float, float]:
    try:
        r, g, b = (float(c) for c in value)
    except (TypeError, ValueError):
        return (0.8, 0.8, 0.8)
    return (r, g, b)


def _number(value: Any, default: float) -> float:
    return float(value) if isinstance(value, int | float) else default


def load(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of a USD, USDA, USDC or USDZ: its stated unit (none stated: centimetres, as USD has it) and up axis.

    The layers are written into a temporary folder, as the library of USD reads no bytes.
    """
    name = printable(bundle.main)
    main, members = unpacked(bundle.files[bundle.main], bundle.main, limits, name)
    if main == bundle.main:
        members = {posixpath.normpath(path): data for path, data in bundle.files.items()}
    with tempfile.TemporaryDirectory(prefix="casa_usd_") as folder:
        reader = _Reader(members, posixpath.dirname(main), limits, notes, name)
        try:
            stage = _open(posixpath.normpath(main), members, Path(folder, *(["_"] * MOST_UP)), name)
            parts = [part for prim in _prims(stage, notes, name) for part in reader.parts(prim)]
            up = {"Y": Up.Y, "Z": Up.Z}.get(str(UsdGeom.GetStageUpAxis(stage)).upper())
            metres = float(UsdGeom.GetStageMetersPerUnit(stage))
        except FAULTS as error:  # a crate is read piece by piece, so that a broken one may be found at any of these
            raise broken(name) from error
    stated = metres if np.isfinite(metres) and metres > 0.0 else None
    return raw_model(parts, notes, name, Format.USD, stated, up)


def _open(main: str, members: Mapping[str, bytes], folder: Path, name: str) -> Usd.Stage:
    """The stage; its layers were looked at, each by itself, and name none but each other."""
    kept: list[Sdf.Layer] = []
    for path, data in members.items():
        if data.startswith(LAYERS):
            check_crate(data, name)
            place = folder / inside(path, name)
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(data)
    for path in members:
        if (folder / path).is_file():
            layer = Sdf.Layer.FindOrOpen(str(folder / path))
            if layer is None:
                raise broken(name)
            checked(layer, path, members, name)
            kept.append(layer)
    stage = Usd.Stage.Open(str(folder / main)) if (folder / main).is_file() else None
    if stage is None:
        raise broken(name)
    return stage


def _prims(stage: Usd.Stage, notes: Notes, name: str) -> Iterator[UsdGeom.Mesh]:
    """Meshes that are shown, those of instances too."""
    every = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)
    if sum(1 for _ in islice(iter(Usd.PrimRange.Stage(stage, every)), MAX_PRIMS + 1)) > MAX_PRIMS:
        raise Rejected(codes.TOO_LARGE, f"{name}: more than {MAX_PRIMS} prims; export one object alone")
    prims = iter(Usd.PrimRange.Stage(stage, every))
    for prim in prims:
        kind = str(prim.GetTypeName())
        if kind in ("SkelRoot", "BlendShape", "Skeleton"):
            notes.add(codes.FEATURE_IGNORED, kind, "a rig or morph targets: read as it was modelled, without them")
        elif kind in _LEFT_OUT:
            notes.add(codes.FEATURE_IGNORED, kind, _LEFT_OUT[kind])
        imageable = UsdGeom.Imageable(prim)
        if imageable and imageable.GetVisibilityAttr().Get(Usd.TimeCode.EarliestTime()) == UsdGeom.Tokens.invisible:
            notes.add(codes.FEATURE_IGNORED, str(prim.GetPath()), "hidden in the file; left out")
            prims.PruneChildren()
        elif imageable and imageable.ComputePurpose() in (UsdGeom.Tokens.proxy, UsdGeom.Tokens.guide):
            prims.PruneChildren()
        elif prim.IsA(UsdGeom.Mesh):
            yield UsdGeom.Mesh(prim)


class _Reader:
    def __init__(
        self, members: Mapping[str, bytes], folder: str, limits: Mapping[str, float], notes: Notes, name: str
    ) -> None:
        self._limits, self._notes, self._name = limits, notes, name
        self._materials = UsdMaterials(Materials(limits, notes), members, folder)
        self._faces = 0

    def parts(self, mesh: UsdGeom.Mesh) -> Iterator[ReadPart]:
        """A part for each material of a mesh, moved to its place."""
        prim, at = mesh.GetPrim(), Usd.TimeCode.EarliestTime()
        label = prim.GetName()
        points = _array(mesh.GetPointsAttr().Get(at), 3)
        corners = _array(mesh.GetFaceVertexIndicesAttr().Get(at), 1).reshape(-1).astype(np.int64)
        counts = _array(mesh.GetFaceVertexCountsAttr().Get(at), 1).reshape(-1).astype(np.int64)
        if int((counts > 0).sum()) and int(np.maximum(counts, 0).sum()) > len(corners):
            message = f"{self._name}: {printable(label, 40)} has fewer corners than its faces claim; export it again"
            raise Rejected(codes.OUT_OF_BOUNDS, message)
        triangles, owner = cut_polygons(points, corners, counts, self._limits, self._notes, self._name)
        self._faces += len(triangles)
        check_face_count(self._faces, self._limits, self._name)
        is_kept = ~np.isin(owner, _array(mesh.GetHoleIndicesAttr().Get(at), 1).reshape(-1))
        triangles, owner = triangles[is_kept], owner[is_kept]
        scheme = mesh.GetSubdivisionSchemeAttr()
        if scheme.HasAuthoredValue() and scheme.Get() not in (UsdGeom.Tokens.none, None):
            message = f"subdivision ({printable(str(scheme.Get()), 20)}) is not carried out; the mesh is read as stored"
            self._notes.add(codes.FEATURE_IGNORED, "subdivision", message)
        if mesh.GetPointsAttr().GetNumTimeSamples() > 1:
            self._notes.add(codes.FEATURE_IGNORED, "animation", "moving points are left out; the first pose is read")
        world = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(at), dtype=np.float64).T
        normals = named_values(prim, "normals", 3, corners, counts)
        if normals is None:
            attribute = _array(mesh.GetNormalsAttr().Get(at), 3)
            if len(attribute) == len(corners) and len(corners):
                normals = attribute
            elif len(attribute) == len(points) and len(points) and int(corners.max(initial=0)) < len(points):
                normals = attribute[np.maximum(corners, 0)]
        points, moved, is_mirrored = transformed(points, normals, world)
        if is_mirrored != (mesh.GetOrientationAttr().Get(at) == UsdGeom.Tokens.leftHanded):
            triangles = triangles[:, ::-1]
        colors = self._colors(mesh, corners, counts)
        for material, uv_name, chosen in self._by_material(mesh, owner, len(counts), colors is not None):
            uv = named_values(prim, uv_name, 2, corners, counts)
            yield part_of_corners(label, points, corners, triangles[chosen], material, uv, moved, colors)

    def _colors(self, mesh: UsdGeom.Mesh, corners: Ints, counts: Ints) -> Bytes | None:
        primvar = UsdGeom.PrimvarsAPI(mesh.GetPrim()).GetPrimvar("displayColor")
        if not primvar or primvar.GetInterpolation() == UsdGeom.Tokens.constant:
            return None
        values = named_values(mesh.GetPrim(), "displayColor", 3, corners, counts)
        if values is None or not np.isfinite(values).all():
            return None
        return rgba_of_linear(values)

    def _by_material(
        self, mesh: UsdGeom.Mesh, owner: Ints, count: int, is_colored: bool
    ) -> Iterator[tuple[Material, str, Ints]]:
        """Material, name of its texture coordinates, and (T',) triangles, for each material of a mesh."""
        rest = np.ones(count, dtype=bool)
        for subset in UsdShade.MaterialBindingAPI(mesh.GetPrim()).GetMaterialBindSubsets():
            faces = _array(subset.GetIndicesAttr().Get(Usd.TimeCode.EarliestTime()), 1).reshape(-1).astype(np.int64)
            faces = faces[(faces >= 0) & (faces < count)]
            mask = np.zeros(count, dtype=bool)
            mask[faces] = True
            mask &= rest
            rest &= ~mask
            chosen = np.flatnonzero(mask[owner])
            if len(chosen):
                yield (*self._materials.of(subset.GetPrim(), is_colored), chosen)
        chosen = np.flatnonzero(rest[owner])
        if len(chosen) or not len(owner):
            yield (*self._materials.of(mesh.GetPrim(), is_colored), chosen)


def _array(values: object, width: int) -> Floats:
    """(N, width) numbers of an attribute; no rows if it has no value, or one of another shape."""
    if values is None:
        return np.zeros((0, width))
    try:
        out = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):  # a value of a type that USD does not know
        return np.zeros((0, width))
    return out.reshape(-1, width) if out.ndim and out.size % width == 0 else np.zeros((0, width))
