"""Both files of a scene tell of the same kitchen."""

from __future__ import annotations

from casa_assets.checks.check import Measured
from casa_assets.checks.scene.subject import SceneSubject
from casa_assets.checks.scene_parity import scene_parity

USD = "scene.usda"


def formats_agree(subject: SceneSubject, limit: float | None) -> Measured:
    """How many cells of the fact tables differ: bodies, poses, joints, masses, shapes, filters, labels, places."""
    assert limit is not None
    problems = tuple(scene_parity(subject.mjcf, subject.root / USD))
    return Measured(float(len(problems)), problems if len(problems) > limit else ())
