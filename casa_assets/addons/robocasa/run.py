"""Export a library and scenes as a folder of objects and kitchens for RoboCasa, whole or not at all."""

from __future__ import annotations

import os
import re
import shlex
import shutil
from collections import Counter
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from casa_assets import Asset, CasaError, OutputError
from casa_assets.addons.robocasa import casa_kitchens, casa_objects, kitchens, objects
from casa_assets.addons.robocasa.kitchens import translated
from casa_assets.ext.kitchens import RobocasaRelease, Scene
from casa_assets.ext.libraries import LibraryFolder, attribution, object_names, write_files, writing
from casa_assets.ext.libraries import entries as entries_of
from casa_assets.ext.libraries import export as forms
from casa_assets.ext.mjcf import SCENE_FILE
from casa_assets.ext.records import TEST_SHARE, Base, Category, RestingPose, Split, Vec3, split_of
from casa_assets.ext.scene_checks import ATOMIC_TASKS, DesignSubject, load_registry
from casa_assets.ext.scenes import (
    KitchenRequest,
    SceneRecipe,
    build_scene,
    digest_of_file,
    facts_of,
    is_whole,
    read_once,
    read_states,
    scene_key,
    write_states,
)


@dataclass(frozen=True)
class KitchenResult(forms.Outcome):
    """Outcome of the export of one kitchen: RoboCasa's number of it, fixtures by class, atomic tasks, `measures_of`."""

    number: int = 0
    fixtures: dict[str, int] = field(default_factory=dict)
    tasks: tuple[str, ...] = ()
    measured: dict[str, Any] = field(default_factory=dict)


def export_kitchens(
    recipes: Sequence[SceneRecipe], staged: Path, jobs: int = 0, states: Path | None = None
) -> Iterator[KitchenResult]:
    """Write scenes below a staging folder, `jobs` at a time (0: one per core); yields results as they are done.

    A scene that fails, or has the number of an earlier one, has a message. `states`: folder of scenes' start states.
    """
    numbers: dict[int, str] = {}
    for result in forms.export_in_parallel(
        partial(export_kitchen, states=states), KitchenResult, recipes, staged, jobs
    ):
        twin = result.id if result.message else numbers.setdefault(result.number, result.id)
        if twin == result.id:
            yield result
        else:
            shutil.rmtree(staged / kitchens.KITCHENS / result.id)
            yield KitchenResult(result.id, message=f"has the same number as {twin}; export them into two folders")


def export_kitchen(recipe: SceneRecipe, root: Path, cache: Path, states: Path | None = None) -> KitchenResult:
    """Build one scene and write its files below `root`, with its start states where `states` is a folder of them.

    Raises CasaError: the scene has no start states there, or those of another `scene.xml`.
    """
    kitchen, scene = build_scene(recipe, cache)
    fixtures = kitchens.fixtures_of(scene, classes())
    for placed in fixtures:
        _write_fixture(root / kitchens.FIXTURES / placed.folder, placed.centered)
    folder = root / kitchens.KITCHENS / scene.id
    folder.mkdir(parents=True)
    tasks = afforded_tasks(kitchen, scene)
    write_files(folder, kitchens.write_kitchen(scene, fixtures, tasks))
    if states is not None:
        drawn = states / scene.id
        found = read_states(drawn)
        if not is_whole(drawn, scene_key(recipe)) or digest_of_file(drawn / SCENE_FILE) != found.scene_xml:
            raise CasaError(
                f"{drawn}: its start states are of an older build of the scene; draw them again with "
                f"casa-assets scenes states {drawn.name} --out {shlex.quote(str(drawn.parent))}"
            )
        write_states(folder, translated(found, scene, fixtures))
    return KitchenResult(
        scene.id,
        kitchens.number_of(scene.id),
        dict(sorted(Counter(placed.type for placed in fixtures).items())),
        tasks,
        forms.measures_of(kitchen, scene),
        credits=attribution.credits_of(scene),
    )


def afforded_tasks(kitchen: KitchenRequest, scene: Scene) -> tuple[str, ...]:
    """The atomic tasks of RoboCasa v1.0 for which a kitchen has what they want, as its `scene.json` says."""
    subject = DesignSubject(facts_of(kitchen, scene))
    return tuple(task.task for task in subject.atomic_tasks if not task.wants)


@read_once
def classes() -> dict[str, str]:
    """Contract -> the class of RoboCasa v1.0 that reads it; contracts that none reads are not in it."""
    contracts = load_registry().contracts
    read_by = {name: contract.read_by.get(RobocasaRelease.V1_0, ()) for name, contract in contracts.items()}
    return {name: found[0] for name, found in read_by.items() if found}


def _write_fixture(folder: Path, asset: Asset) -> None:
    """Write a fixture's files unless another kitchen has brought them; the folder appears by one rename."""
    if (folder / kitchens.MODEL).exists():
        return
    draft = folder.with_name(f".{folder.name}.{os.getpid()}")
    folder.parent.mkdir(parents=True, exist_ok=True)
    shutil.rmtree(draft, ignore_errors=True)
    write_files(draft, kitchens.write_fixture(asset))
    try:
        draft.rename(folder)
    except OSError:
        shutil.rmtree(draft)
        if not (folder / kitchens.MODEL).exists():
            raise


# Export robocasa ------------------------------------------------------------------------------------------------------

MANIFEST = "export.json"
SPLITS = "splits.json"
README = "README.md"
REGISTRY = "casa"
_NAME = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")
SCRIPT, KITCHEN_SCRIPT = Path(casa_objects.__file__), Path(casa_kitchens.__file__)
# Files of every export, of one with objects and of one with kitchens. A folder that holds such files, all
# of one kind and nothing else, may be replaced.
COMMON_FILES = frozenset({MANIFEST, README, attribution.NAME})
OBJECT_FILES = frozenset({objects.FOLDER, SPLITS, SCRIPT.name, *map(objects.file_name, RobocasaRelease)})
KITCHEN_FILES = frozenset({kitchens.FIXTURES, kitchens.KITCHENS, casa_kitchens.INDEX, KITCHEN_SCRIPT.name})
SPLIT_RULE = (
    f"test where the first 8 hex digits of the sha256 of the source, as a number, are divisible by {TEST_SHARE};"
    " else train. They are the first 8 of the 10 at the end of an id. Of an object out of numbers the digest is that of"
    " its shape, without its colours."
)


@dataclass(frozen=True)
class ExportResult:
    """Outcome of the export of one asset: path and size (x, y, z, m) of its model, or why it was left out.

    `total`: assets of the library.
    """

    id: str
    category: str
    model: str = ""
    split: str = ""
    message: str = ""
    total: int = 0
    size: Vec3 | None = None


@dataclass(frozen=True)
class TaskReport:
    """Atomic tasks of RoboCasa v1.0 that can be reset with any objects of an export; else what they lack, in words.

    `build`: categories whose objects `casa-assets objects build` can make, one of each for what is missing.
    """

    can_be_reset: tuple[str, ...]
    missing: Mapping[str, tuple[str, ...]]
    build: tuple[str, ...]


def report_tasks(results: Iterable[ExportResult]) -> TaskReport:
    """Compare what was exported with what the tasks draw."""
    categories = load_registry().categories
    things = {(result.category, result.size) for result in results if result.size is not None}
    missing = objects.missing_draws([(categories[name], size) for name, size in things])
    generated = [categories[name] for name in object_names() if name in categories]
    return TaskReport(
        tuple(sorted(set(ATOMIC_TASKS) - missing.keys())),
        {task: tuple(map(str, draws)) for task, draws in missing.items()},
        objects.categories_for(missing, generated),
    )


@dataclass
class _Export:
    staged: Path
    registry: str
    categories: Mapping[str, Category]
    with_review: bool = False
    instances: list[objects.Instance] = field(default_factory=list)
    rows: list[dict[str, Any]] = field(default_factory=list)
    kitchens: dict[str, KitchenResult] = field(default_factory=dict)


def export(
    library: Path | None,
    out: Path,
    name: str = REGISTRY,
    recipes: Sequence[SceneRecipe] = (),
    jobs: int = 0,
    with_review: bool = False,
    states: Path | None = None,
) -> Generator[ExportResult | KitchenResult, None, None]:
    """Write every loose object of a library, and scenes as kitchens, to `out`.

    `out` appears by one rename after the last: before that it is as it was. It stays so where nothing was written.

    Args:
        library: made by ingest; None: no objects. out: missing, empty, or an earlier export, which is replaced.
        name: of the object registry, and of the folder below `objects`. recipes: of the scenes.
        jobs: processes that build scenes; 0 for one per core.
        with_review: write what a person has to decide about too.
        states: folder of scenes whose start states are written with the kitchens; None: without.
    Yields:
        One ExportResult per accepted asset, in their order; then one KitchenResult per scene, as they are done.
    Raises:
        OutputError: the library holds no asset or a damaged one, or `out` is something else or cannot be written.
        BatchFault: scenes failed by a fault of the program; `out` stays as it was.
    """
    folders = [] if library is None else list(LibraryFolder(library).accepted())
    if library is not None and not folders:
        raise OutputError(str(library), "holds no accepted asset; give the folder that `casa-assets ingest` wrote")
    if not _NAME.fullmatch(name):
        raise OutputError(str(out), f"{name!r} is no name of a registry; use small letters, digits and single _")
    if library is not None:
        forms.check_apart(out, library)
    inside = {path.name for path in out.iterdir()} if out.is_dir() else set()
    groups = [group for group in (OBJECT_FILES, KITCHEN_FILES) if inside & group] or [OBJECT_FILES]
    forms.check_replaceable(out, COMMON_FILES.union(*groups), allowed=("__pycache__",))
    out = out.absolute()
    with writing(out.parent), forms.staging(out) as staged:
        run = _Export(staged, name, load_registry().categories, with_review)
        for folder in folders:
            yield replace(_export_asset(folder, run), total=len(folders))
        if library is not None and not run.instances:
            raise OutputError(str(library), "holds no loose object that is accepted: all are fixtures or in review")
        built: list[KitchenResult] = []
        for result in export_kitchens(recipes, staged, jobs, states):
            built.append(result)
            yield replace(result, total=len(recipes))
        forms.raise_faults(built)
        run.kitchens |= {result.id: result for result in built if not result.message}
        if not run.kitchens and not run.instances:
            return
        _write_manifests(run, library)
        forms.replace_target(staged, out)


def _export_asset(folder: Path, run: _Export) -> ExportResult:
    asset = forms.certified_asset(folder)
    category_id = asset.labels.category
    if reason := forms.why_left_out(folder, run.with_review):
        return ExportResult(asset.id, category_id, message=reason)
    if asset.base is Base.FIXED or asset.contract is not None:
        return ExportResult(asset.id, category_id, message="is a fixture, which stands where a kitchen has it")
    if (category := run.categories.get(category_id)) is None:
        lacking = "is of a category that the registry of objects does not have"
        return ExportResult(asset.id, category_id, message=lacking)
    split = asset.labels.split or split_of(asset.provenance.sha256)
    instance = objects.Instance(id=asset.id, category=category_id, split=split)
    folder_inside = objects.instance_folder(instance, run.registry)
    file = f"{folder_inside}/{objects.FILE}"
    write_files(run.staged / folder_inside, objects.write(asset, stood_up=category.upright is RestingPose.LIES))
    low, high = asset.bounds
    x, y, z = (float(v) for v in high - low)
    run.instances.append(instance)
    run.rows.append(_row(asset, category, file, split, (x, y, z)))
    return ExportResult(asset.id, category_id, file, split.value, size=(x, y, z))


def _row(asset: Asset, category: Category, path: str, split: Split, size: Vec3) -> dict[str, Any]:
    origin = asset.provenance
    return {
        "id": asset.id,
        "category": asset.labels.category,
        "portion": "whole" if asset.labels.portion is None else asset.labels.portion.value,
        "model": path,
        "split": split.value,
        "sha256": origin.sha256,
        "size_m": [round(v, 6) for v in size],
        "mass_kg": asset.mass,
        "substances": [s.id for s in asset.substances],
        "affords": [use.value for use in category.affords],
        "qcode": asset.labels.qcode.id,
        "title": origin.title,
        "author": origin.author,
        "licence": origin.licence,
        "uri": origin.uri,
    }


def _write_manifests(run: _Export, library: Path | None) -> None:
    manifest: dict[str, Any] = {"schema_version": 1, "registry": run.registry, "assets": run.rows}
    files: dict[str, bytes] = {}
    credit = ""
    if library is not None:
        ids = {i.id for i in run.instances}
        credit = attribution.text([e for e in entries_of(LibraryFolder(library)) if e.accepted and e.id in ids])
        tables = objects.category_tables(run.instances, run.categories, run.registry)
        files |= {objects.file_name(g): objects.json_bytes(table) for g, table in tables.items()}
        files[SPLITS] = objects.json_bytes({"rule": SPLIT_RULE, **_splits(run.instances)})
        files[SCRIPT.name] = SCRIPT.read_bytes()
    if run.kitchens:
        numbers = {name: kitchen.number for name, kitchen in sorted(run.kitchens.items())}
        manifest["kitchens"] = [
            {"id": name, "number": number, "fixtures": run.kitchens[name].fixtures} for name, number in numbers.items()
        ]
        files[casa_kitchens.INDEX] = objects.json_bytes({"schema_version": 1, "kitchens": numbers})
        files[KITCHEN_SCRIPT.name] = KITCHEN_SCRIPT.read_bytes()
        found = (credit for kitchen in run.kitchens.values() for credit in kitchen.credits)
        credit += ("\n" if credit else "") + attribution.kitchens_text(run.kitchens, found)
    files[MANIFEST] = objects.json_bytes(manifest)
    files[attribution.NAME] = credit.encode()
    parts = ([_readme_of_kitchens(run)] if run.kitchens else []) + ([_readme_of_objects(run)] if run.instances else [])
    files[README] = "\n".join(parts).encode("ascii")
    for path, data in files.items():
        (run.staged / path).write_bytes(data)


def _splits(instances: Sequence[objects.Instance]) -> Mapping[str, list[str]]:
    return {split.value: sorted(i.id for i in instances if i.split is split) for split in Split}


def _readme_of_kitchens(run: _Export) -> str:
    objects = f', obj_registries=("{run.registry}",)' if run.instances else ""
    scripts = ["casa_objects", "casa_kitchens"] if run.instances else ["casa_kitchens"]
    register, call = f"import {', '.join(scripts)}", "; ".join(f"{script}.register()" for script in scripts)
    return f"""# Kitchens for RoboCasa

{len(run.kitchens)} kitchens in which the tasks of RoboCasa v1.0 run as they are. In Python:

    import sys, robosuite, robocasa
    sys.path.insert(0, "<this folder>")
    {register}
    casa_kitchens.patch_robosuite()  # for the robosuite 1.5.2 of PyPI
    {call}
    pairs = casa_kitchens.layout_and_style_ids("{min(run.kitchens)}")  # no id: all, drawn by the seed
    env = robosuite.make("OpenDrawer", robots="PandaOmron", layout_and_style_ids=pairs, seed=0,
                         has_renderer=False, use_camera_obs=False{objects})
    env.reset()

`{kitchens.FIXTURES}/`: a folder per fixture, named by its asset; kitchens share them.
`{kitchens.KITCHENS}/<id>/`: what stands where, sky, lights and cameras. `{casa_kitchens.INDEX}`: the number of each.
"""


def _readme_of_objects(run: _Export) -> str:
    counts = {split: len(ids) for split, ids in _splits(run.instances).items()}
    kinds = len({i.category for i in run.instances})
    names = ", ".join(f"`{name}`" for name in objects.registry_splits(run.registry))
    return f"""# Objects for RoboCasa

{len(run.instances)} objects in {kinds} categories ({counts["train"]} train, {counts["test"]} test), for RoboCasa v0.2
and v1.0.

- `{objects.FOLDER}/{run.registry}/<category>/<id>/model.xml`: the object; `model_upright.xml`: the same stood up, where
  it usually lies. An id never changes and is no running number: nothing shifts when objects come or go.
- `categories_v0_2.json`, `categories_v1_0.json`: entries of OBJ_CATEGORIES with the registries
  {names}.
- `{SPLITS}`: {SPLIT_RULE}
- `{MANIFEST}`: per object its size, mass, affordances, source and licence. `{attribution.NAME}`: credits.

In Python, before an environment is made:

    import sys
    sys.path.insert(0, "<this folder>")
    import casa_objects
    casa_objects.register()

then `obj_registries=("{run.registry}_train",)` and no `obj_instance_split`: RoboCasa's own splits follow the order of
file names. The folder has to be writable, since RoboCasa copies each XML to a file beside it while it loads.

Every model has its real size, so the scale is 1, and its own mass: RoboCasa overwrites friction, stiffness and density
of all objects, and keeps the mass and inertia that are written.
"""
