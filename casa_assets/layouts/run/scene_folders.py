"""Build, draw and check scenes on disk in parallel: one folder per scene, and a folder of shared files next to them.

<out>/assets/{meshes,textures,usd,behavior}/   shared, named by content
<out>/<id>/scene.xml scene_light.xml scene.usda scene_nested.usda isaac_lab.py scene.json report.json overview.png ...
<out>/<id>/scene_batch.xml batch.json          the batch form, for engines that step thousands of copies at once
"""

from __future__ import annotations

import filecmp
import json
import shutil
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from casa_assets import registry
from casa_assets.asset.lightweight import light_scene
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.core.system import cache_for, replace_file
from casa_assets.errors import CasaError
from casa_assets.families.asset_store import AssetStore
from casa_assets.formats.mjcf import document
from casa_assets.formats.mjcf import kitchen as mjcf
from casa_assets.formats.usd import kitchen as usd
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.run.kept import is_drawn, is_whole, picture_key, written_key
from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult
from casa_assets.layouts.run.resolve import build_scene, kitchen_key, preset_params
from casa_assets.layouts.run.scene_json import describe, design_of
from casa_assets.library.library import Library
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Files, Report
from casa_assets.model.kitchen.files import BEHAVIOR, LIGHT_FILE, OVERVIEW, SCENE_JSON, SHARED
from casa_assets.model.kitchen.scene import Scene
from casa_assets.model.written_formats import SceneFile
from casa_assets.registry.habits import load_habits
from casa_assets.runs.engine import attempt, run_batch
from casa_assets.runs.limits import StepClock, WorkerFailure
from casa_assets.runs.outcome import writing
from casa_assets.runs.pool import Step, Workers
from casa_assets.show.stills import kitchen as room
from casa_assets.show.stills import pictures
from casa_assets.show.stills.photoreal import EYE, eye_view
from casa_assets.textures.run.recipes import every_recipe

OVERVIEW_FRAME = room.PictureSettings(passes=4, directions=6, shadow_px=512)
# Of the picture at eye level, with doors open.
EYE_FRAME, OPEN = room.PictureSettings(816, 544, passes=3, directions=6, shadow_px=512), "open"
BUILD, WRITE, DRAW, CHECK, PUT = "build", "write", "draw", "check", "put"  # steps of a scene
WORKER_BYTES = 3_000_000_000  # of memory, that building, drawing and checking a scene may take
# Checks a scene in its folder and returns the report.
Judge = Callable[[SceneRecipe, Scene, DesignSubject, Path], Report]


@dataclass(frozen=True)
class BuildOptions:
    """Options of building scenes.

    Attributes:
        drawn: with a picture. at_eye_level: if the scene is made again, also with a picture at eye level, doors open.
        force: even if nothing has changed since they were made.
        judge: checks a scene in its folder, writes the report there and returns it; None: scenes are not checked.
        strict: a scene that does not pass is not kept. frame: of the overview.
    """

    drawn: bool = True
    at_eye_level: bool = False
    force: bool = False
    judge: Judge | None = None
    strict: bool = False
    frame: room.PictureSettings = OVERVIEW_FRAME


def build_one(recipe: SceneRecipe, out: Path, drawn: bool = True, force: bool = False) -> SceneResult:
    """Build and write one scene; see `build_with_options`."""
    return build_with_options(recipe, out, BuildOptions(drawn, force=force))


def build_with_options(recipe: SceneRecipe, out: Path, options: BuildOptions) -> SceneResult:
    """Build a scene with options; it is published only once it has been composed, written, drawn and checked."""

    def make() -> SceneResult:
        folder = out / recipe.scene_id
        try:
            key = scene_key(recipe)
        except CasaError:
            # The plan cannot be built any more: the scene that an earlier version of it gave must not stay.
            remove_scene(out, recipe.scene_id)
            raise
        if options.force or not is_whole(folder, key):
            return _build_and_publish(recipe, Library(out), options, key)
        if options.drawn and not is_drawn(folder, key):
            return _redraw_overview(recipe, folder, key, options)
        return SceneResult(recipe, str(folder), kept=True)

    return attempt_scene(recipe, out, make)


def attempt_scene(recipe: SceneRecipe, out: Path, make: Callable[[], SceneResult]) -> SceneResult:
    """Make or check a scene; a failure is reported in `message` of the result, so that other scenes continue."""
    return attempt(make, partial(_failed, recipe), out)


def work_on_built(recipe: SceneRecipe, out: Path, work: Callable[[SceneResult, Path], SceneResult]) -> SceneResult:
    """Build a scene where it is missing, then work on it in its folder; failures as in `attempt_scene`."""
    built = build_with_options(recipe, out, BuildOptions(drawn=False))
    return attempt_scene(recipe, out, lambda: work(built, Path(built.folder))) if built.folder else built


def _failed(recipe: SceneRecipe, message: str, is_fault: bool) -> SceneResult:
    return SceneResult(recipe, message=message, is_fault=is_fault)


def warm() -> None:
    """Load what every worker that builds scenes needs, once for all of them; nothing here may draw."""
    registry.load()
    preset_params(), load_habits(), every_recipe()
    picture_key(written_key(""))


def scene_key(recipe: SceneRecipe) -> str:
    """Key of the files of a scene, without its pictures and the verdict on it. Raises as `resolve` does."""
    return written_key(kitchen_key(recipe))


def is_current(recipe: SceneRecipe, out: Path) -> bool:
    """True if a scene is there, whole, as today's code and data would make it. Raises as `resolve` does."""
    return is_whole(out / recipe.scene_id, scene_key(recipe))


def _redraw_overview(recipe: SceneRecipe, folder: Path, key: str, options: BuildOptions) -> SceneResult:
    """Draw the overview of a scene again, and remove its other pictures, which are out of date."""
    begin = time.perf_counter()
    for old in folder.glob("*.png"):
        old.unlink()
    draw_cameras(folder, (OVERVIEW,), options.frame)
    facts = json.loads((folder / SCENE_JSON).read_text(encoding="utf-8"))
    _write_facts(folder / SCENE_JSON, {**facts, "picture_key": picture_key(key)})
    return SceneResult(recipe, str(folder), draw_s=time.perf_counter() - begin)


def _build_and_publish(recipe: SceneRecipe, library: Library, options: BuildOptions, key: str) -> SceneResult:
    clock = StepClock()
    try:
        kitchen, scene = build_scene(recipe, cache_for(library.root))
    except CasaError:
        remove_scene(library.root, recipe.scene_id)
        raise
    clock.end(BUILD)
    done = publish_scene(recipe, kitchen, scene, library, options, key)
    return replace(done, build_s=clock.wall_s[BUILD], cpu_s={**clock.cpu_s, **done.cpu_s})


def publish_scene(
    recipe: SceneRecipe, kitchen: KitchenRequest, scene: Scene, library: Library, options: BuildOptions, key: str
) -> SceneResult:
    """Write a composed scene into its folder of a library that is locked; draw and judge it as ordered.

    `key`: of the recipe, for `scene.json`.
    """
    clock, folder = StepClock(), library.stage(scene.id)
    try:
        keys = {"key": key, **({"picture_key": picture_key(key)} if options.drawn else {})}
        design = design_of(kitchen, scene)
        facts = {**keys, **describe(recipe, kitchen, scene, design)}
        store = AssetStore(cache_for(library.root))
        write_scene(folder, folder.parent, facts, scene, store.lightened, store.layer_text)
        store.tidy()
        clock.end(WRITE)
        if options.drawn:
            draw_cameras(folder, (OVERVIEW,), options.frame)
        if options.at_eye_level:
            draw_cameras(folder, (EYE,), EYE_FRAME, OPEN)
        clock.end(DRAW)
        report = options.judge(recipe, scene, design, folder) if options.judge else None
        placed = report is None or report.passed or not options.strict
        if placed:
            _merge(folder.parent / SHARED, library.root / SHARED)
            library.put(folder, library.root / scene.id)
        clock.end(CHECK if report else PUT)
    finally:
        shutil.rmtree(folder.parent, ignore_errors=True)  # with the files that scenes share beside it
    return SceneResult(
        recipe,
        str(library.root / scene.id) if placed else "",
        report=report,
        write_s=clock.wall_s[WRITE],
        draw_s=clock.wall_s[DRAW],
        check_s=clock.wall_s.get(CHECK, 0.0),
        cpu_s=clock.cpu_s,
        counts={"placements": float(len(scene.placements)), "assets": float(len(scene.assets))},
    )


def _merge(drafts: Path, shared: Path) -> None:
    """Move files that scenes share into the shared folder, each by one rename; identical files there are kept.

    Most are named by their content. The layer of a library asset is named by its id, which the asset keeps when it is
    made again; therefore files are compared byte by byte.
    """
    for draft in sorted(p for p in drafts.rglob("*") if p.is_file()):
        target = shared / draft.relative_to(drafts)
        if target.exists() and filecmp.cmp(draft, target, shallow=False):
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        draft.replace(target)


def write_scene(
    folder: Path,
    root: Path,
    facts: dict[str, Any],
    scene: Scene,
    light_form: Callable[[Asset], Asset],
    layer_text: Callable[[Asset, str], str],
) -> None:
    """Write the files of a scene into its empty folder, and those that scenes share into the shared folder.

    `root`: folder under which the shared folder is written. `facts`: content of scene.json. `light_form`: of an asset,
    see `lighten`. `layer_text`: of an asset, see `usd.write`.
    """
    behaviors = {f"{SHARED}/{BEHAVIOR}/{a.id}.json": document.behavior_file(a) for a in scene.assets if a.behavior}
    for files in (mjcf.write(scene), usd.write(scene, layer_text=layer_text), Files.of(behaviors)):
        for path, data in files.entries.items():
            target = (root if path.startswith(f"{SHARED}/") else folder) / path
            if not target.exists():
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(data)
    (folder / LIGHT_FILE).write_bytes(mjcf.write(light_scene(scene, light_form)).entries[mjcf.FILE])
    _write_facts(folder / SCENE_JSON, facts)


def _write_facts(path: Path, facts: dict[str, Any]) -> None:
    SceneFile.model_validate(facts)
    replace_file(path, (json.dumps(facts, indent=1, sort_keys=True, ensure_ascii=False) + "\n").encode())


def draw_cameras(
    folder: Path, cameras: Sequence[str] = (), frame: room.PictureSettings = OVERVIEW_FRAME, pose: str = "start"
) -> tuple[Path, ...]:
    """Draw a scene from each camera into its folder: `<camera>.png`, or `<camera>_<pose>.png` in another pose.

    `cameras`: names, or `eye` for the view at eye level that shows most; empty: all cameras of the scene. Raises
    CannotDraw, NoRenderer.
    """
    made = room.open_scene(folder / mjcf.FILE, frame, pose)
    facts = json.loads((folder / SCENE_JSON).read_text(encoding="utf-8")) if EYE in cameras else {}
    seen = [
        eye_view(facts, name, frame.width_px / frame.height_px) if name == EYE else name
        for name in cameras or made.cameras
    ]
    out = []
    for name, pixels in room.render_cameras(made, seen, frame):
        path = folder / (f"{name}.png" if pose == "start" else f"{name}_{pose}.png")
        path.write_bytes(pictures.png(pixels))
        out.append(path)
    return tuple(out)


def build_all(
    recipes: Sequence[SceneRecipe], out: Path, jobs: Workers = 0, options: BuildOptions | None = None
) -> Iterator[SceneResult]:
    """Yield built scenes as `run_recipes` does."""
    return run_recipes(partial(build_with_options, out=out, options=options or BuildOptions()), recipes, out, jobs)


def run_recipes(
    work: Callable[[SceneRecipe], SceneResult],
    recipes: Sequence[SceneRecipe],
    out: Path,
    jobs: Workers,
    warm: Step = warm,
    goes_on: bool = False,
) -> Iterator[SceneResult]:
    """Run `work` on each recipe in `jobs` processes (0: one per core); yields results as they are done.

    `out`: folder of the scenes, made where it is missing. `warm`: loads what every worker needs. `goes_on`: a scene for
    which the memory does not suffice fails by itself, and the others are made. Raises OutputError: the folder is held
    by another run or cannot be written. CasaError: see run_batch.
    """
    place = Library(out)
    with place.locked(), writing(out):
        place.sweep()
        for number, answer in run_batch(work, recipes, out, jobs, warm, WORKER_BYTES, goes_on):
            if isinstance(answer, WorkerFailure):
                yield _failed(recipes[number], answer.text, True)
            else:
                yield answer


def remove_scene(out: Path, scene_id: str) -> None:
    """Remove one scene; what it shares stays."""
    shutil.rmtree(out / scene_id, ignore_errors=True)
