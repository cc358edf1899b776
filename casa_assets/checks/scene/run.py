"""Runs the checks of whole scenes."""

from __future__ import annotations

from collections.abc import Mapping

from casa_assets.checks.run import run
from casa_assets.checks.scene.subject import SceneSubject
from casa_assets.checks.table import TABLE
from casa_assets.model.issue import Report

LOADS = "SCN001"


def run_scene(subject: SceneSubject, limits: Mapping[str, float], waived: frozenset[str] = frozenset()) -> Report:
    """Report of every check of a scene and its file; of the first alone where MuJoCo cannot read the file.

    Args:
        subject: the scene, and the folder it was written to.
        limits: key to number, as registry/limits.yaml has it.
        waived: codes that are not run on this scene.
    Raises:
        KeyError: a row names a limit that the registry does not have.
    """
    rows = [row for row in TABLE if row.subject is SceneSubject]
    if subject.loaded.error:
        rows = [row for row in rows if row.code == LOADS]
    return run(subject, subject.scene.id, limits, waived, rows)
