"""Forms of export: GLB, URDF, and those that plug-ins write."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from functools import partial
from pathlib import Path, PurePosixPath

from casa_assets.checks.check import Problem
from casa_assets.checks.package.parity import asset_differences
from casa_assets.checks.scene.forms import scene_differences
from casa_assets.errors import CasaError, PluginFailure, UnknownId
from casa_assets.export.forms import ASSETS, SCENES, ExportResult, Form, certified_asset, measures_of
from casa_assets.formats.gltf import EVERYTHING, SEEN_ALONE, Layers, asset_glb, scene_glb
from casa_assets.formats.urdf import document
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import build_scene
from casa_assets.library import attribution
from casa_assets.library import library as disk
from casa_assets.model.issue import Files
from casa_assets.registry.plugins.guard import exporters, guarded

# Gltf -----------------------------------------------------------------------------------------------------------------
# GLB as a form of export: one file for each asset or kitchen, to look at in other programs and on web pages.


def glb_form(with_layers: bool = False) -> Form:
    """The form; `with_layers` puts collision shapes and regions into the files, which other programs show as well."""
    layers = EVERYTHING if with_layers else SEEN_ALONE
    return Form("glb", _GLB_READMES, partial(_asset, layers=layers), partial(_scene, layers=layers))


def _asset(folder: Path, staged: Path, layers: Layers) -> ExportResult:
    asset = certified_asset(folder)
    data = asset_glb(asset, layers)
    facts = {"category": asset.labels.category, "mass_kg": asset.mass, "bytes": len(data)}
    return ExportResult(asset.id, _put(staged, f"{ASSETS}/{asset.id}.glb", data), facts)


def _scene(recipe: SceneRecipe, staged: Path, cache: Path, layers: Layers) -> ExportResult:
    request, scene = build_scene(recipe, cache)
    data = scene_glb(scene, layers)
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
    ASSETS: f"""# Assets as GLB

`{ASSETS}/<id>.glb`; `glb_export.json` lists them.
{_GLB_ABOUT}""",
    SCENES: f"""# Kitchens as GLB

`{SCENES}/<id>.glb`; `glb_export.json` lists them.
{_GLB_ABOUT}""",
}

# Urdf -----------------------------------------------------------------------------------------------------------------
# URDF as a form of export: written, read back, compared.

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
    """Build one kitchen, write its files and compare them."""
    request, scene = build_scene(recipe, cache)
    inside = f"{SCENES}/{scene.id}"
    disk.write_files(staged / inside, document.write_scene(scene))
    facts = {"placements": len(scene.placements), "list": f"{inside}/{document.LIST}", **measures_of(request, scene)}
    result = ExportResult(scene.id, f"{inside}/{document.FILE}", facts, credits=attribution.credits_of(scene))
    return _judged(staged, result, scene_differences(staged / inside, scene))


def _judged(staged: Path, result: ExportResult, problems: Sequence[Problem]) -> ExportResult:
    """The result, or a refusal where the files read back are not what was to be written; they are removed then."""
    if not problems:
        return result
    shutil.rmtree((staged / result.file).parent)
    told = "; ".join(f"{pointer}: {message}" for pointer, message in problems[:MAX_LISTED])
    more = f"; and {len(problems) - MAX_LISTED} more" if len(problems) > MAX_LISTED else ""
    return ExportResult(result.id, message=f"its URDF is not what was asked for: {told}{more}")


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

`{SCENES}/<id>/{document.FILE}`: all that stands fixed, as one tree of links below `world`; its names begin with
`<placement>__`. `{SCENES}/<id>/{document.LIST}`: what stands where, with position and quaternion (w, x, y, z) of its
root link, and the positions of its joints. What is loose (base `free`) is in no tree: load its `<asset>.urdf` at the
pose of the list.
{_URDF_ABOUT}""",
}
URDF = Form("urdf", _URDF_READMES, export_asset, export_scene)

# By plugin ------------------------------------------------------------------------------------------------------------
# A form of export that a plug-in writes.

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
            disk.write_files(staged / TRACES, Files(entries={f"{asset.id}.txt": error.trace.encode()}))
            return ExportResult(asset.id, message=f"{error}; the trace: {TRACES}/{asset.id}.txt")
        if wrong := [path for path in files if not _is_inside(path)]:
            return ExportResult(asset.id, message=f"plug-in {plugin.plugin.name}: {wrong[0]!r} leaves the folder")
        if not files:
            return ExportResult(asset.id, message=f"plug-in {plugin.plugin.name} wrote no file")
        disk.write_files(staged / inside, Files(entries=dict(sorted(files.items()))))
        facts = {"category": asset.labels.category, "plugin": f"{plugin.plugin.name} {plugin.version}"}
        return ExportResult(asset.id, f"{inside}/{min(files)}", facts)

    about = f"# Assets by {plugin.plugin.name}\n\n{exporter.about}\n\n`{ASSETS}/<id>/`, a folder for each asset.\n"
    return Form(name, {ASSETS: about}, write_asset, _no_scene)


def _is_inside(path: str) -> bool:
    place = PurePosixPath(path)
    return bool(place.parts) and not place.is_absolute() and ".." not in place.parts


def _no_scene(_: SceneRecipe, __: Path, ___: Path) -> ExportResult:
    raise CasaError("exporters of plug-ins write assets, no kitchens")
