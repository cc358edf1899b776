"""Draw start states of kitchens: start_states.npz in the folder of each scene, and lines in its report."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from pathlib import Path

from casa_assets import registry
from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.checks.readers.mujoco_facts import native_warnings
from casa_assets.checks.run import run
from casa_assets.checks.start_states.draw import StateRequest, Wanted, draw_states
from casa_assets.checks.start_states.stage import Stage
from casa_assets.checks.start_states.verdict import StatesSubject
from casa_assets.errors import CasaError
from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult
from casa_assets.layouts.run.scene_folders import run_recipes, scene_key, work_on_built
from casa_assets.layouts.run.scene_page import join_states
from casa_assets.layouts.run.state_file import read_states, write_states
from casa_assets.model.issue import Report
from casa_assets.model.kitchen.scene import StartStates


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
    stage = Stage(folder)
    with native_warnings():
        limits = registry.load().limits
        states = draw_states(
            stage, Wanted(states_key(recipe, request), request, limits["state_contact_m"], limits["state_motion_m"])
        )
    write_states(folder, states)
    return read_states(folder), stage


def verdict(states: StartStates, stage: Stage) -> Report:
    """Return the report of the checks of start states, which simulate them again."""
    records = registry.load()
    return run(StatesSubject(states, stage), states.scene, records.limits, records.waived(states.scene))


def states_key(recipe: SceneRecipe, request: StateRequest) -> str:
    """Key of start states: the scene's files, what was asked for, and all that decides what is drawn."""
    return digest_of("start_states", scene_key(recipe), repr(request), version("mujoco"), key_of(draw_states))


def _kept(folder: Path, key: str) -> StartStates | None:
    """Return the states of an earlier run with the same key, or None if they are missing or cannot be read."""
    try:
        found = read_states(folder)
    except CasaError:
        return None
    return found if found.key == key else None
