"""Numbers -> the value types of USD. Values that USD stores as float are rounded to float32 only here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from casa_assets.core.numeric import decimals
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec4


def vec3f(values: Sequence[float] | npt.NDArray[np.float64]) -> Gf.Vec3f:
    """Three floats, rounded to float32."""
    return Gf.Vec3f(*(float(v) for v in values))


def vec3d(values: Sequence[float] | npt.NDArray[np.float64]) -> Gf.Vec3d:
    """Three doubles, exact."""
    return Gf.Vec3d(*(float(v) for v in values))


def quatf(quaternion: Vec4) -> Gf.Quatf:
    """(w, x, y, z) -> quaternion, rounded to float32."""
    return Gf.Quatf(*quaternion)


def quatd(quaternion: Vec4) -> Gf.Quatd:
    """(w, x, y, z) -> quaternion, to twelve digits: the last ones differ from processor to processor."""
    return Gf.Quatd(*(decimals(c, 12) for c in quaternion))


def points(array: npt.NDArray[np.float64]) -> Vt.Vec3fArray:
    """(N, 3) float64 -> Vec3fArray."""
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(array, dtype=np.float32))


def coordinates(array: npt.NDArray[np.float64]) -> Vt.Vec2fArray:
    """(N, 2) float64 -> Vec2fArray."""
    return Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(array, dtype=np.float32))


def place(prim: Usd.Prim, pose: Pose, scale: Sequence[float] | None = None) -> None:
    """Author translate, orient and scale, in double precision; identity ops are left out.

    Args:
        prim: an Xformable without ops.
        pose: parent_from_prim.
        scale: factors along the prim's own axes, or None.
    """
    xform = UsdGeom.Xformable(prim)
    if any(pose.position):
        xform.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble).Set(vec3d(pose.position))
    if any(pose.quaternion[1:]):
        xform.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(quatd(pose.quaternion))
    if scale is not None:
        xform.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(vec3d(scale))


# Attributes of schemas (mjc, newton) that this USD build may not have registered: declared type, whether uniform.
_FLOAT, _DOUBLE, _INT = Sdf.ValueTypeNames.Float, Sdf.ValueTypeNames.Double, Sdf.ValueTypeNames.Int
_KINDS: dict[str, tuple[Sdf.ValueTypeName, bool]] = {
    **dict.fromkeys(("newton:armature", "newton:damping", "newton:friction"), (_FLOAT, False)),
    **dict.fromkeys(("newton:torsionalFriction", "newton:rollingFriction"), (_FLOAT, False)),
    "newton:massModel": (Sdf.ValueTypeNames.Token, True),
    **dict.fromkeys(("newton:maxHullVertices", "mjc:condim", "mjc:group"), (_INT, True)),
    **dict.fromkeys(("mjc:solimplimit", "mjc:solimpfriction"), (Sdf.ValueTypeNames.DoubleArray, True)),
    **dict.fromkeys(("mjc:stiffness", "mjc:springref", "mjc:margin"), (_DOUBLE, True)),
}


def apply(prim: Usd.Prim, schema: str, values: Mapping[str, object]) -> None:
    """Apply a schema that this USD build may not have registered, and set its attributes by their full names."""
    prim.AddAppliedSchema(schema)
    for name, value in values.items():
        kind, is_uniform = _KINDS[name]
        variability = Sdf.VariabilityUniform if is_uniform else Sdf.VariabilityVarying
        prim.CreateAttribute(name, kind, custom=False, variability=variability).Set(value)
