"""Collider -> gprim with a collision API, seen by nobody."""

from __future__ import annotations

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from casa_assets.export.usd import label, number, visual
from casa_assets.export.usd.material import MaterialPrims
from casa_assets.model.asset.asset import Collider, Link
from casa_assets.model.asset.shape import MAX_HULL_VERTICES, Box, Capsule, Cylinder, Hull, Shape, Sphere

# MuJoCo's group and contact dimensions, as in model.xml: only rolling friction stops a sphere, and only 6 turns it on.
GROUP = 0
FACETED = 4
ROUND = 6


def define_all(stage: Usd.Stage, body: Sdf.Path, link: Link, looks: MaterialPrims) -> None:
    """Colliders of a link below `<body>/collision`."""
    if not link.colliders:
        return
    scope = UsdGeom.Scope.Define(stage, body.AppendChild("collision"))
    # Guides are not rendered, but a collider that is the very mesh of a visual (a box, a fixture) still counts for
    # SimReady as a duplicate unless it is invisible.
    UsdGeom.Imageable(scope).CreateVisibilityAttr(UsdGeom.Tokens.invisible)
    for item in link.colliders:
        prim = define_shape(stage, scope.GetPath().AppendChild(item.name), item.shape)
        _touch(prim, item, looks)


def define_shape(stage: Usd.Stage, path: Sdf.Path, shape: Shape) -> Usd.Prim:
    """Gprim of a shape, in its own frame and without ops but for the size of a box."""
    if isinstance(shape, Box):
        # A unit cube under a scale; USD has no other box.
        cube = UsdGeom.Cube.Define(stage, path)
        cube.CreateSizeAttr(1.0)
        cube.CreateExtentAttr(number.extent(np.array([[-0.5] * 3, [0.5] * 3])))
        return cube.GetPrim()
    if isinstance(shape, Sphere):
        ball = UsdGeom.Sphere.Define(stage, path)
        ball.CreateRadiusAttr(shape.radius)
        ball.CreateExtentAttr(number.extent(np.array([[-shape.radius] * 3, [shape.radius] * 3])))
        return ball.GetPrim()
    if isinstance(shape, Cylinder | Capsule):
        kind = UsdGeom.Cylinder if isinstance(shape, Cylinder) else UsdGeom.Capsule
        round_ = kind.Define(stage, path)
        round_.CreateAxisAttr(UsdGeom.Tokens.z)
        round_.CreateRadiusAttr(shape.radius)
        round_.CreateHeightAttr(shape.height)
        cap = shape.radius if isinstance(shape, Capsule) else 0.0
        half = np.array([shape.radius, shape.radius, shape.height / 2 + cap])
        round_.CreateExtentAttr(number.extent(np.array([-half, half])))
        return round_.GetPrim()
    return visual.define_mesh(stage, path, shape.mesh)


def _touch(prim: Usd.Prim, item: Collider, looks: MaterialPrims) -> None:
    """Pose, purpose, collision schemas and friction."""
    number.place(prim, item.pose, item.shape.size if isinstance(item.shape, Box) else None)
    UsdGeom.Imageable(prim).CreatePurposeAttr(UsdGeom.Tokens.guide)
    if item.label is not None:
        label.attach(prim, label.PART, [item.label])
    UsdPhysics.CollisionAPI.Apply(prim)
    if prim.IsA(UsdGeom.Mesh):
        hull = isinstance(item.shape, Hull)
        kind = UsdPhysics.Tokens.convexHull if hull else UsdPhysics.Tokens.none
        UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr(kind)
        if hull:
            prim.AddAppliedSchema("NewtonMeshCollisionAPI")
            number.author(prim, "newton:maxHullVertices", Sdf.ValueTypeNames.Int, MAX_HULL_VERTICES)
    prim.AddAppliedSchema("MjcCollisionAPI")
    number.author(prim, "mjc:condim", Sdf.ValueTypeNames.Int, ROUND if isinstance(item.shape, Sphere) else FACETED)
    number.author(prim, "mjc:group", Sdf.ValueTypeNames.Int, GROUP)
    # Twice: PhysX and Newton read the `physics` binding, MuJoCo only the one for all purposes.
    binding = UsdShade.MaterialBindingAPI.Apply(prim)
    material = looks.contacts[item.substance]
    binding.Bind(material)
    binding.Bind(material, UsdShade.Tokens.weakerThanDescendants, "physics")
