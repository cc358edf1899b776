"""Run every check of a scene and write the report into its folder; draw its start states, with their own checks."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterator, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from casa_assets import registry
from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.checks import simready
from casa_assets.checks.check import load_table, report_not_run, run
from casa_assets.checks.design.grade import grade
from casa_assets.checks.design.subject import DesignSubject, floor_picture
from casa_assets.checks.readers.mujoco_facts import native_warnings
from casa_assets.checks.scene.formats import SceneFiles
from casa_assets.checks.scene.placement import Pixels, PreviewImages
from casa_assets.checks.scene.rest import MeasuredSpeed, scene_sizes
from casa_assets.checks.scene.subject import SceneSubject, steps_per_second
from casa_assets.checks.start_states.draw import StateRequest, Wanted, draw_states
from casa_assets.checks.start_states.stage import Stage, StatesSubject
from casa_assets.checks.table import UNLOADED, run_scene
from casa_assets.core.system import cache_for
from casa_assets.errors import CasaError
from casa_assets.formats.mjcf.kitchen import FILE
from casa_assets.layouts.run import scene_folders
from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult
from casa_assets.layouts.run.resolve import build_scene
from casa_assets.layouts.run.scene_folders import (
    BUILD,
    CHECK,
    OVERVIEW_FRAME,
    BuildOptions,
    attempt_scene,
    build_with_options,
    remove_scene,
    run_recipes,
    scene_key,
    work_on_built,
)
from casa_assets.layouts.run.scene_json import design_of
from casa_assets.layouts.run.scene_page import (
    is_model_current,
    is_page_current,
    join_robots,
    join_states,
    kept_report,
    put_scene_model,
    read_report,
    write_report,
)
from casa_assets.layouts.run.state_file import read_states, write_states
from casa_assets.model.issue import Report
from casa_assets.model.kitchen.files import START_STATES
from casa_assets.model.kitchen.scene import Scene, StartStates
from casa_assets.registry.plugins.checks import check_table, with_plugin_limits
from casa_assets.runs.limits import StepClock
from casa_assets.runs.pool import Workers
from casa_assets.show.stills import kitchen as room

FLOOR_MAP = "floor_map.png"
# Enough to see whether a camera shows something, by its shares of black and white pixels.
CHECK_FRAME = room.PictureSettings(240, 180, passes=1, shadow_px=256)


class PassedLayers:
    """Digests of layers of assets that passed SimReady's rules, an empty file for each in a folder of the cache."""

    def __init__(self, cache: Path) -> None:
        self.folder = cache / "simready"

    def has(self, digest: str) -> bool:
        """True if a layer of that digest passed."""
        return (self.folder / digest[:2] / digest).is_file()

    def add(self, digests: Collection[str]) -> None:
        """Remember layers that passed."""
        for digest in digests:
            path = self.folder / digest[:2] / digest
            with suppress(OSError):  # a cache that cannot be written to: the layer is looked at again
                path.parent.mkdir(parents=True, exist_ok=True)
                path.touch()


def check_one(
    recipe: SceneRecipe,
    out: Path,
    force: bool = False,
    strict: bool = False,
    drawn: bool = True,
    in_3d: bool = True,
    frame: room.PictureSettings = OVERVIEW_FRAME,
    at_eye_level: bool = False,
) -> SceneResult:
    """Build a scene where it is missing or outdated, and run every check on it; `report.json` keeps the verdict.

    A scene that has not changed since it was checked is not checked again. `force`: check it again. `strict`: what does
    not pass is not put in place. `drawn`: with an overview; the check of what cameras see draws its own, small, and
    keeps none. `in_3d`: with a model that the page shows in 3D, about 4 MB. `frame`, `at_eye_level`: see BuildOptions.
    """
    judge = partial(check_and_report, in_3d=in_3d, passed=PassedLayers(cache_for(out)))
    options = BuildOptions(drawn, at_eye_level, judge=judge, strict=strict, frame=frame)
    done = build_with_options(recipe, out, options)
    if done.report is not None or not done.folder:
        return done
    folder = Path(done.folder)
    report = None if force else kept_report(folder, verdict_key(recipe))
    if report is not None:
        done = _shown_in_place(SceneResult(recipe, done.folder, report=report, kept=True), out, folder, in_3d)
    else:
        done = _checked_in_place(recipe, out, folder, in_3d)
    if strict and done.report is not None and not done.passed:
        remove_scene(out, recipe.scene_id)
        return replace(done, folder="", kept=False)
    return done


def _shown_in_place(done: SceneResult, out: Path, folder: Path, in_3d: bool) -> SceneResult:
    """Make the page of a scene whose verdict is kept, or the model on it, again where other code has made them."""
    with_model = in_3d and not is_model_current(folder)
    if not with_model and is_page_current(folder):
        return done

    def make() -> SceneResult:
        added = {}
        if with_model:
            _, scene = build_scene(done.recipe, cache_for(out))
            added = {"model_key": put_scene_model(folder, scene)}
        write_report(folder, {**read_report(folder), **added})
        return done

    return attempt_scene(done.recipe, out, make)


def _checked_in_place(recipe: SceneRecipe, out: Path, folder: Path, in_3d: bool) -> SceneResult:

    def make() -> SceneResult:
        clock = StepClock()
        kitchen, scene = build_scene(recipe, cache_for(out))
        clock.end(BUILD)
        passed = PassedLayers(cache_for(out))
        report = check_and_report(recipe, scene, design_of(kitchen, scene), folder, in_3d, passed)
        clock.end(CHECK)
        build_s, check_s = clock.wall_s[BUILD], clock.wall_s[CHECK]
        return SceneResult(recipe, str(folder), report=report, build_s=build_s, check_s=check_s, cpu_s=clock.cpu_s)

    return attempt_scene(recipe, out, make)


def check_and_report(
    recipe: SceneRecipe,
    scene: Scene,
    design: DesignSubject,
    folder: Path,
    in_3d: bool = True,
    passed: PassedLayers | None = None,
) -> Report:
    """Run every check on a scene in its folder, and leave report, page and pictures there; see `check_one`."""
    report, measured = run_checks_on_scene(scene, design, folder, passed)
    model = put_scene_model(folder, scene) if in_3d else read_report(folder).get("model_key")
    floor_picture(design).save(folder / FLOOR_MAP, format="PNG")
    keys = {"key": verdict_key(recipe), "model_key": model}
    write_report(folder, {**report.model_dump(mode="json"), **measured, **keys})
    join_robots(folder)
    return report


def verdict_key(recipe: SceneRecipe) -> str:
    """Key of the verdict on a scene: its files, and all that decides what the checks say of them."""
    return digest_of("verdict", scene_key(recipe), key_of(run_checks_on_scene, floor_picture))


def run_checks_on_scene(
    scene: Scene, design: DesignSubject, folder: Path, passed: PassedLayers | None = None
) -> tuple[Report, dict[str, Any]]:
    """Run every check on a scene in its folder, which is only read.

    Args:
        passed: layers of assets that passed in other scenes; None: each is looked at.
    Returns:
        The report, and what was measured besides, for report.json: grade, tasks, parking places, budgets, speed.
    """
    begin, records = time.perf_counter(), registry.load()
    limits, waived, table = with_plugin_limits(records.limits), records.waived(scene.id), check_table()
    subject = SceneSubject(scene, folder)
    report = run_scene(subject, limits, waived, table)
    for part in (SceneFiles(subject, passed), design):
        report += run(part, scene.id, limits, waived, table)
    measured: dict[str, Any] = {
        "grade": grade(design).model_dump(mode="json"),
        "tasks": [t.model_dump(mode="json") for t in design.tasks],
        "parking": [p.model_dump(mode="json") for p in design.parking.every],
    }
    model = subject.loaded.model
    if model is not None:
        with native_warnings():  # SCN001 reports them
            steps_per_s = steps_per_second(model)
        speed = MeasuredSpeed(subject.load_s * 1000.0, steps_per_s, float(model.opt.timestep))
        for measurable in (speed, _views(model, folder)):
            report += run(measurable, scene.id, limits, waived, table)
        numbers = {
            "load_ms": round(speed.load_ms, 1),
            "steps_per_s": round(speed.steps_per_s, 1),
            "real_time_factor": round(speed.pace, 2),
            "check_s": round(time.perf_counter() - begin, 1),
        }
        measured |= {"holds": scene_sizes(subject), "speed": numbers}
    else:
        report += report_not_run((MeasuredSpeed, PreviewImages), scene.id, limits, UNLOADED, waived)
    if (folder / START_STATES).is_file():
        report += run(StatesSubject(read_states(folder), Stage(folder)), scene.id, limits, waived, table)
    ordered = sorted(report.results, key=lambda r: r.code)
    return report.replace(results=tuple(ordered)), measured


def _views(model: Any, folder: Path) -> PreviewImages:
    """A picture of each camera of an MjModel: the preview where there is one, else one drawn small, not kept."""
    stage = room.scene_from_model(copy(model), str(folder / FILE), frame=CHECK_FRAME)
    images: dict[str, Pixels] = {}
    for name in stage.cameras:
        path = folder / f"{name}.png"
        if path.is_file():
            with Image.open(path) as opened:
                images[name] = np.asarray(opened.convert("RGB"))
    rest = [name for name in stage.cameras if name not in images]
    return PreviewImages({**images, **dict(room.render_cameras(stage, rest, CHECK_FRAME))})


def check_all(
    recipes: Sequence[SceneRecipe],
    out: Path,
    jobs: Workers = 0,
    force: bool = False,
    drawn: bool = True,
    in_3d: bool = True,
    at_eye_level: bool = False,
) -> Iterator[SceneResult]:
    """Yield checked scenes as `run_recipes` does; see `check_one`."""
    work = partial(check_one, out=out, force=force, drawn=drawn, in_3d=in_3d, at_eye_level=at_eye_level)
    return run_recipes(work, recipes, out, jobs, warm)


def warm() -> None:
    """Load what every worker that checks scenes needs, once for all of them; nothing here may draw."""
    scene_folders.warm()
    simready.warm()
    load_table()


def draw_all(
    recipes: Sequence[SceneRecipe], out: Path, request: StateRequest, jobs: int = 0, force: bool = False
) -> Iterator[SceneResult]:
    """Yield start states of scenes as `run_recipes` does. `force`: even where nothing has changed."""
    return run_recipes(partial(draw_one, out=out, request=request, force=force), recipes, out, jobs)


def draw_one(recipe: SceneRecipe, out: Path, request: StateRequest, force: bool = False) -> SceneResult:
    """Start states of one scene, which is built where it is missing; the report is that of its start states alone."""

    def make(built: SceneResult, folder: Path) -> SceneResult:
        begin = time.perf_counter()
        kept = None if force else _kept(folder, states_key(recipe, request))
        states, stage = (kept, Stage(folder)) if kept else draw_now(recipe, folder, request)
        drawn = time.perf_counter()
        report = verdict(states, stage)
        join_states(folder, report)
        counts = {"states": float(len(states)), "refused": float(sum(states.refused.values()))}
        done = replace(built, report=report, kept=kept is not None, counts=counts)
        return replace(done, draw_s=drawn - begin, check_s=time.perf_counter() - drawn)

    return work_on_built(recipe, out, make)


def draw_now(recipe: SceneRecipe, folder: Path, request: StateRequest) -> tuple[StartStates, Stage]:
    """Draw start states of a scene that was built, and write them into its folder. Raises as `draw_states` does."""
    stage, limits = Stage(folder), registry.load().limits
    wanted = Wanted(states_key(recipe, request), request, limits["state_contact_m"], limits["state_motion_m"])
    with native_warnings():
        write_states(folder, draw_states(stage, wanted))
    return read_states(folder), stage


def verdict(states: StartStates, stage: Stage) -> Report:
    """Return the report of the checks of start states, which simulate them again."""
    records = registry.load()
    return run(StatesSubject(states, stage), states.scene, records.limits, records.waived(states.scene))


def states_key(recipe: SceneRecipe, request: StateRequest) -> str:
    """Key of start states: the scene's files, what was asked for, and all that decides what is drawn."""
    return digest_of("start_states", scene_key(recipe), repr(request), version("mujoco"), key_of(draw_states))


def _kept(folder: Path, key: str) -> StartStates | None:
    try:
        found = read_states(folder)
    except CasaError:
        return None
    return found if found.key == key else None
