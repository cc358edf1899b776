"""Find scenes that cost too much: bodies, shapes, contacts, memory, time to load and to simulate."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from casa_assets.checks import check
from casa_assets.checks.scene.rest import idle_run
from casa_assets.checks.scene.subject import SceneSubject

MEGABYTE = 1e6


@dataclass(frozen=True)
class MeasuredSpeed:
    """Milliseconds to compile a scene, and steps of one core per second with nothing touched, on this machine."""

    load_ms: float
    steps_per_s: float
    timestep_s: float

    @property
    def pace(self) -> float:
        """Seconds that are simulated in a second."""
        return self.steps_per_s * self.timestep_s


def body_count_is_bounded(subject: SceneSubject, limit: float) -> check.Measurement:
    """SCN010: number of bodies of the model."""
    return _bounded_count(subject.model.nbody, limit, "bodies; merge links that never move against each other")


def collider_count_is_bounded(subject: SceneSubject, limit: float) -> check.Measurement:
    """SCN012: number of collision shapes."""
    return _bounded_count(subject.model.ngeom, limit, "shapes that are touched; merge some, or leave a thing out")


def degrees_of_freedom_are_bounded(subject: SceneSubject, limit: float) -> check.Measurement:
    """SCN013: degrees of freedom of the kitchen, without those of objects that were put into it."""
    added = [place.name for place in subject.scene.objects]
    bodies = subject.model.body_rootid[subject.model.dof_bodyid]
    own = subject.model.nv - int(np.isin(bodies, [subject.model.body(name).id for name in added]).sum())
    return _bounded_count(own, limit, "degrees of freedom; fix what nobody has to move")


def hull_vertex_count_is_bounded(subject: SceneSubject, limit: float) -> check.Measurement:
    """SCN014: vertices of all collision hulls, counted for each time that a hull occurs in the scene."""
    model = subject.model
    hulls = model.geom_dataid[model.geom_type == mujoco.mjtGeom.mjGEOM_MESH]
    return _bounded_count(int(np.sum(model.mesh_vertnum[hulls])), limit, "vertices of hulls; use boxes and cylinders")


def texture_memory_is_bounded(subject: SceneSubject, limit: float) -> check.Measurement:
    """SCN015: megabytes of all pictures, decoded, without mipmaps."""
    model = subject.loaded.model
    if model is None:
        return check.not_run("MuJoCo cannot read scene.xml")
    return _bounded_count(model.ntexdata / MEGABYTE, limit, "MB of pictures; share them, or make them smaller")


def contact_count_is_bounded(subject: SceneSubject, limit: float) -> check.Measurement:
    """SCN016: pairs of shapes in contact at the start and after 1 s, the larger number."""
    run = idle_run(subject)
    return _bounded_count(
        max(len(run.at_start), len(run.settled)), limit, "pairs in contact at rest; set things down on fewer feet"
    )


def load_time_is_bounded(speed: MeasuredSpeed, limit: float) -> check.Measurement:
    """SCN026: milliseconds to compile the whole scene with its pictures."""
    return _bounded_count(speed.load_ms, limit, "ms to load; fewer vertices and smaller pictures load faster")


def simulation_is_fast_enough(speed: MeasuredSpeed, limit: float) -> check.Measurement:
    """SCN027: simulated seconds per second on one core, at rest."""
    message = f"simulates {speed.pace:.2f} s in a second; fewer shapes in contact, fewer joints"
    return check.at_least(speed.pace, limit, "scene", message)


def scene_sizes(subject: SceneSubject) -> dict[str, float]:
    """Sizes of a scene by name: counts, and megabytes of decoded pictures. It has to load."""
    whole, bare = subject.loaded.model, subject.model
    assert whole is not None
    hulls = bare.geom_type == mujoco.mjtGeom.mjGEOM_MESH
    return {
        "bodies": whole.nbody,
        "geoms": whole.ngeom,
        "colliders": bare.ngeom,
        "hulls": int(hulls.sum()),
        "meshes": whole.nmesh,
        "joints": len(subject.joints),
        "nv": whole.nv,
        "textures": whole.ntex,
        "texture_mb": round(whole.ntexdata / MEGABYTE, 3),
    }


def _bounded_count(number: float, limit: float, noun: str) -> check.Measurement:
    return check.at_most(float(number), limit, "scene", f"has {number:,.0f} {noun}")
