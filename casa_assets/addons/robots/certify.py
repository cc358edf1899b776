"""Certify which joints of a kitchen robots reach and open: robots.json in its folder, and a line in the report."""

from __future__ import annotations

import importlib.util
import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from casa_assets import CasaError, Report
from casa_assets.ext.kitchens import ROBOTS_JSON, SCENE_JSON, RobotCertificate, SceneRobots
from casa_assets.ext.libraries import join_robots
from casa_assets.ext.mjcf import SCENE_FILE
from casa_assets.ext.scene_checks import load_registry, load_robot, native_warnings, run_checks, tasks_of
from casa_assets.ext.scenes import (
    SceneRecipe,
    SceneResult,
    digest_of,
    kept_json,
    key_of,
    replace_file,
    require,
    run_recipes,
    scene_key,
    work_on_built,
)

TESTED_ROBOSUITE = "1.5.2"


def find_robot_models() -> Path:
    """The folder of robot models in the installed robosuite, which is not imported. Raises CasaError without it."""
    found = importlib.util.find_spec("robosuite")
    if found is None or found.origin is None:
        raise CasaError(
            "models of robots come from robosuite, which is not installed here; install it "
            f"(python -m pip install --no-deps robosuite=={TESTED_ROBOSUITE}), or name the folder "
            "robosuite/models/assets of one that you have with --models"
        )
    return Path(found.origin).parent / "models" / "assets"


def certify_all(
    recipes: Sequence[SceneRecipe],
    out: Path,
    robots: Sequence[str],
    models: Path,
    jobs: int = 0,
    force: bool = False,
    only: Sequence[str] = (),
) -> Iterator[SceneResult]:
    """Yield certificates of scenes as `run_recipes` does. `only`: globs of joints; empty: all joints.

    Raises CasaError: mink is not installed, or a robot's files are missing; UnknownId: there is no such robot.
    """
    for name in robots:
        robot = load_robot(name)
        for part in robot.parts:
            if not (models / part.file).is_file():
                raise CasaError(
                    f"{models / part.file}: robot {name} needs this file of robosuite {TESTED_ROBOSUITE}, and it is "
                    "not there; name the folder robosuite/models/assets of that version with --models"
                )
    require("mink", "robots", "Inverse kinematics of robots")
    work = partial(certify_one, out=out, robots=tuple(robots), models=models, force=force, only=tuple(only))
    return run_recipes(work, recipes, out, jobs)


def certify_one(
    recipe: SceneRecipe,
    out: Path,
    robots: tuple[str, ...],
    models: Path,
    force: bool = False,
    only: tuple[str, ...] = (),
) -> SceneResult:
    """Certificate of one scene, which is built where it is missing; the report is that of robots alone."""

    def make(built: SceneResult, folder: Path) -> SceneResult:
        begin = time.perf_counter()
        key = certificate_key(recipe, robots, only)
        kept = None if force else read_certificate(folder, key)
        found = kept or certify_scene(folder, robots, models, key, scene_key(recipe), only)
        report = verdict(found)
        _write(folder, found, report)
        join_robots(folder)
        return replace(built, report=report, kept=kept is not None, check_s=time.perf_counter() - begin)

    return work_on_built(recipe, out, make)


def certificate_key(recipe: SceneRecipe, robots: tuple[str, ...], only: tuple[str, ...] = ()) -> str:
    """Key of a certificate: the scene's files, the robots, the joints, and all that decides what is found."""
    try:
        found = version("robosuite")
    except PackageNotFoundError:
        found = ""
    return digest_of("robots", scene_key(recipe), robots, only, found, key_of(certify_scene, verdict))


def certify_scene(
    folder: Path, robots: tuple[str, ...], models: Path, key: str, of_scene: str, only: tuple[str, ...] = ()
) -> SceneRobots:
    """Try robots on every joint of a scene, one after the other. `key`, `of_scene`: of the certificate and the scene.

    Raises CasaError: a robot's file is missing or lacks what its description names, or no joint matches `only`.
    """
    from casa_assets.addons.robots.reach import Bench
    from casa_assets.addons.robots.workspace import Workspace

    facts = json.loads((folder / SCENE_JSON).read_text(encoding="utf-8"))
    tasks, without = tasks_of(facts)
    if only:
        tasks = [task for task in tasks if any(fnmatchcase(task.joint, glob) for glob in only)]
        if not tasks:
            called = " or ".join(only)
            raise CasaError(f"{folder.name}: no joint with a parking place is called {called}; see robots.json")
    found = []
    with native_warnings():
        for name in robots:
            robot = load_robot(name)
            bench = Bench(robot, Workspace(folder / SCENE_FILE, robot, models))
            joints = tuple(bench.work(task) for task in tasks)
            found.append(RobotCertificate(robot=name, shape=robot.shape, drives=robot.drives, joints=joints))
    return SceneRobots(
        scene=facts["id"], key=key, scene_key=of_scene, robots=tuple(found), without_parking=tuple(without), only=only
    )


def verdict(found: SceneRobots) -> Report:
    """Report of the check of robots on one scene."""
    records = load_registry()
    return run_checks(found, found.scene, records.limits, records.waived(found.scene))


def read_certificate(folder: Path, key: str = "") -> SceneRobots | None:
    """Return the certificate in the folder of a scene, or None if there is no certificate with the key asked for."""
    data = kept_json(folder / ROBOTS_JSON)
    try:
        found = SceneRobots.model_validate({k: data[k] for k in SceneRobots.model_fields if k in data})
    except (TypeError, ValueError):
        return None
    return found if key in ("", found.key) else None


def _write(folder: Path, found: SceneRobots, report: Report) -> None:
    without = len(found.without_parking)
    counts = {
        r.robot: {"joints": len(r.joints), "without_parking": without}
        | {key: getattr(r, key) for key in ("reached", "followed", "margin")}
        for r in found.robots
    }
    data = {**found.model_dump(mode="json"), "counts": counts, **report.model_dump(mode="json", exclude={"subject"})}
    text = json.dumps(data, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
    replace_file(folder / ROBOTS_JSON, text.encode())
