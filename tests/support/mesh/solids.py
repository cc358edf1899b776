"""Closed surfaces and solids built in code, for tests of geometry and of collision shapes."""

from __future__ import annotations

from casa_assets.core.numeric import Floats, Ints
from casa_assets.ingest.collision.decompose import Budget
from casa_assets.mesh.solid.solids import Solid, solid_of, surface_of
from casa_assets.mesh.surface import weld
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.record import Vec3
from tests.support.mesh.meshes import box_mesh, some


def box(size: Vec3, center: Vec3 = (0.0, 0.0, 0.0)) -> Mesh:
    """A box of eight shared corners."""
    return box_mesh(size, center, shared=True)


def welded(mesh: Mesh) -> tuple[Floats, Ints]:
    """Points and faces where equal points are one."""
    points, place = weld(mesh.vertices)
    return points, place[mesh.faces].astype(int)


def solid(mesh: Mesh) -> Solid:
    return some(solid_of(*welded(mesh)))


def block(size: Vec3, center: Vec3 = (0.0, 0.0, 0.0)) -> Solid:
    return solid(box(size, center))


def mesh_of(made: Solid) -> Mesh:
    points, faces = surface_of(made)
    return Mesh(vertices=points, faces=faces)


def never(method: str, points: Floats, faces: Ints, budget: Budget) -> list[Floats]:
    """A decomposer that is not to be asked."""
    raise AssertionError(f"{method} was not needed")
