"""Numbers -> the value types of USD. Values that USD stores as float are rounded to float32 only here."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from casa_assets.core.numeric import decimals
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec4


def vec3f(values: Sequence[float] | npt.NDArray[np.float64]) -> Gf.Vec3f:
    """Three floats, rounded to float32."""
    x, y, z = (float(v) for v in values)
    return Gf.Vec3f(x, y, z)


def vec3d(values: Sequence[float] | npt.NDArray[np.float64]) -> Gf.Vec3d:
    """Three doubles, exact."""
    x, y, z = (float(v) for v in values)
    return Gf.Vec3d(x, y, z)


def quatf(quaternion: Vec4) -> Gf.Quatf:
    """(w, x, y, z) -> quaternion, rounded to float32."""
    w, x, y, z = quaternion
    return Gf.Quatf(w, x, y, z)


def quatd(quaternion: Vec4) -> Gf.Quatd:
    """(w, x, y, z) -> quaternion, to twelve digits: the last ones differ from processor to processor."""
    w, x, y, z = (decimals(c, 12) for c in quaternion)
    return Gf.Quatd(w, x, y, z)


def points(array: npt.NDArray[np.float64]) -> Vt.Vec3fArray:
    """(N, 3) float64 -> Vec3fArray."""
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(array, dtype=np.float32))


def coordinates(array: npt.NDArray[np.float64]) -> Vt.Vec2fArray:
    """(N, 2) float64 -> Vec2fArray."""
    return Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(array, dtype=np.float32))


def extent(bounds: npt.NDArray[np.float64]) -> Vt.Vec3fArray:
    """(2, 3) corners -> the value of a boundable's extent."""
    return points(bounds)


def degrees(radians: float) -> float:
    """Radians -> degrees, the unit of every angle in UsdPhysics."""
    return math.degrees(radians)


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


def author(prim: Usd.Prim, name: str, kind: Sdf.ValueTypeName, value: object, uniform: bool = True) -> None:
    """Set an attribute of a schema that this USD build may not have registered (mjc, newton).

    Args:
        prim: carries the schema's name among its apiSchemas.
        name: full attribute name, such as `mjc:condim`.
        kind: declared type.
        value: of that type.
        uniform: whether the schema declares it uniform.
    """
    variability = Sdf.VariabilityUniform if uniform else Sdf.VariabilityVarying
    prim.CreateAttribute(name, kind, custom=False, variability=variability).Set(value)
