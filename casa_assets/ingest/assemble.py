"""Build the Asset from a finished draft: origin under its middle, grasps, names, labels, provenance."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from casa_assets.core.numeric import Floats, seven_digits
from casa_assets.errors import DegenerateShape, Rejected
from casa_assets.ingest.draft import Draft, PlacedShape
from casa_assets.mesh.grasps import choose_grasps, grasp_site
from casa_assets.mesh.solid.primitive import shape_bounds
from casa_assets.mesh.solid.solids import convex_hull
from casa_assets.mesh.surface import with_normals
from casa_assets.model.asset.asset import Asset, Base, Collider, Labels, Link, Region, Visual, split_of
from casa_assets.model.asset.material import Material, Substance
from casa_assets.model.asset.parts import Box, Hull, Mesh, MeshShape, Shape
from casa_assets.model.pose import Pose
from casa_assets.model.registry.category import Category
from casa_assets.model.source import Source


def grasp(draft: Draft, category: Category, opening_m: float) -> Draft:
    """The best grasp of each kind that is possible; draft: metres, z up, as it rests, with its mass."""
    assert draft.inertial is not None, "the mass stage ran"
    surface, center = draft.surface, draft.inertial.center_of_mass
    return draft.replace(grasps=choose_grasps(surface.points, surface.welded_faces, center, category, opening_m))


# Assemble -------------------------------------------------------------------------------------------------------------


def assemble(
    draft: Draft,
    asset_id: str,
    category: Category,
    classes: tuple[str, ...],
    substance: Substance,
    source: Source,
    sha256: str,
) -> Asset:
    """Build a rigid asset of one link from a draft that went through every stage.

    The origin goes to the centre of the footprint on the ground. Vertices are rounded to float32, which both formats
    carry exactly. Raises Rejected: nothing to be seen (MSH001) or touched (MSH004) is left at that precision.
    """
    assert draft.inertial is not None, "the mass stage ran"
    vertices = draft.surface.vertices
    lower, upper = vertices.min(axis=0), vertices.max(axis=0)
    shift = _float32(-np.array([(lower[0] + upper[0]) / 2, (lower[1] + upper[1]) / 2, lower[2]]))
    visuals, materials = _visuals(draft, shift, substance)
    colliders = tuple(
        Collider(name=f"object_collider_{i:03d}", shape=shape, pose=pose, substance=substance.id)
        for i, (shape, pose) in enumerate(_all_moved(draft.colliders, shift))
    )
    x, y, z = (seven_digits(float(v)) for v in np.array(draft.inertial.center_of_mass) + shift)
    inertial = draft.inertial.replace(center_of_mass=(x, y, z))
    link = Link(name="object", inertial=inertial, visuals=visuals, colliders=colliders)
    return Asset(
        id=asset_id,
        base=Base.FIXED if category.fixed else Base.FREE,
        links=(link,),
        sites=tuple(grasp_site(grasp, shift) for grasp in draft.grasps),
        regions=(_bounding_region(colliders),),
        materials=materials,
        substances=(substance,),
        labels=Labels(category=category.id, classes=classes, qcode=category.qcode, split=split_of(sha256)),
        provenance=source.provenance(sha256, draft.guesses),
    )


def _visuals(draft: Draft, shift: Floats, substance: Substance) -> tuple[tuple[Visual, ...], tuple[Material, ...]]:
    visuals: list[Visual] = []
    materials: list[Material] = []
    for part in draft.parts:
        mesh = _in_float32(part.mesh if part.mesh.normals is not None else with_normals(part.mesh), shift)
        if not len(mesh.faces):
            continue
        name = f"look_{len(visuals):03d}"
        materials.append(part.material.replace(id=name, substance=substance.id))
        visuals.append(Visual(name=f"object_visual_{len(visuals):03d}", mesh=mesh, material=name))
    if not visuals:
        raise Rejected("MSH001", "no face is left once coordinates have the precision that the formats carry")
    return tuple(visuals), tuple(materials)


def _in_float32(mesh: Mesh, shift: Floats) -> Mesh:
    """The mesh moved and rounded to float32; faces that this collapses are left out."""
    vertices = _float32(mesh.vertices + shift)
    corners = vertices[mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    has_area = np.linalg.norm(cross, axis=1) > 0
    faces = mesh.faces[has_area]
    used, local = np.unique(faces, return_inverse=True)
    normals = None if mesh.normals is None else _float32(_unit(mesh.normals[used]))
    uv = None if mesh.uv is None else _float32(mesh.uv[used])
    out = Mesh(vertices=vertices[used], faces=local.reshape(-1, 3), uv=uv, normals=normals)
    return _with_center(out) if len(used) == 3 else out


def _with_center(mesh: Mesh) -> Mesh:
    """A single triangle cut into three at its centre, since MuJoCo refuses meshes of fewer than four vertices."""
    a, b, c = mesh.faces[0]
    normals = None if mesh.normals is None else np.vstack([mesh.normals, _unit(mesh.normals.sum(axis=0)[None])])
    return Mesh(
        vertices=_float32(np.vstack([mesh.vertices, mesh.vertices.mean(axis=0)])),
        faces=np.array([(a, b, 3), (b, c, 3), (c, a, 3)]),
        uv=None if mesh.uv is None else _float32(np.vstack([mesh.uv, mesh.uv.mean(axis=0)])),
        normals=None if normals is None else _float32(normals),
    )


def _float32(values: Floats) -> Floats:
    """The nearest float32 values."""
    return np.asarray(values, dtype=np.float32).astype(np.float64)


def _unit(normals: Floats) -> Floats:
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(np.where(length > 1e-6, normals / np.maximum(length, 1e-30), np.array([0.0, 0.0, 1.0])))


def _all_moved(placed: tuple[PlacedShape, ...], shift: Floats) -> list[tuple[Shape, Pose]]:
    """The shapes, moved; hulls that rounding makes flat are left out."""
    moved = []
    for collider in placed:
        with suppress(DegenerateShape):
            moved.append(_moved(collider, shift))
    if not moved:
        raise Rejected("MSH004", "no collision shape has a volume once coordinates have the formats' precision")
    return moved


def _moved(placed: PlacedShape, shift: Floats) -> tuple[Shape, Pose]:
    shape, pose = placed.shape, placed.pose
    if isinstance(shape, Hull | MeshShape):
        points = _float32(pose.apply(shape.mesh.vertices) + shift)
        if isinstance(shape, Hull):
            points, faces = convex_hull(points)
            return Hull(mesh=Mesh(vertices=points, faces=faces)), Pose()
        return MeshShape(mesh=Mesh(vertices=points, faces=shape.mesh.faces)), Pose()
    position = tuple(seven_digits(float(v)) for v in np.array(pose.position) + shift)
    quaternion = tuple(seven_digits(q) for q in pose.quaternion)
    pose = Pose(position=position, quaternion=quaternion)
    if isinstance(shape, Box):
        x, y, z = (seven_digits(s) for s in shape.size)
        return Box(size=(x, y, z)), pose
    return shape.replace(**{name: seven_digits(value) for name, value in shape if name != "kind"}), pose


def _bounding_region(colliders: tuple[Collider, ...]) -> Region:
    """The box around all collision shapes, by which RoboCasa places objects."""
    boxes = np.array([shape_bounds(c.shape, c.pose) for c in colliders])
    lower, upper = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
    cx, cy, cz = (seven_digits(float(v)) for v in (lower + upper) / 2)
    sx, sy, sz = (seven_digits(float(v)) for v in upper - lower)
    return Region(name="bbox", pose=Pose(position=(cx, cy, cz)), size=(sx, sy, sz))
