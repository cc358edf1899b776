"""All checks: one literal row each, by subject; docs/reference/checks.md is printed from them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from casa_assets.checks.check import Check
from casa_assets.checks.run import NO_WAIVERS, report_not_run, run
from casa_assets.checks.scene.subject import SceneSubject
from casa_assets.checks.table import assets, libraries, objects, scenes
from casa_assets.model.issue import Report

TABLE: tuple[Check, ...] = (*assets.ROWS, *objects.ROWS, *libraries.ROWS, *scenes.ROWS)
LOADS = "SCN001"
UNLOADED = "MuJoCo cannot read scene.xml (SCN001)"


def explained(limits: Mapping[str, float]) -> dict[str, str]:
    """Code -> title and description of every check, such as `Overall size: The longest side ...`."""
    return {row.code: f"{row.title}: {row.describe(limits)}" for row in TABLE}


def run_scene(
    subject: SceneSubject,
    limits: Mapping[str, float],
    waived: Mapping[str, str] = NO_WAIVERS,
    table: Iterable[Check] = TABLE,
) -> Report:
    """Report of every check of a scene and its file; where MuJoCo cannot read the file all but the first are not run.

    Args:
        subject: the scene, and the folder it was written to.
        limits: key to number, as registry/limits.yaml has it.
        waived: code -> reason of the checks that are not run on this scene.
        table: rows, of which those of scenes are run.
    Raises:
        KeyError: a row names a limit that the registry does not have.
    """
    rows = [row for row in table if row.subject is SceneSubject]
    name = subject.scene.id
    if not subject.loaded.error:
        return run(subject, name, limits, waived, rows)
    first, rest = [row for row in rows if row.code == LOADS], [row for row in rows if row.code != LOADS]
    return run(subject, name, limits, waived, first) + report_not_run(
        (SceneSubject,), name, limits, UNLOADED, waived, rest
    )
