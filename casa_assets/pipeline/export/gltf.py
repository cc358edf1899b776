"""GLB as a form of export: one file for each asset or kitchen, to look at in other programs and on web pages."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from casa_assets.export.gltf import EVERYTHING, SEEN_ALONE, Layers, asset_glb, scene_glb
from casa_assets.pipeline.export.certified import certified_asset
from casa_assets.pipeline.export.form import ASSETS, SCENES, ExportResult, Form
from casa_assets.pipeline.kitchens.recipe import SceneRecipe
from casa_assets.pipeline.reports import attribution


def glb_form(with_layers: bool = False) -> Form:
    """The form; `with_layers` puts collision shapes and regions into the files, which other programs show as well."""
    layers = EVERYTHING if with_layers else SEEN_ALONE
    return Form("glb", _READMES, partial(_asset, layers=layers), partial(_scene, layers=layers))


def _asset(folder: Path, staged: Path, layers: Layers) -> ExportResult:
    asset = certified_asset(folder)
    data = asset_glb(asset, layers)
    facts = {"category": asset.labels.category, "mass_kg": asset.mass, "bytes": len(data)}
    return ExportResult(asset.id, _put(staged, f"{ASSETS}/{asset.id}.glb", data), facts)


def _scene(recipe: SceneRecipe, staged: Path, cache: Path, layers: Layers) -> ExportResult:
    # Here, since this loads all families.
    from casa_assets.pipeline.export.scenes import measures_of
    from casa_assets.pipeline.kitchens.resolve import build_scene

    request, scene = build_scene(recipe, cache)
    data = scene_glb(scene, layers)
    facts = {"placements": len(scene.placements), "bytes": len(data), **measures_of(request, scene)}
    file = _put(staged, f"{SCENES}/{scene.id}.glb", data)
    return ExportResult(scene.id, file, facts, attribution.credits_of(scene))


def _put(staged: Path, file: str, data: bytes) -> str:
    """Write a file below the staging folder; returns its path there."""
    target = staged / file
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(data)
    return file


_ABOUT = """
Binary glTF 2.0: metres, y up, pictures of at most 512 pixels. It is for looking at: there is no mass and no friction,
and nothing collides. Every link is a node that can be moved; its `extras` say about which axis and how far.
"""
_READMES = {
    ASSETS: f"""# Assets as GLB

`{ASSETS}/<id>.glb`; `glb_export.json` lists them.
{_ABOUT}""",
    SCENES: f"""# Kitchens as GLB

`{SCENES}/<id>.glb`; `glb_export.json` lists them.
{_ABOUT}""",
}
