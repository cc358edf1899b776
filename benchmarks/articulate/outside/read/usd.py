"""Read a USD stage with UsdPhysics: rigid bodies, their visible meshes and joints."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from benchmarks.articulate.outside.model import Joint, Link, Model, Unreadable, moved, primitive
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Sphere

_AXES = {"X": np.array([1.0, 0, 0]), "Y": np.array([0, 1.0, 0]), "Z": np.array([0, 0, 1.0])}
BASE = "base"


def read(path: Path, root: Path, values: Mapping[str, float]) -> Model:
    """Read a USD file as it is posed; errors as of `urdf.read`."""
    try:
        stage = Usd.Stage.Open(str(path))
    except Exception as error:
        raise Unreadable(f"USD: {' '.join(str(error).split())[:200]}") from error
    scale = UsdGeom.GetStageMetersPerUnit(stage)
    cache = UsdGeom.XformCache()
    prims = list(Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()))
    bodies = {str(p.GetPath()) for p in prims if p.HasAPI(UsdPhysics.RigidBodyAPI)}
    meshes: dict[str, list[Floats]] = {BASE: [], **{b: [] for b in sorted(bodies)}}
    for prim in prims:
        image = UsdGeom.Imageable(prim)
        if not prim.IsA(UsdGeom.Gprim) or image.ComputePurpose() == "guide" or image.ComputeVisibility() == "invisible":
            continue
        triangles = _triangles(prim)
        if triangles is not None and len(triangles):
            pose = np.array(cache.GetLocalToWorldTransform(prim)).T
            meshes[_body_of(prim, bodies)].append(moved(triangles, pose) * scale)
    edges: list[tuple[str, str, Joint | None]] = []
    for prim in prims:
        if prim.IsA(UsdPhysics.Joint):
            edge = _edge(prim, bodies, stage, cache, scale)
            edges += [] if edge is None else [edge]
    up = _AXES[str(UsdGeom.GetStageUpAxis(stage))]
    return Model(_tree(meshes, edges), up)


def _body_of(prim: Usd.Prim, bodies: set[str]) -> str:
    while prim and not prim.IsPseudoRoot():
        if str(prim.GetPath()) in bodies:
            return str(prim.GetPath())
        prim = prim.GetParent()
    return BASE


def _edge(
    prim: Usd.Prim, bodies: set[str], stage: Usd.Stage, cache: UsdGeom.XformCache, scale: float
) -> tuple[str, str, Joint | None] | None:
    """Return the two bodies of a joint, and how the second moves against the first; None where it joins none."""
    joint = UsdPhysics.Joint(prim)
    first, second = joint.GetBody0Rel().GetTargets(), joint.GetBody1Rel().GetTargets()
    names = [_body_of(stage.GetPrimAtPath(t[0]), bodies) if t else BASE for t in (first, second)]
    if names[0] == names[1]:
        return None
    if not (prim.IsA(UsdPhysics.RevoluteJoint) or prim.IsA(UsdPhysics.PrismaticJoint)):
        return names[0], names[1], None
    slides = prim.IsA(UsdPhysics.PrismaticJoint)
    typed = (UsdPhysics.PrismaticJoint if slides else UsdPhysics.RevoluteJoint)(prim)
    # The frame of the joint in the second body, as it is posed.
    holder = stage.GetPrimAtPath(second[0]) if second else stage.GetPseudoRoot()
    world = np.array(cache.GetLocalToWorldTransform(holder)).T if second else np.eye(4)
    turn = joint.GetLocalRot1Attr().Get() or Gf.Quatf(1)
    place = joint.GetLocalPos1Attr().Get() or Gf.Vec3f(0)
    rotation = world[:3, :3] @ np.array(Gf.Matrix3d(Gf.Rotation(Gf.Quatd(turn)))).T
    axis = rotation @ _AXES[str(typed.GetAxisAttr().Get() or "X")]
    origin = (world[:3, :3] @ np.array(place) + world[:3, 3]) * scale
    low, high = (
        float(v if v is not None else d)
        for v, d in ((typed.GetLowerLimitAttr().Get(), -np.inf), (typed.GetUpperLimitAttr().Get(), np.inf))
    )
    kind = "prismatic" if slides else "revolute"
    if not np.isfinite([low, high]).all():
        kind, low, high = ("prismatic", 0.0, 0.3) if slides else ("continuous", -np.pi, np.pi)
    else:
        low, high = (low * scale, high * scale) if slides else (np.radians(low), np.radians(high))
    unit = axis / np.linalg.norm(axis)
    return names[0], names[1], Joint(prim.GetName(), kind, unit, origin, (low, high))


def _tree(meshes: Mapping[str, list[Floats]], edges: list[tuple[str, str, Joint | None]]) -> dict[str, Link]:
    """Hang all bodies on the one that no joint moves, if it is large, else on the largest."""
    moving = {b for _, b, joint in edges if joint is not None}
    free = [n for n in meshes if n not in moving and (n != BASE or meshes[BASE] or any(e[0] == BASE for e in edges))]
    size = {n: float(np.ptp(np.concatenate(m).reshape(-1, 3), axis=0).prod()) if m else 0.0 for n, m in meshes.items()}
    largest = max(meshes, key=lambda n: size[n])
    root = max(free or [largest], key=lambda n: size[n])
    # Joints may be told from the side of what moves: then nothing but a part is free.
    root = root if size[root] > 0.5 * size[largest] else largest
    links = {root: Link(root, "", None, meshes[root])}
    grown = True
    while grown:
        grown = False
        for a, b, joint in edges:
            if (a in links) == (b in links):
                continue
            if b in links:  # the joint is told from its child's side
                a, b = b, a
                joint = None if joint is None else Joint(joint.name, joint.kind, -joint.axis, joint.origin, joint.range)
            links[b] = Link(b, a, None if joint is None or joint.is_fixed else joint, meshes[b])
            grown = True
    for name in meshes:
        links.setdefault(name, Link(name, root, None, meshes[name]))
    return links


def _triangles(prim: Usd.Prim) -> Floats | None:
    if prim.IsA(UsdGeom.Mesh):
        mesh = UsdGeom.Mesh(prim)
        points = np.array(mesh.GetPointsAttr().Get() or [], dtype=np.float64).reshape(-1, 3)
        counts = np.array(mesh.GetFaceVertexCountsAttr().Get() or [], dtype=np.int64)
        corners = np.array(mesh.GetFaceVertexIndicesAttr().Get() or [], dtype=np.int64)
        first = np.repeat(np.cumsum(counts) - counts, np.maximum(counts - 2, 0))
        step = np.concatenate([np.arange(1, c - 1) for c in counts]) if len(counts) else np.zeros(0, dtype=np.int64)
        faces = np.stack([corners[first], corners[first + step], corners[first + step + 1]], axis=1)
        left_handed = str(mesh.GetOrientationAttr().Get()) == "leftHanded"
        return points[faces[:, ::-1] if left_handed else faces]
    if prim.IsA(UsdGeom.Cube):
        size = float(UsdGeom.Cube(prim).GetSizeAttr().Get())
        return primitive(Box(size=(size, size, size)))
    if prim.IsA(UsdGeom.Sphere):
        return primitive(Sphere(radius=float(UsdGeom.Sphere(prim).GetRadiusAttr().Get())))
    if prim.IsA(UsdGeom.Cylinder) or prim.IsA(UsdGeom.Capsule):
        is_round = prim.IsA(UsdGeom.Capsule)
        round_ = (UsdGeom.Capsule if is_round else UsdGeom.Cylinder)(prim)
        radius, height = float(round_.GetRadiusAttr().Get()), float(round_.GetHeightAttr().Get())
        found = primitive((Capsule if is_round else Cylinder)(radius=radius, height=height))
        order = {"X": [2, 0, 1], "Y": [1, 2, 0], "Z": [0, 1, 2]}[str(round_.GetAxisAttr().Get())]
        return found[:, :, order]
    return None
