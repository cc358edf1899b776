"""Find cells that differ between the MJCF and the USD of a scene."""

from __future__ import annotations

from casa_assets.checks.check import Measurement, not_run
from casa_assets.checks.scene.formats.files import SceneFiles
from casa_assets.checks.scene.formats.parity import parity_of


def formats_agree(files: SceneFiles, limit: float | None) -> Measurement:
    """SCN017: number of differing cells: bodies, poses, joints, masses, shapes, filters, labels, places.

    A file that nobody can read is the business of the checks of loading.
    """
    assert limit is not None
    ours, theirs = files.kitchen.loaded.model, files.imported.model
    if ours is None or theirs is None or files.composed[0] is None:
        return not_run("one of scene.xml and scene.usda cannot be read")
    problems = tuple(parity_of(ours, theirs, files.usd))
    return Measurement(float(len(problems)), problems if len(problems) > limit else ())
