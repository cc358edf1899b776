"""What a compiled model collides with and weighs: MuJoCo is the judge, whoever wrote the file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt

from benchmarks.ingest.judging import distance
from casa_assets.geometry.mesh.surface import signed_volume
from casa_assets.geometry.solid.primitive import tessellate
from casa_assets.geometry.solid.solids import convex_hull, union
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Sphere
from casa_assets.model.pose import Pose

Floats = npt.NDArray[np.float64]

SAMPLES = 20_000
SLIT_M = 0.001  # narrower gaps between shapes are not an outer surface
ROUND_STEPS = 96  # a cylinder so drawn lacks 0.07 % of its volume


@dataclass(frozen=True)
class Shapes:
    """Vertices of each convex collision shape, world frame, metres; most vertices of a hull (0: primitives); kg."""

    clouds: list[Floats]
    hull_vertices: int
    mass: float


@dataclass(frozen=True)
class Fit:
    """How well shapes stand in for a surface.

    Attributes:
        volume_ratio: volume of the union over that of the closed mesh, None where it is not closed.
        bare_p95_mm, bare_max_mm: how far the mesh lies outside the shapes.
        phantom_p95_mm, phantom_max_mm: how far the outer surface of the shapes lies from the mesh: openings that
            were closed, walls that were thickened. Slits between shapes are no outer surface.
    """

    volume_ratio: float | None
    bare_p95_mm: float
    bare_max_mm: float
    phantom_p95_mm: float
    phantom_max_mm: float


def of_model(path: Path) -> Shapes:
    """Collision shapes of an MJCF file at its rest pose. Raises ValueError where it does not compile."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    clouds, most = [], 0
    for geom in range(model.ngeom):
        if not (model.geom_contype[geom] or model.geom_conaffinity[geom]):
            continue
        cloud = _cloud(model, geom)
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
            cloud, _ = convex_hull(cloud)
            most = max(most, len(cloud))
        clouds.append(cloud @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom])
    return Shapes(clouds, most, float(model.body_mass.sum()))


def of_clouds(clouds: list[Floats], density: float) -> Shapes:
    """Shapes that no file holds; each weighs its own volume, so that overlaps weigh twice, as in a simulator."""
    shells = [convex_hull(cloud) for cloud in clouds]
    mass = density * sum(signed_volume(*shell) for shell in shells)
    return Shapes([points for points, _ in shells], max(len(points) for points, _ in shells), mass)


def fit(shapes: Shapes, mesh: distance.Surface, volume: float | None) -> Fit | None:
    """Shapes against the mesh that they stand in for; None where they have no volume."""
    whole = union([convex_hull(cloud) for cloud in shapes.clouds])
    if whole is None:
        return None
    points, _ = distance.sample(mesh, SAMPLES)
    skin = distance.touchable(whole, shapes.clouds, SLIT_M, SAMPLES)
    bare = 1000 * distance.outside(points, shapes.clouds, distance.ruler(whole))
    phantom = 1000 * distance.distances(skin, distance.ruler(mesh))
    return Fit(
        volume_ratio=None if volume is None else signed_volume(*whole) / volume,
        bare_p95_mm=float(np.percentile(bare, 95)),
        bare_max_mm=float(bare.max()),
        phantom_p95_mm=float(np.percentile(phantom, 95)),
        phantom_max_mm=float(phantom.max()),
    )


def _cloud(model: mujoco.MjModel, geom: int) -> Floats:
    """Vertices of a geom, its own frame."""
    kind, size = mujoco.mjtGeom(int(model.geom_type[geom])), [float(s) for s in model.geom_size[geom]]
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        start = int(model.mesh_vertadr[mesh])
        vertices: Floats = model.mesh_vert[start : start + int(model.mesh_vertnum[mesh])].astype(np.float64)
        return vertices
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return tessellate(Box(size=(2 * size[0], 2 * size[1], 2 * size[2])), Pose())[0]
    if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        return tessellate(Sphere(radius=size[0]), Pose(), ROUND_STEPS)[0]
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return tessellate(Cylinder(radius=size[0], height=2 * size[1]), Pose(), ROUND_STEPS)[0]
    if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        return tessellate(Capsule(radius=size[0], height=2 * size[1]), Pose(), ROUND_STEPS)[0]
    raise ValueError(f"a collision shape of kind {kind.name} is not measured")
