"""What a scene asks of a simulator and of a graphics card."""

from __future__ import annotations

import mujoco
import numpy as np

from casa_assets.checks.check import Measured
from casa_assets.checks.scene.rest import rest
from casa_assets.checks.scene.subject import SceneSubject

MEGABYTE = 1e6
SILENT = Measured()


def has_few_bodies(subject: SceneSubject, limit: float | None) -> Measured:
    """Bodies of the model."""
    return _held(subject.model.nbody, limit, "bodies; merge links that never move against each other")


def has_few_shapes(subject: SceneSubject, limit: float | None) -> Measured:
    """Shapes that are touched."""
    return _held(subject.model.ngeom, limit, "shapes that are touched; merge some, or leave a thing out")


def has_few_freedoms(subject: SceneSubject, limit: float | None) -> Measured:
    """Degrees of freedom: a step costs more than their number."""
    return _held(subject.model.nv, limit, "degrees of freedom; fix what nobody has to move")


def has_few_vertices(subject: SceneSubject, limit: float | None) -> Measured:
    """Vertices of all hulls that are touched, each as often as it stands in the scene."""
    model = subject.model
    hulls = model.geom_dataid[model.geom_type == mujoco.mjtGeom.mjGEOM_MESH]
    return _held(int(np.sum(model.mesh_vertnum[hulls])), limit, "vertices of hulls; use boxes and cylinders")


def has_small_pictures(subject: SceneSubject, limit: float | None) -> Measured:
    """Megabytes of all pictures as they lie in memory, decoded, without mipmaps."""
    model = subject.loaded.model
    if model is None:
        return SILENT
    return _held(model.ntexdata / MEGABYTE, limit, "MB of pictures; share them, or make them smaller")


def touches_little(subject: SceneSubject, limit: float | None) -> Measured:
    """Pairs of shapes that touch as the scene begins and after 1 s, the larger number."""
    stood = rest(subject)
    return _held(
        max(len(stood.begins), len(stood.settled)), limit, "pairs in contact at rest; set things down on fewer feet"
    )


def _held(count: float, limit: float | None, what: str) -> Measured:
    assert limit is not None
    problems = (("scene", f"has {count:,.0f} {what}"),) if count > limit else ()
    return Measured(float(count), problems)
