"""Link -> rigid body prim with explicit mass properties."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from pxr import Sdf, Usd, UsdGeom, UsdPhysics

from casa_assets.export.usd import collider, number, visual
from casa_assets.export.usd.material import MaterialPrims
from casa_assets.model.asset.asset import Asset, Base, Inertial, Link
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

JACOBI_SWEEPS = 16  # Jacobi on 3x3 converges quadratically; six sweeps reach the last bit


def define(stage: Usd.Stage, path: Sdf.Path, asset: Asset, link: Link, materials: MaterialPrims) -> Usd.Prim:
    """Body prim at `path` with its visuals and colliders. Bodies are siblings, so the pose is asset_from_link."""
    prim = UsdGeom.Xform.Define(stage, path).GetPrim()
    number.place(prim, asset.asset_from_link(link.name))
    UsdPhysics.RigidBodyAPI.Apply(prim)
    _mass(prim, link.inertial)
    if link is asset.root and (len(asset.links) > 1 or asset.base is Base.FIXED):
        # Newton refuses joints, even fixed ones, outside an articulation. Only on the base body do SimReady, MuJoCo and
        # Newton all accept its root.
        UsdPhysics.ArticulationRootAPI.Apply(prim)
    visual.define_all(stage, path, link, materials)
    collider.define_all(stage, path, link, materials)
    return prim


def principal_axes(tensor: npt.NDArray[np.float64]) -> tuple[Vec3, Pose]:
    """Moments and axes of a symmetric tensor by cyclic Jacobi rotations.

    LAPACK is not used: its last bits depend on the processor, and its axes flip if moments are equal. Rotations compose
    to a proper rotation, and a tensor that is already diagonal keeps its axes and their order.

    Args:
        tensor: (3, 3) symmetric, kg*m^2.
    Returns:
        Moments along the axes, and body_from_principal as a pose without translation.
    """
    a = [[float(tensor[i, j]) for j in range(3)] for i in range(3)]
    v = [[float(i == j) for j in range(3)] for i in range(3)]
    for _ in range(JACOBI_SWEEPS):
        for p, q in ((0, 1), (0, 2), (1, 2)):
            if abs(a[p][q]) <= 1e-18 * (abs(a[p][p]) + abs(a[q][q])):
                a[p][q] = a[q][p] = 0.0
                continue
            # Ref: Golub and Van Loan, Matrix Computations, algorithm 8.4.1: the smaller of the two angles.
            tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q])
            t = math.copysign(1.0, tau) / (abs(tau) + math.sqrt(1.0 + tau * tau))
            c = 1.0 / math.sqrt(1.0 + t * t)
            s = t * c
            for k in range(3):
                a[k][p], a[k][q] = c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]
            for k in range(3):
                a[p][k], a[q][k] = c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]
            for k in range(3):
                v[k][p], v[k][q] = c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]
    return (a[0][0], a[1][1], a[2][2]), Pose.from_matrix(np.array(v))


def float32_moments(moments: Vec3) -> Vec3:
    """Moments rounded to float32 that still belong to a body: none exceeds the sum of the other two.

    Rounding the moments of a flat plate, whose largest is that sum, may break this by one unit in the last place.
    """
    values = [np.float32(m) for m in moments]
    largest = max(range(3), key=lambda i: values[i])
    others = [float(values[i]) for i in range(3) if i != largest]
    while float(values[largest]) > sum(others):
        values[largest] = np.nextafter(values[largest], np.float32(0.0))
    x, y, z = (float(m) for m in values)
    return x, y, z


def _mass(prim: Usd.Prim, inertial: Inertial) -> None:
    moments, axes = principal_axes(inertial.tensor)
    mass = UsdPhysics.MassAPI.Apply(prim)
    mass.CreateMassAttr(inertial.mass)
    mass.CreateCenterOfMassAttr(number.vec3f(inertial.center_of_mass))
    mass.CreateDiagonalInertiaAttr(number.vec3f(float32_moments(moments)))
    mass.CreatePrincipalAxesAttr(number.quatf(axes.quaternion))
