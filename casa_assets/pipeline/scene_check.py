"""Every check of a built scene; the verdict beside its files."""

from __future__ import annotations

import io
import json
import os
import time
import traceback
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from casa_assets import registry
from casa_assets.checks.design.grade import grade
from casa_assets.checks.design.picture import floor_picture
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.checks.run import run
from casa_assets.checks.scene.run import run_scene
from casa_assets.checks.scene.subject import SceneSubject
from casa_assets.errors import CasaError
from casa_assets.layouts.facts import facts_of
from casa_assets.layouts.request import Kitchen
from casa_assets.model.issue import Report
from casa_assets.model.scene import Scene
from casa_assets.pipeline import library as disk
from casa_assets.pipeline.books.kitchen_report import page
from casa_assets.pipeline.kitchens import Recipe, build_scene
from casa_assets.pipeline.scenes import FACTS, SceneBuilt, build_one
from casa_assets.pipeline.source_key import key_of

REPORT, PAGE, MAP = "report.json", "report.html", "floor_map.png"


def check_one(recipe: Recipe, out: Path, anew: bool = False) -> SceneBuilt:
    """Build a scene where it is missing or outdated, and run every check on it; `report.json` keeps the verdict.

    A scene that has not changed since it was checked is not checked again.
    """
    try:
        made = build_one(recipe, out)
        if not made.folder:
            return made
        folder = Path(made.folder)
        kept = None if anew or not made.kept else _kept(folder, key_of(recipe))
        if kept is not None:
            return SceneBuilt(recipe, made.folder, report=kept, kept=True)
        begin = time.perf_counter()
        kitchen, scene = build_scene(recipe, disk.Library(out).cache)
        report, facts = check(kitchen, scene, folder)
        facts["key"] = key_of(recipe)
        _write(folder, report, facts)
        return SceneBuilt(
            recipe,
            made.folder,
            report=report,
            build_s=made.build_s,
            write_s=made.write_s,
            draw_s=made.draw_s,
            check_s=time.perf_counter() - begin,
            counts=made.counts,
        )
    except CasaError as error:
        return SceneBuilt(recipe, says=str(error))
    except Exception:  # noqa: BLE001  a batch does not die of one scene; the whole trace is told
        return SceneBuilt(recipe, says=traceback.format_exc(limit=-4))


def check(kitchen: Kitchen, scene: Scene, folder: Path) -> tuple[Report, dict[str, Any]]:
    """The report of a scene in its folder, and what was measured besides: grade, tasks, parking places.

    A picture of the floor is put into the folder.
    """
    limits = registry.load().limits
    design = DesignSubject(facts_of(kitchen, scene))
    report = run_scene(SceneSubject(scene, folder), limits) + run(design, scene.id, limits)
    picture = io.BytesIO()
    floor_picture(design).save(picture, format="PNG")
    (folder / MAP).write_bytes(picture.getvalue())
    measured = {
        "grade": grade(design).model_dump(mode="json"),
        "tasks": [t.model_dump(mode="json") for t in design.tasks],
        "parking": [p.model_dump(mode="json") for p in design.lots.every],
    }
    return report, measured


def _write(folder: Path, report: Report, measured: dict[str, Any]) -> None:
    data = {**report.model_dump(mode="json"), "passed": report.passed, **measured}
    text = json.dumps(data, indent=1, sort_keys=True, ensure_ascii=False)
    (folder / REPORT).write_text(text + "\n", encoding="utf-8")
    facts = json.loads((folder / FACTS).read_text(encoding="utf-8"))
    (folder / PAGE).write_text(page(facts, data), encoding="utf-8")


def _kept(folder: Path, key: str) -> Report | None:
    """The verdict of an earlier run with the same key."""
    try:
        data = json.loads((folder / REPORT).read_text(encoding="utf-8"))
        if data.get("key") != key:
            return None
        return Report.model_validate({k: data[k] for k in ("subject", "results", "issues")})
    except (OSError, ValueError, KeyError):
        return None


def check_all(recipes: Sequence[Recipe], out: Path, jobs: int = 0, anew: bool = False) -> Iterator[SceneBuilt]:
    """Scenes in the order in which they are done, worked on by several processes.

    Raises:
        OutputError: the folder is held by another run or cannot be written.
    """
    place = disk.Library(out)
    count = min(jobs or os.cpu_count() or 1, max(1, len(recipes)))
    with place.locked():
        place.sweep()
        with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:
            for done in as_completed([pool.submit(check_one, r, out, anew) for r in recipes]):
                yield done.result()
