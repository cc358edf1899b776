"""Single assets: built from parameters, checked, written and read."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from casa_assets.api.kitchen import Kitchen
from casa_assets.core.cache_folder import cache_dir
from casa_assets.errors import CasaError, OutputError
from casa_assets.families.family import Params
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Report
from casa_assets.model.kitchen.scene import Scene
from casa_assets.model.kitchen.style import PresetChoice
from casa_assets.pipeline.cache.asset_store import AssetStore
from casa_assets.pipeline.families.run import FamilyRequest
from casa_assets.pipeline.families.run import params_of as drawn
from casa_assets.pipeline.ingest.job import writing
from casa_assets.pipeline.kitchens.check import run_checks_on_scene
from casa_assets.pipeline.kitchens.resolve import build_scene, params_of
from casa_assets.pipeline.kitchens.scene_files import SCENE_JSON
from casa_assets.pipeline.kitchens.scene_ids import recipe_of
from casa_assets.pipeline.kitchens.scene_json import design_of
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.asset_json import manifest_of
from casa_assets.pipeline.library.asset_package import check_package, write_package
from casa_assets.registry.families import family as family_of
from casa_assets.registry.objects import object_family


def build(family: str, preset: str = "", params: Params | Mapping[str, Any] | None = None) -> Asset:
    """Build a member of a family.

    Args:
        family: name, see `families()`.
        preset: name of a ready member; if empty, the first of the family.
        params: numbers and choices that differ from the preset's, or all of them as `sample` returns them.
    Raises:
        UnknownId: no such family, preset or finish. CasaError: the numbers are out of bounds or contradict each other.
    """
    found = family_of(family)
    if isinstance(params, Params):
        if not isinstance(params, found.params) or preset:
            raise CasaError(f"{family}: give a preset, or {found.params.__name__}, got {type(params).__name__}")
        numbers: Params = params
    else:
        named = f"{family}/{preset or next(iter(found.presets))}"
        numbers = params_of(PresetChoice.model_validate({"preset": named, **(params or {})}))
    store = AssetStore(cache_dir())
    try:
        made = store.built(found, numbers)
    except ValueError as error:
        raise CasaError(f"{family}: {error}") from error
    store.tidy()
    return made


def sample(family: str, seed: int = 0, index: int = 0) -> Params:
    """Return random parameters for `build`: draw `index` of a seed; the same pair gives the same parameters.

    Raises:
        UnknownId: no such family.
    """
    return drawn(FamilyRequest(family, seed=seed, index=index))


def build_object(category: str, seed: int = 0, index: int = 0) -> Asset:
    """Build a loose object, such as an apple, as `casa-assets objects build` does for draw `index` of a seed.

    Args:
        category: a category that has objects; `casa-assets objects list` prints them.
    Raises:
        UnknownId: there are no objects of that category; the error names the nearest.
    """
    member = object_family(category)
    store = AssetStore(cache_dir())
    made = store.built(member, drawn(FamilyRequest(category, seed=seed, index=index, is_object=True)))
    store.tidy()
    return made


def write(asset: Asset, folder: str | Path) -> Path:
    """Write an asset as MJCF and USD with a picture, and `asset.json`, which `read_asset` reads back.

    Args:
        folder: created if missing.
    Returns:
        `<folder>/<id of the asset>`, which is overwritten if it exists.
    Raises:
        OutputError: the folder cannot be written to, or another run is writing to it.
    """
    library = disk.Library(Path(folder))
    target = library.root / asset.id
    with library.locked(), writing(library.root):
        library.sweep()
        staged = library.stage(asset.id)
        write_package(asset, staged)
        text = json.dumps({"asset": manifest_of(asset)}, sort_keys=True, indent=1, ensure_ascii=False)
        (staged / disk.CERTIFICATE).write_text(text + "\n", encoding="utf-8")
        library.put(staged, target)
    return target


def read_asset(folder: str | Path) -> Asset:
    """Return the asset in a folder of a library or one that `write` made, including meshes and textures.

    Raises:
        OutputError: a file is missing or damaged.
    """
    return disk.read_asset(Path(folder))


def check(subject: Asset | Kitchen | str | Path) -> Report:
    """Run every check that applies; about a second for an asset, ten to twenty for a kitchen.

    Args:
        subject: an asset or a kitchen, which is written to a temporary folder for the checks; or the folder of an asset
            or of a scene, which is only read.
    Raises:
        OutputError: the folder contains neither an asset nor a scene, or is damaged.
    """
    if isinstance(subject, Asset):
        with tempfile.TemporaryDirectory(prefix="casa-assets-") as place:
            folder = Path(place) / subject.id
            folder.mkdir()
            write_package(subject, folder)
            return check_package(subject, folder)
    if isinstance(subject, Kitchen):
        with tempfile.TemporaryDirectory(prefix="casa-assets-") as place:
            return _check_scene(subject.resolved, subject.scene, subject.write(place))
    folder = Path(subject)
    if (folder / SCENE_JSON).is_file():
        recipe = recipe_of(folder.absolute().name, (folder.absolute().parent,))
        return _check_scene(*build_scene(recipe, cache_dir()), folder)
    if (folder / disk.CERTIFICATE).is_file():
        return check_package(disk.read_asset(folder), folder)
    raise OutputError(str(folder), f"holds neither {SCENE_JSON} of a scene nor {disk.CERTIFICATE} of an asset")


def _check_scene(kitchen: KitchenRequest, scene: Scene, folder: Path) -> Report:
    """Run every check on a scene in its folder."""
    report, _ = run_checks_on_scene(scene, design_of(kitchen, scene), folder)
    return report
