"""report.json of a kitchen, the page that shows it, and the model on the page.

Each of the three depends on separate code. The verdict (`key` in report.json) is that of the checks, which take
minutes. The page (`page_key`) also depends on templates and the viewer, the model (`model_key`) on the writer of GLB.
Only what is outdated is made again.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from casa_assets.cache.cache_key import key_of
from casa_assets.checks.design.grade import Grade
from casa_assets.checks.design.task_view import Afforded
from casa_assets.core.system import kept_json
from casa_assets.formats.gltf import scene_glb
from casa_assets.model.issue import CheckResult, Issue, Report
from casa_assets.model.kitchen.files import EYE_PICTURE, OVERVIEW, ROBOTS_JSON, SCENE_JSON, SHARED
from casa_assets.model.kitchen.floor import ParkingPlace
from casa_assets.model.kitchen.scene import Scene
from casa_assets.model.record import Record, Sha256
from casa_assets.show.page.kitchen_report import page
from casa_assets.show.page.page_template import SUFFIX, ModelFiles, explanations, put_model, put_viewer

REPORT, PAGE = "report.json", "report.html"


class SceneReport(Record):
    """report.json: results of a kitchen's checks, and further measurements.

    Attributes:
        subject: id of the scene. results: one for each check, in the order of codes. issues: every fault.
        passed: no check of severity error failed, or was not run without a waiver.
        tally: counts of checks by status; `advice` of the failed ones are warnings.
        key: digest of everything that decides the verdict.
        page_key: digest of everything that decides how the page shows it.
        model_key: digest of everything that decides the model on the page; null if it has no model.
        grade: findings by the planning guidelines; they are advice. tasks: the 25 atomic tasks of RoboCasa v0.2.
        parking: places before fixtures, metres and radians.
        holds: counts of bodies, joints, shapes, and megabytes of pictures.
        speed: seconds and milliseconds that loading and simulating took.
        robots: robot -> counts, if `scenes robots` has run.
    """

    subject: str
    results: tuple[CheckResult, ...]
    issues: tuple[Issue, ...]
    passed: bool
    tally: dict[str, int]
    key: Sha256
    page_key: Sha256
    model_key: Sha256 | None = None
    grade: Grade
    tasks: tuple[Afforded, ...]
    parking: tuple[ParkingPlace, ...]
    holds: dict[str, float] | None = None
    speed: dict[str, float] | None = None
    robots: dict[str, Any] | None = None


def page_key() -> str:
    """Key of the code that makes a page, without its other inputs, report.json and scene.json."""
    return key_of(_page_of)


def model_key() -> str:
    """Key of the code that makes a model, without its other input, the scene."""
    return key_of(scene_glb, put_model)


def is_page_current(folder: Path) -> bool:
    """True if the page of a checked scene is there as today's code writes it."""
    return (folder / PAGE).is_file() and read_report(folder).get("page_key") == page_key()


def is_model_current(folder: Path) -> bool:
    """True if the model of a checked scene is there as today's code writes it."""
    return _model_script(folder) is not None and read_report(folder).get("model_key") == model_key()


def put_scene_model(folder: Path, scene: Scene) -> str:
    """Write the model of a scene into its folder; returns its key, for report.json."""
    put_model(folder, scene.id, scene_glb(scene, with_layers=True))
    return model_key()


def write_report(folder: Path, data: dict[str, Any]) -> None:
    """Write report.json and report.html of a scene, with the verdict and counts derived from `data`.

    The viewer that the page uses is put into the folder of files that scenes share.
    """
    report = _verdict(data)
    tallied = asdict(report.tally) | {"applying": report.tally.applying}
    data = {**data, "passed": report.passed, "tally": tallied, "page_key": page_key()}
    SceneReport.model_validate(data)
    text = json.dumps(data, indent=1, sort_keys=True, ensure_ascii=False)
    (folder / REPORT).write_text(text + "\n", encoding="utf-8")
    (folder / PAGE).write_text(_page_of(folder, data), encoding="utf-8")


def join_robots(folder: Path) -> None:
    """Copy the robot certificate of this scene, if any, into report.json and report.html in the same folder."""
    facts, robots, data = _read_json(folder / SCENE_JSON), _read_json(folder / ROBOTS_JSON), read_report(folder)
    if not data or not facts or robots.get("scene_key") != facts.get("key"):
        return
    _join(folder, data, robots, {"robots": robots["counts"]})


def join_states(folder: Path, report: Report) -> None:
    """Put what the checks say of the start states of a scene into report.json and report.html, where there are some."""
    data = read_report(folder)
    if data:
        _join(folder, data, report.model_dump(mode="json"), {})


def read_report(folder: Path) -> dict[str, Any]:
    """Content of report.json of a scene; empty where it is not there, damaged, or of another version."""
    data = _read_json(folder / REPORT)
    try:
        SceneReport.model_validate(data)
    except ValidationError:
        return {}
    return data


def kept_report(folder: Path, key: str) -> Report | None:
    """Return the verdict of an earlier run with the same key, or None if there was no such run."""
    data = read_report(folder)
    return _verdict(data) if data.get("key") == key else None


def _verdict(data: dict[str, Any]) -> Report:
    return Report.model_validate({k: data[k] for k in ("subject", "results", "issues")})


def _join(folder: Path, data: dict[str, Any], found: dict[str, Any], added: dict[str, Any]) -> None:
    """Write the report `data` with results and issues of other checks in place of what it said of these."""
    codes = {result["code"] for result in found["results"]}
    results = [r for r in data["results"] if r["code"] not in codes] + found["results"]
    issues = [i for i in data["issues"] if i["code"] not in codes] + found["issues"]
    ordered = sorted(results, key=lambda r: str(r["code"]))
    write_report(folder, {**data, "results": ordered, "issues": issues, **added})


def _page_of(folder: Path, data: dict[str, Any]) -> str:
    """HTML of the page of a scene; puts the viewer in place where there is a model that it shows."""
    script, model = _model_script(folder), None
    if script is not None:
        viewer = f"../{SHARED}/{put_viewer(folder.parent / SHARED)}"
        model = ModelFiles(script.name.removesuffix(SUFFIX), script.name, viewer)
    facts = json.loads((folder / SCENE_JSON).read_text(encoding="utf-8"))
    pictures = (name for name in (f"{OVERVIEW}.png", EYE_PICTURE) if (folder / name).is_file())
    return page(facts, data, explanations(), model, next(pictures, f"{OVERVIEW}.png"))


def _model_script(folder: Path) -> Path | None:
    return min(folder.glob(f"*{SUFFIX}"), default=None)


def _read_json(path: Path) -> dict[str, Any]:
    """Content of a file; empty where it is not there or cannot be read."""
    data = kept_json(path)
    return data if isinstance(data, dict) else {}
