"""Export assets of a library, or kitchens, as URDF: written, read back, compared, and put in place whole."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from casa_assets.checks.check import Problem
from casa_assets.checks.package.urdf import asset_differences
from casa_assets.checks.scene.formats.urdf import scene_differences
from casa_assets.errors import OutputError
from casa_assets.export.urdf import document
from casa_assets.export.urdf.label import json_text
from casa_assets.export.urdf.scene import kitchen
from casa_assets.pipeline.export import scenes
from casa_assets.pipeline.export.certified import certified_asset, why_left_out
from casa_assets.pipeline.export.target import check_apart, check_replaceable, replace_target, staging
from casa_assets.pipeline.ingest.job import writing
from casa_assets.pipeline.kitchens.resolve import SceneRecipe, build_scene
from casa_assets.pipeline.kitchens.scene_folders import recipes_matching
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.reports import attribution
from casa_assets.pipeline.reports.entry import entry_at

MANIFEST, README = "urdf_export.json", "README.md"
ASSETS, SCENES = "assets", "scenes"
SCHEMA_VERSION = 1
# Differences that a row names before it says how many more there are.
MAX_LISTED = 3


@dataclass(frozen=True)
class UrdfResult:
    """Outcome of the export of one asset or kitchen.

    Attributes:
        id: of the asset or scene. urdf: path of its URDF below the export, empty where it was refused.
        facts: what the manifest says of it besides. credits: of the assets of a kitchen. message: why it was refused,
            or left out (is_left_out) because a person has to decide something about it.
            is_fault: the program is to blame; then that is a trace. total: how many there are.
    """

    id: str
    urdf: str = ""
    facts: dict[str, Any] = field(default_factory=dict)
    credits: tuple[attribution.Credit, ...] = ()
    message: str = ""
    is_fault: bool = False
    is_left_out: bool = False
    total: int = 0


def export_assets(source: Path, out: Path, with_review: bool = False) -> Generator[UrdfResult, None, None]:
    """Write every accepted asset of a library, or any one asset, as URDF; yields a UrdfResult for each, in their order.

    `out` appears by one rename after the last: before that it is as it was. It stays so where nothing was written.

    Args:
        source: library, or the folder of an asset in it. with_review: of a library, write what a person has to decide
            about too. out: missing, empty, or an earlier export, which is replaced.
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

    def results(staged: Path) -> Iterator[UrdfResult]:
        for folder in folders:
            if reason := left_out.get(folder.name):
                yield UrdfResult(folder.name, message=reason, is_left_out=True, total=len(folders))
            else:
                yield replace(_export_asset(folder, staged), total=len(folders))

    yield from _exported(out, ASSETS, results, lambda _written: credit)


def export_scenes(patterns: Sequence[str], out: Path, jobs: int = 0) -> Generator[UrdfResult, None, None]:
    """Build kitchens and write them as URDF; yields one UrdfResult for each, as they are done.

    `out` appears as that of `export_assets` does.

    Args:
        patterns: ids or globs of scenes. out: missing, empty, or an earlier export, which is replaced.
        jobs: processes that build kitchens; 0 for one per core.
    Raises:
        UnknownId: a pattern matches no scene.
        OutputError: `out` is something else or cannot be written.
    """
    recipes = recipes_matching(patterns)

    def results(staged: Path) -> Iterator[UrdfResult]:
        for result in scenes.export_scenes(export_scene, failed_scene, recipes, staged, jobs):
            yield replace(result, total=len(recipes))

    yield from _exported(out, SCENES, results, _credit_of_kitchens)


def _credit_of_kitchens(written: Sequence[UrdfResult]) -> str:
    """Text of ATTRIBUTION.md."""
    found = (credit for result in written for credit in result.credits)
    return attribution.kitchens_text([result.id for result in written], found)


def failed_scene(scene_id: str, message: str, is_fault: bool) -> UrdfResult:
    """Outcome for a kitchen that was not written."""
    return UrdfResult(scene_id, message=message, is_fault=is_fault)


def _exported(
    out: Path,
    part: str,
    results: Callable[[Path], Iterator[UrdfResult]],
    credit: Callable[[Sequence[UrdfResult]], str],
) -> Iterator[UrdfResult]:
    """Results of an export into a staging folder, which takes the place of `out` after the last.

    Args:
        part: name of the folder in it that holds what was exported. results: writes below the staging folder.
        credit: what was written -> text of ATTRIBUTION.md.
    Raises:
        BatchFault: by a fault of the program; `out` stays as it was.
    """
    check_replaceable(out, {MANIFEST, README}, {ASSETS, SCENES, attribution.NAME})
    out = out.absolute()
    done: list[UrdfResult] = []
    with writing(out.parent), staging(out) as staged:
        for result in results(staged):
            done.append(result)
            yield result
        scenes.raise_faults(done)
        written = [result for result in done if result.urdf]
        if not written:
            return
        rows = [{"id": r.id, "urdf": r.urdf, **r.facts} for r in sorted(written, key=lambda r: r.id)]
        (staged / MANIFEST).write_bytes(json_text({"schema_version": SCHEMA_VERSION, part: rows}))
        (staged / README).write_text(_READMES[part], encoding="ascii")
        (staged / attribution.NAME).write_text(credit(written), encoding="utf-8")
        replace_target(staged, out)


def _export_asset(folder: Path, staged: Path) -> UrdfResult:
    asset = certified_asset(folder)
    inside = f"{ASSETS}/{asset.id}"
    disk.write_files(staged / inside, document.write(asset))
    urdf = f"{inside}/{document.urdf_name(asset.id)}"
    facts = {"category": asset.labels.category, "base": asset.base.value, "mass_kg": asset.mass}
    return _judged(staged, UrdfResult(asset.id, urdf, facts), asset_differences(staged / urdf, asset))


def export_scene(recipe: SceneRecipe, staged: Path, cache: Path) -> UrdfResult:
    """Build one kitchen, write its files and compare them.

    Args:
        staged: folder of the export. cache: keeps built assets.
    """
    _, scene = build_scene(recipe, cache)
    inside = f"{SCENES}/{scene.id}"
    disk.write_files(staged / inside, kitchen.write(scene))
    facts = {"placements": len(scene.placements), "list": f"{inside}/{kitchen.LIST}"}
    result = UrdfResult(scene.id, f"{inside}/{kitchen.FILE}", facts, attribution.credits_of(scene))
    return _judged(staged, result, scene_differences(staged / inside, scene))


def _judged(staged: Path, result: UrdfResult, problems: Sequence[Problem]) -> UrdfResult:
    """The result, or a refusal where the files read back are not what was to be written; they are removed then."""
    if not problems:
        return result
    shutil.rmtree((staged / result.urdf).parent)
    told = "; ".join(f"{pointer}: {message}" for pointer, message in problems[:MAX_LISTED])
    more = f"; and {len(problems) - MAX_LISTED} more" if len(problems) > MAX_LISTED else ""
    return UrdfResult(result.id, message=f"its URDF is not what was asked for: {told}{more}")


_ABOUT = """
Metres, kilograms, radians, z up. Paths of meshes are relative to the URDF. URDF puts the axis of a joint through the
origin of the link that it moves, so the frame of such a link stands on the axis. What URDF has no word for is in the
JSON of the same name: springs, armature, friction of surfaces, links that never touch, sites and regions, states, named
poses, behaviour. `<limit>` has an effort and a velocity because URDF asks for them: no joint has a motor.
"""
_READMES = {
    ASSETS: f"""# Assets as URDF

`{ASSETS}/<id>/<id>.urdf`, a folder for each; `{MANIFEST}` lists them. The root link is `object`.
{_ABOUT}""",
    SCENES: f"""# Kitchens as URDF

`{SCENES}/<id>/{kitchen.FILE}`: all that stands fixed, as one tree of links below `world`; its names begin with
`<placement>__`. `{SCENES}/<id>/{kitchen.LIST}`: what stands where, with position and quaternion (w, x, y, z) of its
root link, and the positions of its joints. What is loose (base `free`) is in no tree: load its `<asset>.urdf` at the
pose of the list.
{_ABOUT}""",
}
