"""Export a library as a folder of objects for RoboCasa, whole or not at all."""

from __future__ import annotations

import re
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from casa_assets import registry
from casa_assets.errors import OutputError
from casa_assets.export.robocasa import casa_objects, entries, model
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.asset.provenance import TEST_SHARE, Split, split_of
from casa_assets.model.registry.category import Category, RestingPose
from casa_assets.model.registry.contract import RobocasaRelease
from casa_assets.pipeline.export.certified import certified_asset
from casa_assets.pipeline.export.target import check_apart, check_replaceable, replace_target, staging
from casa_assets.pipeline.ingest.job import writing
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.reports import attribution
from casa_assets.pipeline.reports.entry import entries as entries_of

MANIFEST = "export.json"
SPLITS = "splits.json"
README = "README.md"
REGISTRY = "casa"
_NAME = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")
SCRIPT = Path(casa_objects.__file__)
# What an export consists of: a folder that has all of it, and nothing else, may be replaced.
EXPORT_FILES = frozenset(
    {entries.FOLDER, MANIFEST, SPLITS, README, SCRIPT.name, attribution.NAME, *map(entries.file_name, RobocasaRelease)}
)
SPLIT_RULE = (
    f"test where the first 8 hex digits of the sha256 of the source, as a number, are divisible by {TEST_SHARE};"
    " else train. They are the first 8 of the 10 at the end of an id."
)


@dataclass(frozen=True)
class ExportResult:
    """Outcome of the export of one asset.

    Attributes:
        id, category: of the asset. model: path of its model.xml below the export, empty where it was left out.
        split: train or test. message: why it was left out. total: assets of the library.
    """

    id: str
    category: str
    model: str = ""
    split: str = ""
    message: str = ""
    total: int = 0


@dataclass
class _Export:
    """State of one export: its staging folder and the instances written so far."""

    staged: Path
    registry: str
    categories: Mapping[str, Category]
    instances: list[entries.Instance] = field(default_factory=list)
    rows: list[dict[str, Any]] = field(default_factory=list)


def export(library: Path, out: Path, name: str = REGISTRY) -> Generator[ExportResult, None, None]:
    """Write every loose object of a library to `out`; yields one ExportResult per accepted asset, in their order.

    `out` appears by one rename after the last: before that it is as it was.

    Args:
        library: made by ingest. out: missing, empty, or an earlier export, which is replaced.
        name: of the object registry, and of the folder below `objects`.
    Raises:
        OutputError: the library holds no asset or a damaged one, or `out` is something else or cannot be written.
    """
    folders = list(disk.Library(library).accepted())
    if not folders:
        raise OutputError(str(library), "holds no accepted asset; give the folder that `casa-assets ingest` wrote")
    if not _NAME.fullmatch(name):
        raise OutputError(str(out), f"{name!r} is no name of a registry; use small letters, digits and single _")
    check_apart(out, library)
    check_replaceable(out, EXPORT_FILES, allowed=("__pycache__",))
    out = out.absolute()
    with writing(out.parent), staging(out) as staged:
        run = _Export(staged, name, registry.load().categories)
        for folder in folders:
            yield replace(_export_asset(folder, run), total=len(folders))
        if not run.instances:
            raise OutputError(str(library), "holds no loose object: all its assets are fixtures")
        _write_manifests(run, disk.Library(library))
        replace_target(staged, out)


def _export_asset(folder: Path, run: _Export) -> ExportResult:
    asset = certified_asset(folder)
    category_id = asset.labels.category
    if asset.base is Base.FIXED or asset.contract is not None:
        return ExportResult(asset.id, category_id, message="is a fixture, which stands where a kitchen has it")
    if category_id not in run.categories:
        return ExportResult(
            asset.id, category_id, message="is of a category that the registry of objects does not have"
        )
    category = run.categories[category_id]
    split = asset.labels.split or split_of(asset.provenance.sha256)
    instance = entries.Instance(id=asset.id, category=category_id, split=split)
    folder_inside = entries.instance_folder(instance, run.registry)
    lies = category.upright is RestingPose.LIES
    disk.write_files(run.staged / folder_inside, model.write(asset, stood_up=lies))
    run.instances.append(instance)
    run.rows.append(_row(asset, category, f"{folder_inside}/{model.FILE}", split))
    return ExportResult(asset.id, category_id, f"{folder_inside}/{model.FILE}", split.value)


def _row(asset: Asset, category: Category, path: str, split: Split) -> dict[str, Any]:
    low, high = asset.bounds
    origin = asset.provenance
    return {
        "id": asset.id,
        "category": asset.labels.category,
        "model": path,
        "split": split.value,
        "sha256": origin.sha256,
        "size_m": [round(float(v), 6) for v in high - low],
        "mass_kg": asset.mass,
        "substances": [s.id for s in asset.substances],
        "affords": [use.value for use in category.affords],
        "qcode": asset.labels.qcode.id,
        "title": origin.title,
        "author": origin.author,
        "licence": origin.licence,
        "uri": origin.uri,
    }


def _write_manifests(run: _Export, library: disk.Library) -> None:
    """Write the tables of the instances, their splits, the manifest, the credits, and how to add them to a runtime."""
    tables = entries.category_tables(run.instances, run.categories, run.registry)
    ids = {i.id for i in run.instances}
    credit = attribution.text([e for e in entries_of(library) if e.accepted and e.id in ids])
    files: dict[str, bytes] = {entries.file_name(g): entries.json_bytes(table) for g, table in tables.items()}
    files[SPLITS] = entries.json_bytes({"rule": SPLIT_RULE, **_splits(run.instances)})
    files[MANIFEST] = entries.json_bytes({"schema_version": 1, "registry": run.registry, "assets": run.rows})
    files[SCRIPT.name] = SCRIPT.read_bytes()
    files[attribution.NAME] = credit.encode()
    files[README] = _readme(run).encode("ascii")
    for path, data in files.items():
        (run.staged / path).write_bytes(data)


def _splits(instances: Sequence[entries.Instance]) -> Mapping[str, list[str]]:
    return {split.value: sorted(i.id for i in instances if i.split is split) for split in Split}


def _readme(run: _Export) -> str:
    counts = {split: len(ids) for split, ids in _splits(run.instances).items()}
    kinds = len({i.category for i in run.instances})
    names = ", ".join(f"`{name}`" for name in entries.registry_splits(run.registry))
    return f"""# Objects for RoboCasa

{len(run.instances)} objects in {kinds} categories ({counts["train"]} train, {counts["test"]} test), for RoboCasa v0.2
and v1.0.

- `{entries.FOLDER}/{run.registry}/<category>/<id>/model.xml`: the object; `model_upright.xml`: the same stood up, where
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
