"""Export assets of a library, or kitchens, in one form (GLB, URDF, that of a plug-in), put in place whole."""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, TypeVar

from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.cache.code_index import PACKAGE
from casa_assets.core.system import cache_for
from casa_assets.errors import BatchFault, CasaError, OutputError, PluginFailure, UnknownId
from casa_assets.formats import urdf
from casa_assets.formats.urdf import json_text
from casa_assets.layouts.run.kept import remembered_kitchen_key
from casa_assets.layouts.run.recipe import SceneRecipe, recipes_named
from casa_assets.library import attribution
from casa_assets.library.entry import entry_at
from casa_assets.library.entry_files import CERTIFICATE, file_digests, read_asset, read_certificate, write_files
from casa_assets.library.library import Library
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Files
from casa_assets.model.kitchen.scene import Layer, Scene
from casa_assets.registry.plugins.load import exporters, guarded
from casa_assets.runs.limits import WorkerFailure
from casa_assets.runs.outcome import writing

# What builds kitchens, reads back and compares is imported where it is used: an export that is there already needs none
# of it.
if TYPE_CHECKING:
    from casa_assets.checks.check import Problem
    from casa_assets.layouts.order.build_order import KitchenRequest

# Certified ------------------------------------------------------------------------------------------------------------

# Advice about an asset that an export leaves out.
DECIDE = "accept or correct it in review.csv of the library and run ingest again, or give --with-review"


def why_left_out(folder: Path, with_review: bool) -> str:
    """Why an export leaves out the asset of a folder: what a person has to decide about it; empty where it goes out."""
    subjects = () if with_review else read_certificate(folder).report.to_decide
    return f"is in review for {', '.join(subjects)}; {DECIDE}" if subjects else ""


def certified_asset(folder: Path) -> Asset:
    """The asset of a folder, every file as it was certified. Raises OutputError."""
    certified = read_certificate(folder).files
    try:
        digests = file_digests(folder)
    except OSError as error:
        raise OutputError(str(folder), f"cannot be read: {error.strerror}") from error
    for path in sorted(certified):
        if path not in digests:
            raise OutputError(str(folder / path), "is missing; remove the asset's folder and run ingest again")
        if digests[path] != certified[path]:
            raise OutputError(str(folder / path), "was changed since it was checked; run ingest again without it")
    if (asset := read_asset(folder)).id != folder.name:
        raise OutputError(str(folder / CERTIFICATE), f"holds the asset {asset.id!r}; move it to such a folder")
    return asset


@dataclass(frozen=True)
class Outcome:
    """Outcome of the export of one asset or kitchen.

    Attributes:
        id: of the asset or scene. message: why it was not written. is_fault: the program is to blame; then the message
            is a trace. credits: of the assets of a kitchen. total: how many are exported.
    """

    id: str
    message: str = field(default="", kw_only=True)
    is_fault: bool = field(default=False, kw_only=True)
    credits: tuple[attribution.Credit, ...] = field(default=(), kw_only=True)
    total: int = field(default=0, kw_only=True)


def raise_faults(results: Iterable[Outcome]) -> None:
    """Raise BatchFault where the program is to blame for some."""
    if faults := [result for result in results if result.is_fault]:
        raise BatchFault([result.id for result in faults], "\n".join(result.message for result in faults))


# Target ---------------------------------------------------------------------------------------------------------------
# The folder of an export: staged beside its place, moved there by one rename, replaced only where it is an export.


def check_apart(out: Path, source: Path, what: str = "the library") -> None:
    """Raise OutputError where `out` lies in `source` or `source` in it."""
    target, inside = out.resolve(), source.resolve()
    if target == inside or target in inside.parents or inside in target.parents:
        raise OutputError(str(out), f"and {what} {source} are one inside the other; name another folder")


def check_replaceable(out: Path, required: Collection[str], allowed: Collection[str] = ()) -> None:
    """Raise OutputError unless `out` is missing, empty or an earlier export.

    Args:
        required: names that every export of this kind holds. allowed: names that it may hold besides; a folder with
            any other is left alone.
    """
    if out.is_symlink() or (out.exists() and not out.is_dir()):
        raise OutputError(str(out), "is no folder; name another")
    inside = {path.name for path in out.iterdir()} if out.is_dir() else set()
    if inside and (lacking := set(required) - inside):
        raise OutputError(str(out), f"is neither empty nor an earlier export (it has no {min(lacking)}); name another")
    if strange := sorted(inside.difference(required, allowed)):
        raise OutputError(
            str(out / strange[0]), "was not written by an export, which would remove it; name another OUT"
        )


@contextmanager
def staging(out: Path) -> Iterator[Path]:
    """Yield a staging folder next to `out`, removed at the end; leftovers of killed runs are removed first."""
    out.parent.mkdir(parents=True, exist_ok=True)
    for leftover in sorted(out.parent.iterdir()):
        match = re.fullmatch(re.escape(f".{out.name}.") + r"(\d+)(\.old)?", leftover.name)
        if match and not Path(f"/proc/{match[1]}").exists():
            if match[2] and not out.exists():
                leftover.rename(out)  # the run was killed between its two renames
            else:
                shutil.rmtree(leftover, ignore_errors=True)
    staged = out.with_name(f".{out.name}.{os.getpid()}")
    shutil.rmtree(staged, ignore_errors=True)
    staged.mkdir()
    try:
        yield staged
    finally:
        shutil.rmtree(staged, ignore_errors=True)


def replace_target(staged: Path, out: Path) -> None:
    """Move an export to `out`; an earlier one there is put back where that fails."""
    older = staged.with_name(f"{staged.name}.old")
    shutil.rmtree(older, ignore_errors=True)
    has_older = out.exists()
    if has_older:
        out.rename(older)
    try:
        staged.rename(out)
    except OSError:
        if has_older:
            older.rename(out)
        raise
    shutil.rmtree(older, ignore_errors=True)


README = "README.md"
ASSETS, SCENES = "assets", "scenes"
KEPT_SCENES = Path("out/scenes")  # where finishes are found that the id of a scene has as a digest alone
SCHEMA_VERSION = 1


@dataclass(frozen=True)
class ExportResult(Outcome):
    """Outcome of the export in a form.

    Attributes:
        file: its path below the export, empty if there is no file. facts: what the manifest says of it besides.
        is_left_out: a person has to decide about it, as `message` says.
    """

    file: str = ""
    facts: dict[str, Any] = field(default_factory=dict)
    is_left_out: bool = False


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
    is_one = (source / CERTIFICATE).is_file()
    folders = [source] if is_one else list(Library(source).accepted())
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

    def results(staged: Path) -> Iterator[ExportResult]:
        for result in export_in_parallel(form.write_scene, ExportResult, recipes, staged, jobs):
            yield replace(result, total=len(recipes))

    def credit(written: Sequence[ExportResult]) -> str:
        return attribution.kitchens_text([one.id for one in written], (c for one in written for c in one.credits))

    yield from _exported(form, out, SCENES, results, credit, lambda: _key_of_kitchens(form, recipes))


def _key_of_kitchens(form: Form, recipes: Sequence[SceneRecipe]) -> str:
    """Key of the export of kitchens; empty if that of one is not known, or a plug-in writes them."""
    write: Any = form.write_scene
    options = ""
    if isinstance(write, partial):
        write, options = write.func, repr((write.args, sorted(write.keywords.items())))
    known = [remembered_kitchen_key(recipe) for recipe in recipes]
    if not all(known) or not write.__module__.startswith(f"{PACKAGE}."):
        return ""
    return digest_of("export", form.name, options, known, key_of(write, export_scenes), dict(form.readmes))


def _kept_kitchens(form: Form, out: Path, key: str) -> list[ExportResult]:
    """The kitchens of an earlier export, if it would be made again as it is; else none."""
    try:
        listed = json.loads((out / form.manifest).read_text(encoding="utf-8"))
        if not key or listed.get("key") != key:
            return []
        rows = [dict(row) for row in listed[SCENES]]
        found = [ExportResult(row.pop("id"), row.pop(form.name), row, total=len(rows)) for row in rows]
    except (OSError, ValueError, KeyError, TypeError):
        return []
    return found if all((out / one.file).exists() for one in found) else []


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
        listed = {"schema_version": SCHEMA_VERSION, part: rows}
        if len(written) == len(done) and (made_by := key()):
            listed["key"] = made_by
        (staged / form.manifest).write_bytes(json_text(listed))
        (staged / README).write_text(form.readmes[part], encoding="ascii")
        (staged / attribution.NAME).write_text(credit(written), encoding="utf-8")
        replace_target(staged, out)


# Scenes ---------------------------------------------------------------------------------------------------------------

R = TypeVar("R", bound=Outcome)
# Writes a kitchen below the root of an export, with a folder that keeps built assets.
Export = Callable[[SceneRecipe, Path, Path], R]


def export_in_parallel(
    export: Export[R], kind: type[R], recipes: Sequence[SceneRecipe], root: Path, jobs: int = 0
) -> Iterator[R]:
    """Yield a result for each scene as they are done, each made in a worker; one that fails does not stop the others.

    Args:
        export: function of a module. kind: of the results. root: folder of the export.
        jobs: processes; 0 for one per core.
    Raises:
        CasaError: the disk, the renderer or the memory of this machine does not suffice.
    """
    from casa_assets.layouts.run.resolve import warm
    from casa_assets.layouts.run.scene_folders import WORKER_BYTES
    from casa_assets.runs.engine import run_batch

    work = partial(export_one, export=export, kind=kind, root=root, cache=cache_for(root))
    for number, answer in run_batch(work, recipes, root, jobs, warm, WORKER_BYTES):
        if isinstance(answer, WorkerFailure):
            answer = kind(recipes[number].scene_id, message=answer.text, is_fault=True)
        yield answer


def measures_of(kitchen: KitchenRequest, scene: Scene) -> dict[str, Any]:
    """Return the mass in kg of everything in a kitchen but walls and floor, and the size of the room in metres."""
    (x0, y0), (x1, y1) = kitchen.room.bounds()
    assets = scene.asset_of
    standing = [assets[place.name] for place in scene.placements if place.layer is not Layer.ROOM]
    return {
        "mass": round(sum(round(asset.mass, 4) for asset in standing), 3),
        "size": [round(x1 - x0, 4), round(y1 - y0, 4), round(kitchen.room.height, 4)],
    }


def export_one(recipe: SceneRecipe, export: Export[R], kind: type[R], root: Path, cache: Path) -> R:
    """Export one scene; errors are reported in the result."""
    from casa_assets.layouts.run.resolve import kitchen_key
    from casa_assets.runs.engine import attempt

    def make() -> R:
        done = export(recipe, root, cache)
        kitchen_key(recipe)  # remembered, so that the same export again is known to be there
        return done

    return attempt(make, lambda text, is_fault: kind(recipe.scene_id, message=text, is_fault=is_fault), root)


# Gltf -----------------------------------------------------------------------------------------------------------------


def glb_form(with_layers: bool = False) -> Form:
    """The form; `with_layers` puts collision shapes and regions into the files, which other programs show as well."""
    write = partial(_asset, with_layers=with_layers), partial(_scene, with_layers=with_layers)
    return Form("glb", _GLB_READMES, *write)


def _asset(folder: Path, staged: Path, with_layers: bool) -> ExportResult:
    from casa_assets.formats.gltf import asset_glb

    asset = certified_asset(folder)
    data = asset_glb(asset, with_layers)
    facts = {"category": asset.labels.category, "mass_kg": asset.mass, "bytes": len(data)}
    return ExportResult(asset.id, _put(staged, f"{ASSETS}/{asset.id}.glb", data), facts)


def _scene(recipe: SceneRecipe, staged: Path, cache: Path, with_layers: bool) -> ExportResult:
    from casa_assets.formats.gltf import scene_glb
    from casa_assets.layouts.run.resolve import build_scene

    request, scene = build_scene(recipe, cache)
    data = scene_glb(scene, with_layers)
    facts = {"placements": len(scene.placements), "bytes": len(data), **measures_of(request, scene)}
    file = _put(staged, f"{SCENES}/{scene.id}.glb", data)
    return ExportResult(scene.id, file, facts, credits=attribution.credits_of(scene))


def _put(staged: Path, file: str, data: bytes) -> str:
    """Write a file below the staging folder; returns its path there."""
    target = staged / file
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(data)
    return file


_GLB_ABOUT = """
Binary glTF 2.0: metres, y up, pictures of at most 512 pixels. It is for looking at: there is no mass and no friction,
and nothing collides. Every link is a node that can be moved; its `extras` say about which axis and how far.
"""
_GLB_READMES = {
    part: f"# {title} as GLB\n\n`{part}/<id>.glb`; `glb_export.json` lists them.\n{_GLB_ABOUT}"
    for part, title in ((ASSETS, "Assets"), (SCENES, "Kitchens"))
}

# Urdf -----------------------------------------------------------------------------------------------------------------

# Differences that a row names before it says how many more there are.
MAX_LISTED = 3


def export_asset(folder: Path, staged: Path) -> ExportResult:
    """Write one asset and compare what is read back."""
    from casa_assets.checks.readers.urdf_facts import asset_differences

    asset = certified_asset(folder)
    inside = f"{ASSETS}/{asset.id}"
    write_files(staged / inside, urdf.write(asset))
    file = f"{inside}/{urdf.urdf_name(asset.id)}"
    facts = {"category": asset.labels.category, "base": asset.base.value, "mass_kg": asset.mass}
    return _judged(staged, ExportResult(asset.id, file, facts), asset_differences(staged / file, asset))


def export_scene(recipe: SceneRecipe, staged: Path, cache: Path) -> ExportResult:
    """Build one kitchen, write its files and compare them."""
    from casa_assets.checks.scene.formats import scene_differences
    from casa_assets.layouts.run.resolve import build_scene

    request, scene = build_scene(recipe, cache)
    inside = f"{SCENES}/{scene.id}"
    write_files(staged / inside, urdf.write_scene(scene))
    facts = {"placements": len(scene.placements), "list": f"{inside}/{urdf.LIST}", **measures_of(request, scene)}
    result = ExportResult(scene.id, f"{inside}/{urdf.FILE}", facts, credits=attribution.credits_of(scene))
    return _judged(staged, result, scene_differences(staged / inside, scene))


def _judged(staged: Path, result: ExportResult, problems: Sequence[Problem]) -> ExportResult:
    """The result, or a refusal where the files read back are not what was to be written; they are removed then."""
    if not problems:
        return result
    shutil.rmtree((staged / result.file).parent)
    listed = "; ".join(f"{pointer}: {message}" for pointer, message in problems[:MAX_LISTED])
    more = f"; and {len(problems) - MAX_LISTED} more" if len(problems) > MAX_LISTED else ""
    return ExportResult(result.id, message=f"its URDF is not what was asked for: {listed}{more}")


_URDF_ABOUT = """
Metres, kilograms, radians, z up. Paths of meshes are relative to the URDF. URDF puts the axis of a joint through the
origin of the link that it moves, so the frame of such a link stands on the axis. What URDF has no word for is in the
JSON of the same name: springs, armature, friction of surfaces, links that never touch, sites and regions, states, named
poses, behaviour. `<limit>` has an effort and a velocity because URDF asks for them: no joint has a motor.
"""
_URDF_READMES = {
    ASSETS: f"""# Assets as URDF

`{ASSETS}/<id>/<id>.urdf`, a folder for each; `urdf_export.json` lists them. The root link is `object`.
{_URDF_ABOUT}""",
    SCENES: f"""# Kitchens as URDF

`{SCENES}/<id>/{urdf.FILE}`: all that stands fixed, as one tree of links below `world`; its names begin with
`<placement>__`. `{SCENES}/<id>/{urdf.LIST}`: what stands where, with position and quaternion (w, x, y, z) of its
root link, and the positions of its joints. What is loose (base `free`) is in no tree: load its `<asset>.urdf` at the
pose of the list.
{_URDF_ABOUT}""",
}
URDF = Form("urdf", _URDF_READMES, export_asset, export_scene)

TRACES = "traces"


def form_of(name: str) -> Form:
    """The form of the exporter of that name. Raises UnknownId."""
    known = exporters()
    if name not in known:
        raise UnknownId("exporter of plug-ins", name, known)
    plugin, exporter = known[name]
    write = guarded(plugin, f"exporter {name}", exporter.write)

    def write_asset(folder: Path, staged: Path) -> ExportResult:
        asset = certified_asset(folder)
        inside = f"{ASSETS}/{asset.id}"
        try:
            files = write(asset)
        except PluginFailure as error:
            write_files(staged / TRACES, Files(entries={f"{asset.id}.txt": error.trace.encode()}))
            return ExportResult(asset.id, message=f"{error}; the trace: {TRACES}/{asset.id}.txt")
        if wrong := [path for path in files if not _is_inside(path)]:
            return ExportResult(asset.id, message=f"plug-in {plugin.plugin.name}: {wrong[0]!r} leaves the folder")
        if not files:
            return ExportResult(asset.id, message=f"plug-in {plugin.plugin.name} wrote no file")
        write_files(staged / inside, Files(entries=dict(sorted(files.items()))))
        facts = {"category": asset.labels.category, "plugin": f"{plugin.plugin.name} {plugin.version}"}
        return ExportResult(asset.id, f"{inside}/{min(files)}", facts)

    about = f"# Assets by {plugin.plugin.name}\n\n{exporter.about}\n\n`{ASSETS}/<id>/`, a folder for each asset.\n"
    return Form(name, {ASSETS: about}, write_asset, _no_scene)


def _is_inside(path: str) -> bool:
    place = PurePosixPath(path)
    return bool(place.parts) and not place.is_absolute() and ".." not in place.parts


def _no_scene(_: SceneRecipe, __: Path, ___: Path) -> ExportResult:
    raise CasaError("exporters of plug-ins write assets, no kitchens")
