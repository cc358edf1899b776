"""Collider -> invisible gprim with a collision API."""

from __future__ import annotations

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from casa_assets.export.mujoco_values import VIEWER_GROUPS, contact_dimensions
from casa_assets.export.usd import label, number, visual
from casa_assets.export.usd.material import MaterialPrims
from casa_assets.model.asset.asset import Collider, Link
from casa_assets.model.asset.shape import MAX_HULL_VERTICES, Box, Capsule, Cylinder, Hull, Shape, Sphere


def define_all(stage: Usd.Stage, body: Sdf.Path, link: Link, materials: MaterialPrims) -> None:
    """Colliders of a link below `<body>/collision`."""
    if not link.colliders:
        return
    scope = UsdGeom.Scope.Define(stage, body.AppendChild("collision"))
    # Guides are not rendered, but SimReady counts a collider with the same mesh as a visual (a box, a fixture) as a
    # duplicate unless it is invisible.
    UsdGeom.Imageable(scope).CreateVisibilityAttr(UsdGeom.Tokens.invisible)
    for collider in link.colliders:
        prim = define_shape(stage, scope.GetPath().AppendChild(collider.name), collider.shape)
        _set_collision(prim, collider, materials)


def define_shape(stage: Usd.Stage, path: Sdf.Path, shape: Shape) -> Usd.Prim:
    """Gprim of a shape in its own frame, without xform ops; `place` scales the unit cube of a box."""
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
        cylinder = kind.Define(stage, path)
        cylinder.CreateAxisAttr(UsdGeom.Tokens.z)
        cylinder.CreateRadiusAttr(shape.radius)
        cylinder.CreateHeightAttr(shape.height)
        cap = shape.radius if isinstance(shape, Capsule) else 0.0
        half = np.array([shape.radius, shape.radius, shape.height / 2 + cap])
        cylinder.CreateExtentAttr(number.extent(np.array([-half, half])))
        return cylinder.GetPrim()
    return visual.define_mesh(stage, path, shape.mesh)


def _set_collision(prim: Usd.Prim, collider: Collider, materials: MaterialPrims) -> None:
    """Pose, purpose, collision schemas and friction."""
    number.place(prim, collider.pose, collider.shape.size if isinstance(collider.shape, Box) else None)
    UsdGeom.Imageable(prim).CreatePurposeAttr(UsdGeom.Tokens.guide)
    if collider.label is not None:
        label.attach(prim, label.PART, [collider.label])
    UsdPhysics.CollisionAPI.Apply(prim)
    if prim.IsA(UsdGeom.Mesh):
        hull = isinstance(collider.shape, Hull)
        kind = UsdPhysics.Tokens.convexHull if hull else UsdPhysics.Tokens.none
        UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr(kind)
        if hull:
            prim.AddAppliedSchema("NewtonMeshCollisionAPI")
            number.author(prim, "newton:maxHullVertices", Sdf.ValueTypeNames.Int, MAX_HULL_VERTICES)
    prim.AddAppliedSchema("MjcCollisionAPI")
    number.author(prim, "mjc:condim", Sdf.ValueTypeNames.Int, contact_dimensions(collider.shape))
    number.author(prim, "mjc:group", Sdf.ValueTypeNames.Int, VIEWER_GROUPS.colliders)
    # Twice: PhysX and Newton read the `physics` binding, MuJoCo only the one for all purposes.
    binding = UsdShade.MaterialBindingAPI.Apply(prim)
    material = materials.contacts[collider.substance]
    binding.Bind(material)
    binding.Bind(material, UsdShade.Tokens.weakerThanDescendants, "physics")
