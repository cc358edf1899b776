"""Export kitchens several at a time: one that fails is told, and the others go on."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from casa_assets.core.cache_folder import cache_for
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.model.kitchen.scene import Layer, Scene
from casa_assets.pipeline.export.faults import Result
from casa_assets.pipeline.kitchens.recipe import SceneRecipe
from casa_assets.pipeline.kitchens.resolve import WARM, kitchen_key
from casa_assets.pipeline.kitchens.scene_folders import WORKER_BYTES
from casa_assets.pipeline.workers.batch import attempt, run_batch
from casa_assets.pipeline.workers.limits import WorkerFailure

R = TypeVar("R", bound=Result)
# Writes a kitchen below the root of an export, with a folder that keeps built assets.
Export = Callable[[SceneRecipe, Path, Path], R]
# Id of a scene, message, whether the program is to blame -> a result that says so.
Failed = Callable[[str, str, bool], R]


def export_scenes(
    export: Export[R], failed: Failed[R], recipes: Sequence[SceneRecipe], root: Path, jobs: int = 0
) -> Iterator[R]:
    """Yield a result for each scene as they are done, each made in a worker; one that fails does not stop the others.

    Args:
        export, failed: functions of a module. root: folder of the export. jobs: processes; 0 for one per core.
    Raises:
        CasaError: the disk, the renderer or the memory of this machine does not suffice.
    """
    work = partial(export_one, export=export, failed=failed, root=root, cache=cache_for(root))
    for number, answer in run_batch(work, recipes, root, jobs, WARM, WORKER_BYTES):
        if isinstance(answer, WorkerFailure):
            answer = failed(recipes[number].scene_id, answer.text, True)
        yield answer


def measures_of(kitchen: KitchenRequest, scene: Scene) -> dict[str, Any]:
    """Mass in kg of all that stands in a kitchen, without walls and floor, and size of the room in metres."""
    (x0, y0), (x1, y1) = kitchen.room.bounds()
    assets = scene.asset_of
    standing = [assets[place.name] for place in scene.placements if place.layer is not Layer.ROOM]
    return {
        "mass": round(sum(round(asset.mass, 4) for asset in standing), 3),
        "size": [round(x1 - x0, 4), round(y1 - y0, 4), round(kitchen.room.height, 4)],
    }


def export_one(recipe: SceneRecipe, export: Export[R], failed: Failed[R], root: Path, cache: Path) -> R:
    """Export one scene; what is wrong with it is told in the result."""

    def make() -> R:
        done = export(recipe, root, cache)
        kitchen_key(recipe)  # remembered, so that the same export again is known to be there
        return done

    return attempt(make, partial(failed, recipe.scene_id), root)
