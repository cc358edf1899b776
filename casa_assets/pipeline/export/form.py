"""Export assets of a library, or kitchens, in one form: each a file by itself, listed, and put in place whole."""

from __future__ import annotations

import json
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from casa_assets.errors import OutputError
from casa_assets.export.urdf.label import json_text
from casa_assets.pipeline.cache.cache_key import digest_of, key_of
from casa_assets.pipeline.cache.code_index import PACKAGE
from casa_assets.pipeline.export.certified import why_left_out
from casa_assets.pipeline.export.faults import raise_faults
from casa_assets.pipeline.export.target import check_apart, check_replaceable, replace_target, staging
from casa_assets.pipeline.ingest.job import writing
from casa_assets.pipeline.kitchens.kept import remembered_kitchen_key
from casa_assets.pipeline.kitchens.recipe import SceneRecipe
from casa_assets.pipeline.kitchens.scene_ids import recipes_named
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.reports import attribution
from casa_assets.pipeline.reports.entry import entry_at

README = "README.md"
ASSETS, SCENES = "assets", "scenes"
KEPT_SCENES = Path("out/scenes")  # where finishes are found that the id of a scene has as a digest alone
SCHEMA_VERSION = 1
BY_PLUGIN = f"{PACKAGE}.pipeline.export.by_plugin"  # what it calls is no code of this package


@dataclass(frozen=True)
class ExportResult:
    """Outcome of the export of one asset or kitchen.

    Attributes:
        id: of the asset or scene. file: its path below the export, empty where it was refused.
        facts: what the manifest says of it besides. credits: of the assets of a kitchen. message: why it was refused,
            or left out (is_left_out) because a person has to decide something about it.
            is_fault: the program is to blame; then that is a trace. total: how many there are.
    """

    id: str
    file: str = ""
    facts: dict[str, Any] = field(default_factory=dict)
    credits: tuple[attribution.Credit, ...] = ()
    message: str = ""
    is_fault: bool = False
    is_left_out: bool = False
    total: int = 0


@dataclass(frozen=True)
class Form:
    """A form that assets and kitchens are exported in.

    Attributes:
        name: key of the file's path in the manifest; `<name>_export.json` is the manifest.
        readmes: text of README.md for each of ASSETS and SCENES.
        write_asset: folder of an asset and staging folder -> result, its file written below the latter.
        write_scene: function of a module that builds a kitchen of a recipe and writes it below a staging folder; the
            last argument is the folder that keeps built assets.
    """

    name: str
    readmes: Mapping[str, str]
    write_asset: Callable[[Path, Path], ExportResult]
    write_scene: Callable[[SceneRecipe, Path, Path], ExportResult]

    @property
    def manifest(self) -> str:
        """Name of the file that lists what was exported."""
        return f"{self.name}_export.json"


def export_assets(
    form: Form, source: Path, out: Path, with_review: bool = False
) -> Generator[ExportResult, None, None]:
    """Write every accepted asset of a library, or any one asset; yields an ExportResult for each, in their order.

    `out` appears by one rename after the last: before that it is as it was. It stays so where nothing was written.

    Args:
        source: library, or the folder of an asset in it. with_review: of a library, write what a person has to decide
            about too. out: missing, empty, or an earlier export of this form, which is replaced.
    Raises:
        OutputError: `source` holds no asset or a damaged one, or `out` is something else or cannot be written.
    """
    is_one = (source / disk.CERTIFICATE).is_file()
    folders = [source] if is_one else list(disk.Library(source).accepted())
    if not folders:
        raise OutputError(str(source), "holds no accepted asset; give a library or the folder of an asset in it")
    check_apart(out, source)
    folders = [folder.absolute() for folder in folders]
    left_out = {} if is_one else {f.name: reason for f in folders if (reason := why_left_out(f, with_review))}
    credit = attribution.text([entry_at(f, f.parents[1]) for f in folders if f.name not in left_out])

    def results(staged: Path) -> Iterator[ExportResult]:
        for folder in folders:
            if reason := left_out.get(folder.name):
                yield ExportResult(folder.name, message=reason, is_left_out=True, total=len(folders))
            else:
                yield replace(form.write_asset(folder, staged), total=len(folders))

    yield from _exported(form, out, ASSETS, results, lambda _written: credit)


def export_scenes(form: Form, patterns: Sequence[str], out: Path, jobs: int = 0) -> Generator[ExportResult, None, None]:
    """Build kitchens and write them; yields one ExportResult for each, as they are done.

    `out` appears as that of `export_assets` does.

    Args:
        patterns: ids or globs of scenes, see `recipes_named`. out: missing, empty, or an earlier export of this form,
            which is replaced. jobs: processes that build kitchens; 0 for one per core.
    Raises:
        UnknownId: a pattern matches no scene.
        OutputError: `out` is something else or cannot be written.
    """
    recipes = recipes_named(patterns, KEPT_SCENES)
    key = _key_of_kitchens(form, recipes)
    if kept := _kept_kitchens(form, out, key):
        yield from kept
        return
    from casa_assets.pipeline.export import scenes  # here, since it loads all families

    def results(staged: Path) -> Iterator[ExportResult]:
        for result in scenes.export_scenes(form.write_scene, failed_scene, recipes, staged, jobs):
            yield replace(result, total=len(recipes))

    yield from _exported(form, out, SCENES, results, _credit_of_kitchens, lambda: _key_of_kitchens(form, recipes))


def _key_of_kitchens(form: Form, recipes: Sequence[SceneRecipe]) -> str:
    """Key of the export of kitchens; empty if that of one is not known, or a plug-in writes them."""
    write: Any = form.write_scene
    options = ""
    if isinstance(write, partial):
        write, options = write.func, repr((write.args, sorted(write.keywords.items())))
    known = [remembered_kitchen_key(recipe) for recipe in recipes]
    if not all(known) or not write.__module__.startswith(f"{PACKAGE}.") or write.__module__ == BY_PLUGIN:
        return ""
    return digest_of("export", form.name, options, known, key_of(write, export_scenes), dict(form.readmes))


def _kept_kitchens(form: Form, out: Path, key: str) -> list[ExportResult]:
    """The kitchens of an earlier export, if it would be made again as it is; else none."""
    try:
        told = json.loads((out / form.manifest).read_text(encoding="utf-8"))
        if not key or told.get("key") != key:
            return []
        rows = [dict(row) for row in told[SCENES]]
        found = [ExportResult(row.pop("id"), row.pop(form.name), row, total=len(rows)) for row in rows]
    except (OSError, ValueError, KeyError, TypeError):
        return []
    return found if all((out / one.file).exists() for one in found) else []


def _credit_of_kitchens(written: Sequence[ExportResult]) -> str:
    """Text of ATTRIBUTION.md."""
    found = (credit for result in written for credit in result.credits)
    return attribution.kitchens_text([result.id for result in written], found)


def failed_scene(scene_id: str, message: str, is_fault: bool) -> ExportResult:
    """Outcome for a kitchen that was not written."""
    return ExportResult(scene_id, message=message, is_fault=is_fault)


def _exported(
    form: Form,
    out: Path,
    part: str,
    results: Callable[[Path], Iterator[ExportResult]],
    credit: Callable[[Sequence[ExportResult]], str],
    key: Callable[[], str] = str,
) -> Iterator[ExportResult]:
    """Results of an export into a staging folder, which takes the place of `out` after the last.

    Args:
        part: name of the folder in it that holds what was exported. results: writes below the staging folder.
        credit: what was written -> text of ATTRIBUTION.md. key: of the export once it is made, for the manifest.
    Raises:
        BatchFault: by a fault of the program; `out` stays as it was.
    """
    check_replaceable(out, {form.manifest, README}, {ASSETS, SCENES, attribution.NAME})
    out = out.absolute()
    done: list[ExportResult] = []
    with writing(out.parent), staging(out) as staged:
        for result in results(staged):
            done.append(result)
            yield result
        raise_faults(done)
        written = [result for result in done if result.file]
        if not written:
            return
        rows = [{"id": r.id, form.name: r.file, **r.facts} for r in sorted(written, key=lambda r: r.id)]
        told = {"schema_version": SCHEMA_VERSION, part: rows}
        if len(written) == len(done) and (made_by := key()):
            told["key"] = made_by
        (staged / form.manifest).write_bytes(json_text(told))
        (staged / README).write_text(form.readmes[part], encoding="ascii")
        (staged / attribution.NAME).write_text(credit(written), encoding="utf-8")
        replace_target(staged, out)
