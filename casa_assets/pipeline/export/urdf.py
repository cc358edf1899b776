"""URDF as a form of export: written, read back, compared."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

from casa_assets.checks.check import Problem
from casa_assets.checks.package.urdf import asset_differences
from casa_assets.checks.scene.formats.urdf import scene_differences
from casa_assets.export.urdf import document
from casa_assets.export.urdf.scene import kitchen
from casa_assets.pipeline.export.certified import certified_asset
from casa_assets.pipeline.export.form import ASSETS, SCENES, ExportResult, Form
from casa_assets.pipeline.export.scenes import measures_of
from casa_assets.pipeline.kitchens.recipe import SceneRecipe
from casa_assets.pipeline.kitchens.resolve import build_scene
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.reports import attribution

# Differences that a row names before it says how many more there are.
MAX_LISTED = 3


def export_asset(folder: Path, staged: Path) -> ExportResult:
    """Write one asset and compare what is read back."""
    asset = certified_asset(folder)
    inside = f"{ASSETS}/{asset.id}"
    disk.write_files(staged / inside, document.write(asset))
    urdf = f"{inside}/{document.urdf_name(asset.id)}"
    facts = {"category": asset.labels.category, "base": asset.base.value, "mass_kg": asset.mass}
    return _judged(staged, ExportResult(asset.id, urdf, facts), asset_differences(staged / urdf, asset))


def export_scene(recipe: SceneRecipe, staged: Path, cache: Path) -> ExportResult:
    """Build one kitchen, write its files and compare them.

    Args:
        staged: folder of the export. cache: keeps built assets.
    """
    request, scene = build_scene(recipe, cache)
    inside = f"{SCENES}/{scene.id}"
    disk.write_files(staged / inside, kitchen.write(scene))
    facts = {"placements": len(scene.placements), "list": f"{inside}/{kitchen.LIST}", **measures_of(request, scene)}
    result = ExportResult(scene.id, f"{inside}/{kitchen.FILE}", facts, attribution.credits_of(scene))
    return _judged(staged, result, scene_differences(staged / inside, scene))


def _judged(staged: Path, result: ExportResult, problems: Sequence[Problem]) -> ExportResult:
    """The result, or a refusal where the files read back are not what was to be written; they are removed then."""
    if not problems:
        return result
    shutil.rmtree((staged / result.file).parent)
    told = "; ".join(f"{pointer}: {message}" for pointer, message in problems[:MAX_LISTED])
    more = f"; and {len(problems) - MAX_LISTED} more" if len(problems) > MAX_LISTED else ""
    return ExportResult(result.id, message=f"its URDF is not what was asked for: {told}{more}")


_ABOUT = """
Metres, kilograms, radians, z up. Paths of meshes are relative to the URDF. URDF puts the axis of a joint through the
origin of the link that it moves, so the frame of such a link stands on the axis. What URDF has no word for is in the
JSON of the same name: springs, armature, friction of surfaces, links that never touch, sites and regions, states, named
poses, behaviour. `<limit>` has an effort and a velocity because URDF asks for them: no joint has a motor.
"""
_READMES = {
    ASSETS: f"""# Assets as URDF

`{ASSETS}/<id>/<id>.urdf`, a folder for each; `urdf_export.json` lists them. The root link is `object`.
{_ABOUT}""",
    SCENES: f"""# Kitchens as URDF

`{SCENES}/<id>/{kitchen.FILE}`: all that stands fixed, as one tree of links below `world`; its names begin with
`<placement>__`. `{SCENES}/<id>/{kitchen.LIST}`: what stands where, with position and quaternion (w, x, y, z) of its
root link, and the positions of its joints. What is loose (base `free`) is in no tree: load its `<asset>.urdf` at the
pose of the list.
{_ABOUT}""",
}
URDF = Form("urdf", _READMES, export_asset, export_scene)
