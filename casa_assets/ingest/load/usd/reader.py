"""A USD stage -> RawModel: meshes at their places, instances expanded, one part for each material."""

from __future__ import annotations

import posixpath
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade

from casa_assets.core.typing import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.diffuse import Materials
from casa_assets.ingest.load.formats import Format
from casa_assets.ingest.load.image import srgb_bytes_from_linear
from casa_assets.ingest.load.notes import Notes, printable
from casa_assets.ingest.load.polygons import cut_polygons, part_of_corners
from casa_assets.ingest.load.raw_parts import Bytes, ReadPart, check_face_count, raw_model, transformed
from casa_assets.ingest.load.usd.crate import check_crate
from casa_assets.ingest.load.usd.layers import FAULTS, MOST_UP, broken, checked, inside, unpacked
from casa_assets.ingest.load.usd.materials import UsdMaterials, named_values
from casa_assets.model.asset.material import Material
from casa_assets.model.ingest.source import Bundle, RawModel, Up

# Prims of a stage with its instances expanded; references that double at each of many levels make more.
MAX_PRIMS = 20_000
_UPS = {"Y": Up.Y, "Z": Up.Z}
_LEFT_OUT = {
    "PointInstancer": "points at which things are repeated are left out; make instances of them real",
    "BasisCurves": "curves are left out; convert them to meshes",
    "NurbsPatch": "NURBS are left out; convert them to meshes",
    **dict.fromkeys(("Cube", "Sphere", "Cylinder", "Cone", "Capsule"), "a shape without a mesh; convert it to one"),
}


def read_usd(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of a USD, USDA, USDC or USDZ: its stated unit (none stated: centimetres, as USD has it) and up axis.

    The layers are written into a temporary folder, as the library of USD reads no bytes.

    Raises:
        Rejected: SCENE_UNREADABLE, BAD_ARCHIVE, PATH_TRAVERSAL, NETWORK_URI, MISSING_FILE, TOO_LARGE, OUT_OF_BOUNDS,
            NO_GEOMETRY, NO_FACES, NON_FINITE.
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
            up = _UPS.get(str(UsdGeom.GetStageUpAxis(stage)).upper())
            metres = float(UsdGeom.GetStageMetersPerUnit(stage))
        except FAULTS as error:  # a crate is read piece by piece, so that a broken one may be found at any of these
            raise broken(name) from error
    stated = metres if np.isfinite(metres) and metres > 0.0 else None
    return raw_model(parts, notes, name, Format.USD, stated, up)


def _open(main: str, members: Mapping[str, bytes], folder: Path, name: str) -> Usd.Stage:
    """The stage; its layers were looked at, each by itself, and name none but each other."""
    kept: list[Sdf.Layer] = []
    for path, data in members.items():
        if data.startswith((b"PXR-USDC", b"#usda")):
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
    for number, _ in enumerate(Usd.PrimRange.Stage(stage, every), start=1):
        if number > MAX_PRIMS:
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
    """Reads the meshes of one stage."""

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
        triangles, owner = self._without_holes(mesh, triangles, owner)
        self._remark(mesh)
        world = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(at), dtype=np.float64).T
        normals = self._normals(mesh, points, corners, counts)
        points, moved, is_mirrored = transformed(points, normals, world)
        if is_mirrored != (mesh.GetOrientationAttr().Get(at) == UsdGeom.Tokens.leftHanded):
            triangles = triangles[:, ::-1]
        colors = self._colors(mesh, corners, counts)
        for material, uv_name, chosen in self._by_material(mesh, owner, len(counts), colors is not None):
            uv = named_values(prim, uv_name, 2, corners, counts)
            yield part_of_corners(label, points, corners, triangles[chosen], material, uv, moved, colors)

    def _without_holes(self, mesh: UsdGeom.Mesh, triangles: Ints, owner: Ints) -> tuple[Ints, Ints]:
        holes = _array(mesh.GetHoleIndicesAttr().Get(Usd.TimeCode.EarliestTime()), 1).reshape(-1)
        is_kept = ~np.isin(owner, holes)
        return triangles[is_kept], owner[is_kept]

    def _remark(self, mesh: UsdGeom.Mesh) -> None:
        scheme = mesh.GetSubdivisionSchemeAttr()
        if scheme.HasAuthoredValue() and scheme.Get() not in (UsdGeom.Tokens.none, None):
            message = f"subdivision ({printable(str(scheme.Get()), 20)}) is not carried out; the mesh is read as stored"
            self._notes.add(codes.FEATURE_IGNORED, "subdivision", message)
        if mesh.GetPointsAttr().GetNumTimeSamples() > 1:
            self._notes.add(codes.FEATURE_IGNORED, "animation", "moving points are left out; the first pose is read")

    def _normals(self, mesh: UsdGeom.Mesh, points: Floats, corners: Ints, counts: Ints) -> Floats | None:
        found = named_values(mesh.GetPrim(), "normals", 3, corners, counts)
        if found is None:
            attribute = _array(mesh.GetNormalsAttr().Get(Usd.TimeCode.EarliestTime()), 3)
            if len(attribute) == len(corners) and len(corners):
                found = attribute
            elif len(attribute) == len(points) and len(points) and int(corners.max(initial=0)) < len(points):
                found = attribute[np.maximum(corners, 0)]
        return found

    def _colors(self, mesh: UsdGeom.Mesh, corners: Ints, counts: Ints) -> Bytes | None:
        primvar = UsdGeom.PrimvarsAPI(mesh.GetPrim()).GetPrimvar("displayColor")
        if not primvar or primvar.GetInterpolation() == UsdGeom.Tokens.constant:
            return None
        values = named_values(mesh.GetPrim(), "displayColor", 3, corners, counts)
        if values is None or not np.isfinite(values).all():
            return None
        out = np.full((len(values), 4), 255, dtype=np.uint8)
        out[:, :3] = srgb_bytes_from_linear(values)
        return out

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
    """(N, width) numbers of an attribute; none where it has no value, or one of another shape."""
    if values is None:
        return np.zeros((0, width))
    try:
        out = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):  # a value of a type that USD does not know
        return np.zeros((0, width))
    return out.reshape(-1, width) if out.ndim and out.size % width == 0 else np.zeros((0, width))
