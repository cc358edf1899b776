"""UsdPreviewSurface -> Material, and primvars -> values of each corner."""

from __future__ import annotations

import posixpath
from collections.abc import Mapping
from typing import Any

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade

from casa_assets.core.typing import Floats, Ints
from casa_assets.ingest.load.diffuse import Look, Materials
from casa_assets.model.asset.material import Material

UV = "st"
# Steps from a surface to its picture: a graph may be a circle.
MAX_STEPS = 8


class UsdMaterials:
    """Materials of one stage.

    Args:
        members: path within the package -> bytes, for pictures. folder: of the main layer, within the package.
    """

    def __init__(self, materials: Materials, members: Mapping[str, bytes], folder: str) -> None:
        self._materials, self._members, self._folder = materials, members, folder
        self._uv: dict[object, str] = {}

    def of(self, prim: Usd.Prim, is_colored: bool) -> tuple[Material, str]:
        """Material of a mesh or of a subset of it, and the name of its texture coordinates."""
        bound = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
        key = (str(bound.GetPath()) if bound else str(prim.GetPath()), is_colored)
        known = self._materials.knows(key)
        if known is None:
            look, uv = self._look(bound) if bound else (_display_look(prim, is_colored), UV)
            self._uv[key] = uv
            known = self._materials.material(key, look)
        return known, self._uv[key]

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
        data = self._bytes(written)
        return ((written, data) if data else None), self._uv_name(source)

    def _bytes(self, written: str) -> bytes | None:
        near = posixpath.normpath(posixpath.join(self._folder, written))
        for path in (near, posixpath.normpath(written), written):
            if path in self._members:
                return self._members[path]
        return None

    def _uv_name(self, texture: UsdShade.Shader) -> str:
        reader = _source(texture, "st")
        for _ in range(MAX_STEPS):
            if reader is None:
                return UV
            if reader.GetInput("varname"):
                return str(_value(reader, "varname", UV) or UV)
            reader = _source(reader, "in")
        return UV


def named_values(prim: Usd.Prim, name: str, width: int, corners: Ints, counts: Ints) -> Floats | None:
    """(C, width) values of a primvar at each corner, or None where it is missing or has another number of values.

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
    raw = primvar.Get(at)
    values = np.asarray(raw, dtype=np.float64).reshape(-1, width) if _fits(raw, width) else np.zeros((0, width))
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


def _fits(raw: Any, width: int) -> bool:
    try:
        return np.asarray(raw, dtype=np.float64).size % width == 0 and raw is not None
    except (TypeError, ValueError):
        return False


def _display_look(prim: Usd.Prim, is_colored: bool) -> Look:
    """Look of a mesh without a material: its display colour, where it is one for the whole mesh."""
    if is_colored:
        return Look("material", (1.0, 1.0, 1.0))
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor")
    raw = primvar.Get(Usd.TimeCode.EarliestTime()) if primvar else None
    shades = np.asarray(raw, dtype=np.float64).reshape(-1) if raw is not None and _fits(raw, 3) else np.zeros(0)
    return Look("display_color", _triple(shades[:3])) if len(shades) >= 3 else Look("material")


def _source(shader: UsdShade.Shader, entry: str) -> UsdShade.Shader | None:
    """Shader that feeds an input, or None."""
    connected = shader.GetInput(entry)
    sources = connected.GetConnectedSources()[0] if connected else []
    if not sources:
        return None
    found = UsdShade.Shader(sources[0].source.GetPrim())
    return found if found else None


def _value(shader: UsdShade.Shader, entry: str, default: Any) -> Any:
    """Value of an input, through interfaces of materials; the default where none is given."""
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
