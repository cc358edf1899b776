"""What became of each draw, kept in the cache of a folder of scenes: a run that was stopped goes on from there.

<out>/.casa/cache/draws/<id>.json, written when a draw is done, by one rename. A kitchen that was accepted stands in its
folder; a refused one leaves nothing but its record here. Without the records, refused draws are made once more.
"""

from __future__ import annotations

from pathlib import Path

from pydantic import ValidationError

from casa_assets.model.issue import Issue, Report
from casa_assets.model.record import Record
from casa_assets.pipeline.kitchens.recipe import SceneRecipe, SceneResult
from casa_assets.pipeline.library.library import Library
from casa_assets.pipeline.process_name import process_name

FOLDER = "draws"


class DrawRecord(Record):
    """What became of one draw.

    Attributes:
        id: of the scene. key: of the verdict; a record of another key tells of code or data that are no more.
        passed: whether it was accepted. message, issues: why not.
        cpu_s: processor seconds by step.
    """

    id: str
    key: str
    passed: bool
    message: str = ""
    issues: tuple[Issue, ...] = ()
    cpu_s: dict[str, float]


def read_draw(out: Path, recipe: SceneRecipe, key: str) -> DrawRecord | None:
    """The record of a draw under that key; None where there is none, or it is damaged."""
    try:
        record = DrawRecord.from_json(_path(out, recipe.scene_id).read_text(encoding="utf-8"))
    except (OSError, ValidationError):
        return None
    return record if record.key == key else None


def keep_draw(out: Path, done: SceneResult, key: str) -> None:
    """Keep what became of a draw. A fault of the program is not kept: the draw is made again.

    Raises OSError where the folder cannot be written to.
    """
    if done.is_fault:
        return
    record = DrawRecord(
        id=done.recipe.scene_id,
        key=key,
        passed=done.passed,
        message=done.message,
        issues=done.problems,
        cpu_s=done.cpu_s,
    )
    path = _path(out, record.id)
    path.parent.mkdir(parents=True, exist_ok=True)
    fresh = path.with_name(f".{path.name}.{process_name()}")
    fresh.write_text(record.to_json() + "\n", encoding="utf-8")
    fresh.replace(path)


def refused_before(record: DrawRecord, recipe: SceneRecipe) -> SceneResult:
    """The result of a draw that an earlier run refused."""
    report = Report(subject=record.id, issues=record.issues) if record.issues else None
    return SceneResult(recipe, message=record.message, report=report, cpu_s=record.cpu_s, kept=True)


def _path(out: Path, scene_id: str) -> Path:
    return Library(out).cache / FOLDER / f"{scene_id}.json"
