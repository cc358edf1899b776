"""Make the batch form of kitchens: scene_batch.xml and batch.json in the folder of each, with checks."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path

from pydantic import ValidationError

from casa_assets.addons.batch.merged_form import batch_within
from casa_assets.ext.kitchens import (
    BATCH_FILE,
    BATCH_JSON,
    BatchFile,
    BatchScene,
    EngineSizes,
    JointWord,
    Scene,
    light_scene,
)
from casa_assets.ext.mjcf import write_batch
from casa_assets.ext.scene_checks import BatchSubject, candidate_pairs, engine_sizes, load_registry, run_checks
from casa_assets.ext.scenes import (
    AssetStore,
    SceneRecipe,
    SceneResult,
    Workers,
    build_scene,
    cache_for,
    digest_of,
    key_of,
    replace_file,
    run_recipes,
    scene_key,
    work_on_built,
)


@dataclass(frozen=True)
class BatchRequest:
    """Options of a batch form: kinds of joints that it keeps, and primitives that may touch (None: as BAT002 says)."""

    words: tuple[JointWord, ...] = tuple(JointWord)
    primitives: int | None = None


def make_all(
    recipes: Sequence[SceneRecipe], out: Path, request: BatchRequest, jobs: Workers = 0, force: bool = False
) -> Iterator[SceneResult]:
    """Yield batch forms of scenes as `run_recipes` does. `force`: even where nothing has changed."""
    return run_recipes(partial(make_one, out=out, request=request, force=force), recipes, out, jobs)


def make_one(recipe: SceneRecipe, out: Path, request: BatchRequest, force: bool = False) -> SceneResult:
    """The batch form of one scene, which is built where it is missing; the report is that of the batch form alone."""

    def make(built: SceneResult, folder: Path) -> SceneResult:
        key = batch_key(recipe, request)
        kept = None if force else read_batch(folder)
        if kept is not None and kept.key == key and (folder / BATCH_FILE).is_file():
            return replace(built, report=kept.report, kept=True)
        begin = time.perf_counter()
        _, scene = build_scene(recipe, cache_for(out))
        form = batch_of(scene, cache_for(out), request)
        _write(form, folder)
        written = time.perf_counter()
        judged = _judged(form, folder, key)
        replace_file(folder / BATCH_JSON, (judged.model_dump_json(indent=1) + "\n").encode())
        done = time.perf_counter()
        return replace(built, report=judged.report, kept=False, write_s=written - begin, check_s=done - written)

    return work_on_built(recipe, out, make)


def batch_of(scene: Scene, cache: Path, request: BatchRequest | None = None) -> BatchScene:
    """The batch form of a composed scene. `cache`: folder that keeps light forms of assets."""
    asked = request or BatchRequest()
    limits = load_registry().limits
    most = int(limits["batch_shapes"]) if asked.primitives is None else asked.primitives
    store = AssetStore(cache)
    form = batch_within(light_scene(scene, store.lightened), most, asked.words, int(limits["batch_pairs"]))
    store.tidy()
    return form


def batch_key(recipe: SceneRecipe, request: BatchRequest) -> str:
    """Key of a batch form: the scene's files, what was asked for, and all that makes and judges it."""
    return digest_of("batch", scene_key(recipe), repr(request), version("mujoco"), key_of(make_one, batch_within))


def read_batch(folder: Path) -> BatchFile | None:
    """Return the content of a scene's batch.json, or None if it is missing, damaged or of another version."""
    try:
        return BatchFile.model_validate_json((folder / BATCH_JSON).read_bytes())
    except (OSError, ValidationError):
        return None


def _judged(form: BatchScene, folder: Path, key: str) -> BatchFile:
    records, subject = load_registry(), BatchSubject(form, folder)
    name = form.scene.id
    waived = records.waived(name)
    report = run_checks(subject, name, records.limits, waived)
    model = subject.batch.model
    if model is None:
        sizes = EngineSizes.model_validate(dict.fromkeys(EngineSizes.model_fields, 0))
    else:
        sizes = engine_sizes(subject)
        report += run_checks(sizes, name, records.limits, waived)
    placed = list(zip(form.scene.placements, form.forms, strict=True))
    return BatchFile(
        id=name,
        key=key,
        joints=tuple(f"{place.name}__{joint.name}" for place, asset in placed for joint in asset.joints),
        locked=tuple(f"{ref.placement}__{ref.joint}" for ref in form.locked),
        filled=form.filled,
        colliders=form.collider_count,
        pairs=0 if model is None else int(candidate_pairs(model).sum()),
        freedoms=0 if model is None else int(model.nv),
        engine=sizes,
        report=report,
    )


def _write(form: BatchScene, folder: Path) -> None:
    """Write scene_batch.xml, after the pictures that are not yet in the folder that scenes share."""
    entries = dict(write_batch(form).entries)
    text = entries.pop(BATCH_FILE)
    for path, data in entries.items():
        if not (folder.parent / path).exists():
            replace_file(folder.parent / path, data)
    replace_file(folder / BATCH_FILE, text)
