"""Build scenes and write them as kitchens of a RoboCasa export, several at a time."""

from __future__ import annotations

import os
import shlex
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from casa_assets import registry
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.errors import CasaError
from casa_assets.export.mjcf.scene.kitchen import FILE as SCENE_XML
from casa_assets.export.robocasa.kitchens import description, document
from casa_assets.export.robocasa.kitchens.start_states import translated
from casa_assets.layouts.compose.floor_facts import facts_of
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.scene import Scene
from casa_assets.model.kitchen.start_states import StartStates
from casa_assets.model.registry.contract import RobocasaRelease
from casa_assets.pipeline.export.scenes import export_scenes, measures_of
from casa_assets.pipeline.kitchens.kept import is_whole
from casa_assets.pipeline.kitchens.recipe import SceneRecipe
from casa_assets.pipeline.kitchens.resolve import build_scene
from casa_assets.pipeline.kitchens.scene_folders import scene_key
from casa_assets.pipeline.kitchens.state_file import digest_of_file, read_states, write_states
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.reports import attribution
from casa_assets.projects import read_once


@dataclass(frozen=True)
class KitchenResult:
    """Outcome of the export of one kitchen.

    Attributes:
        id: of the scene. number: by which RoboCasa knows it. fixtures: count by class.
        tasks: atomic tasks that it has the fixtures for.
        credits: of its assets. message: why it failed; is_fault: the program is to blame.
        total: kitchens of the export. measured: its mass and size, see `measures_of`.
    """

    id: str
    number: int = 0
    fixtures: dict[str, int] = field(default_factory=dict)
    tasks: tuple[str, ...] = ()
    credits: tuple[attribution.Credit, ...] = ()
    message: str = ""
    is_fault: bool = False
    total: int = 0
    measured: dict[str, Any] = field(default_factory=dict)


def export_kitchens(
    recipes: Sequence[SceneRecipe], staged: Path, jobs: int = 0, states: Path | None = None
) -> Iterator[KitchenResult]:
    """Write each scene below a staging folder; yields one KitchenResult per scene as they are done.

    A scene that fails, or has the number of an earlier one, has a message and does not stop the others.

    Args:
        jobs: processes; 0 for one per core. states: folder of scenes whose start states are written, too.
    """
    numbers: dict[int, str] = {}
    for result in export_scenes(partial(export_kitchen, states=states), failed_kitchen, recipes, staged, jobs):
        twin = result.id if result.message else numbers.setdefault(result.number, result.id)
        if twin == result.id:
            yield result
        else:
            shutil.rmtree(staged / document.KITCHENS / result.id)
            yield KitchenResult(result.id, message=f"has the same number as {twin}; export them into two folders")


def failed_kitchen(scene_id: str, message: str, is_fault: bool) -> KitchenResult:
    """Outcome for a kitchen that was not written."""
    return KitchenResult(scene_id, message=message, is_fault=is_fault)


def export_kitchen(recipe: SceneRecipe, root: Path, cache: Path, states: Path | None = None) -> KitchenResult:
    """Build one scene and write its files.

    Args:
        root: folder of the export. cache: keeps built assets. states: folder of scenes with start states, or None.
    Raises:
        CasaError: the scene has no start states there, or those of another `scene.xml`.
    """
    kitchen, scene = build_scene(recipe, cache)
    fixtures = description.fixtures_of(scene, classes())
    for placed in fixtures:
        _write_fixture(root / document.FIXTURES / placed.folder, placed.centered)
    folder = root / document.KITCHENS / scene.id
    folder.mkdir(parents=True)
    tasks = afforded_tasks(kitchen, scene)
    disk.write_files(folder, document.write_kitchen(scene, fixtures, tasks))
    if states is not None:
        write_states(folder, translated(_states_of(recipe, states / scene.id), scene, fixtures))
    counts: dict[str, int] = {}
    for placed in fixtures:
        counts[placed.type] = counts.get(placed.type, 0) + 1
    number, sorted_counts = description.number_of(scene.id), dict(sorted(counts.items()))
    measured = measures_of(kitchen, scene)
    return KitchenResult(scene.id, number, sorted_counts, tasks, attribution.credits_of(scene), measured=measured)


def _states_of(recipe: SceneRecipe, folder: Path) -> StartStates:
    """The start states of a scene that stands in a folder of its own, made by today's code."""
    found = read_states(folder)
    if not is_whole(folder, scene_key(recipe)) or digest_of_file(folder / SCENE_XML) != found.scene_xml:
        raise CasaError(
            f"{folder}: its start states are of an older build of the scene; draw them again with "
            f"casa-assets scenes states {folder.name} --out {shlex.quote(str(folder.parent))}"
        )
    return found


def afforded_tasks(kitchen: KitchenRequest, scene: Scene) -> tuple[str, ...]:
    """The atomic tasks of RoboCasa v1.0 for which a kitchen has what they want, as its `scene.json` says."""
    subject = DesignSubject(facts_of(kitchen, scene))
    return tuple(task.task for task in subject.atomic_tasks if not task.wants)


@read_once
def classes() -> dict[str, str]:
    """Contract -> the class of RoboCasa v1.0 that reads it; contracts that none reads are not in it."""
    contracts = registry.load().contracts
    read_by = {name: contract.read_by.get(RobocasaRelease.V1_0, ()) for name, contract in contracts.items()}
    return {name: found[0] for name, found in read_by.items() if found}


def _write_fixture(folder: Path, asset: Asset) -> None:
    """Write a fixture's files unless another kitchen has brought them; the folder appears by one rename."""
    if (folder / document.MODEL).exists():
        return
    draft = folder.with_name(f".{folder.name}.{os.getpid()}")
    folder.parent.mkdir(parents=True, exist_ok=True)
    shutil.rmtree(draft, ignore_errors=True)
    disk.write_files(draft, document.write_fixture(asset))
    try:
        draft.rename(folder)
    except OSError:
        shutil.rmtree(draft)
        if not (folder / document.MODEL).exists():
            raise
