"""How fast MuJoCo steps with things that were dropped on a table, by the shapes that they collide with."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from casa_assets.geometry.solid.primitive import tessellate
from casa_assets.ingest.draft import PlacedShape
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Sphere

TABLE_M = (1.6, 1.2, 0.05)  # full size
HEIGHT_M = 0.03
GAP_M = 0.02
SETTLE, STEPS = 300, 700
ROUNDS = 3


@dataclass(frozen=True)
class Pace:
    """How fast it goes with the shapes of a tool.

    Attributes:
        things, shapes: on the table. steps: per second of processor time. contacts: at the end.
    """

    tool: str
    things: int
    shapes: int
    steps: float
    contacts: float

    @property
    def message(self) -> str:
        """In words with numbers."""
        words = f"- {self.tool}: {self.things} things, {self.shapes} shapes"
        return f"{words}: {self.steps:.0f} steps/s, {self.contacts:.0f} contacts"


def compare(made: Mapping[str, Sequence[Sequence[PlacedShape]]]) -> list[Pace]:
    """Steps per second with all things of each tool on a table, the best of some rounds."""
    found = []
    for tool, things in made.items():
        model = table(things)
        paces, contacts = zip(*(_pace(model) for _ in range(ROUNDS)), strict=True)
        found.append(Pace(tool, len(things), model.ngeom - 1, max(paces), float(np.mean(contacts))))
    return found


def table(things: Sequence[Sequence[PlacedShape]]) -> mujoco.MjModel:
    """A table with things in rows a little above it, each free to move."""
    spec = mujoco.MjSpec()
    spec.option.timestep = 0.002
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[s / 2 for s in TABLE_M], pos=[0, 0, -TABLE_M[2] / 2])
    x, y, deep = -TABLE_M[0] / 2, -TABLE_M[1] / 2, 0.0
    for number, shapes in enumerate(things):
        cloud = np.concatenate([tessellate(s.shape, s.pose)[0] for s in shapes])
        low, high = cloud.min(axis=0), cloud.max(axis=0)
        if x + high[0] - low[0] > TABLE_M[0] / 2:
            x, y, deep = -TABLE_M[0] / 2, y + deep + GAP_M, 0.0
        body = spec.worldbody.add_body(pos=[x - low[0], y - low[1], HEIGHT_M - low[2]])
        body.add_freejoint()
        for k, placed in enumerate(shapes):
            _add(spec, body, placed, f"m{number}_{k}")
        x += float(high[0] - low[0]) + GAP_M
        deep = max(deep, float(high[1] - low[1]))
    return spec.compile()


def _add(spec: mujoco.MjSpec, body: mujoco.MjsBody, placed: PlacedShape, name: str) -> None:
    shape, pose = placed.shape, placed.pose
    at = {"pos": list(pose.position), "quat": list(pose.quaternion)}
    if isinstance(shape, Box):
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[s / 2 for s in shape.size], **at)
    elif isinstance(shape, Sphere):
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[shape.radius, 0, 0], **at)
    elif isinstance(shape, Cylinder):
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[shape.radius, shape.height / 2, 0], **at)
    elif isinstance(shape, Capsule):
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=[shape.radius, shape.height / 2, 0], **at)
    else:
        points, faces = tessellate(shape, pose)
        mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX)
        mesh.uservert, mesh.userface = points.ravel().tolist(), faces.ravel().tolist()
        mesh.maxhullvert = 64
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name)


def _pace(model: mujoco.MjModel) -> tuple[float, float]:
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, SETTLE)
    begin = time.process_time()
    mujoco.mj_step(model, data, STEPS)
    return STEPS / (time.process_time() - begin), float(data.ncon)
