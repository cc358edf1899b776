"""Assets one at a time (built from numbers, checked, written, read), poses in which they rest, own textures."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from casa_assets.api.kitchen import Kitchen
from casa_assets.core.numeric import Floats
from casa_assets.core.system import cache_dir
from casa_assets.errors import CasaError, OutputError, UnknownId
from casa_assets.families.family import Params
from casa_assets.geometry.mesh.trimesh_exchange import resting_sides
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Report
from casa_assets.model.kitchen.choices import Surface
from casa_assets.model.kitchen.scene import Scene
from casa_assets.model.kitchen.style import PresetChoice
from casa_assets.model.pose import Pose
from casa_assets.pipeline.cache.asset_store import AssetStore
from casa_assets.pipeline.families.run import FamilyRequest
from casa_assets.pipeline.families.run import params_of as drawn
from casa_assets.pipeline.ingest.job import writing
from casa_assets.pipeline.kitchens.check import run_checks_on_scene
from casa_assets.pipeline.kitchens.recipe import recipe_of
from casa_assets.pipeline.kitchens.resolve import build_scene, params_of
from casa_assets.pipeline.kitchens.scene_files import SCENE_JSON
from casa_assets.pipeline.kitchens.scene_json import design_of
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.asset_json import manifest_of
from casa_assets.pipeline.library.asset_package import check_package, write_package
from casa_assets.pipeline.textures.packs.ingest import PackOptions, PackReport, ingest_pack
from casa_assets.projects import project_folder
from casa_assets.registry.families import family as family_of
from casa_assets.registry.objects import object_family
from casa_assets.textures.packs.entry import PictureDescription

# Textures -------------------------------------------------------------------------------------------------------------
# Use the user's own pictures as textures of kitchens.


def ingest_textures(
    source: str | Path,
    pack: str = "",
    surface: str = "",
    tile_m: tuple[float, float] | None = None,
    licence: str = "",
    generator: str = "",
    substance: str = "",
    library: str | Path | None = None,
) -> PackReport:
    """Import pictures as a texture pack, as `casa-assets textures ingest` does.

    In a project the pack is written to its `textures/`, and from then on `kitchen(..., surfaces={"wall": id})` accepts
    its pictures. The values given here apply to each picture for which a `pack.yaml` in the folder does not state
    another.

    Args:
        source: folder of pictures.
        pack: name of the pack, which is the prefix of the ids of the pictures; if empty, the name of the folder.
        surface: wall, floor, counter or cabinet.
        tile_m: width and height of the area that a picture shows, metres.
        licence: SPDX id, or the text of the licence.
        generator: program or model that made the pictures.
        substance: id of a substance.
        library: folder to write to, instead of the project in use.
    Returns:
        Folder of the pack, its `pictures`, those that were `refused` with the reasons, and whether it `changed`.
    Raises:
        UnknownId: no such surface. CasaError: there is no such folder, an id is taken, or there is neither a project
            nor a `library` to write to. RegistryError: `pack.yaml` is wrong. OutputError: the folder cannot be written
            to.
    """
    place = project_folder() if library is None else Path(library)
    if place is None:
        raise CasaError("say where the pack is to be: casa.use_project(folder), or library=folder")
    if surface and surface not in list(Surface):
        raise UnknownId("surface", surface, [one.value for one in Surface])
    try:
        said = PictureDescription(
            surface=Surface(surface) if surface else None,
            tile_m=tile_m,
            licence=licence or None,
            generator=generator or None,
            substance=substance or None,
        )
    except ValidationError as error:
        first = error.errors()[0]
        raise CasaError(f"{'.'.join(map(str, first['loc']))}: {first['msg']}, got {first['input']!r}") from None
    with writing(place):
        return ingest_pack(Path(source), PackOptions(library=place, pack=pack or None, flags=said))


# Stable poses ---------------------------------------------------------------------------------------------------------
# Poses in which an asset rests on a plane, for placing or dropping it.

# Sides whose normals differ by less than this are one pose: the facets of something round. A choice.
SAME_SIDE_RAD = np.radians(10.0)


@dataclass(frozen=True)
class StablePose:
    """A way to rest on a plane.

    Attributes:
        pose: world_from_asset: the lowest point is at z = 0, the centre of mass above the origin.
        probability: probability of this pose if the asset is put down in a random orientation and only tips over edges.
    """

    pose: Pose
    probability: float


def stable_poses(asset: Asset, least: float = 0.02) -> list[StablePose]:
    """Return the poses in which an asset can rest on a plane, from its collision shapes, the most likely first.

    Joints are closed. Rolling is ignored, so that a round object rests in many poses, each of which is unlikely.

    Args:
        least: poses with a lower probability are left out.
    """
    masses = np.array([link.inertial.mass for link in asset.links])
    centers = [
        asset.asset_from_link(link.name).apply(np.array([link.inertial.center_of_mass]))[0] for link in asset.links
    ]
    center: Floats = masses @ np.array(centers) / masses.sum()
    points, rotations, shares = resting_sides(asset, center)
    sides: list[Floats] = []
    sums: list[float] = []
    for rotation, share in zip(rotations, shares.tolist(), strict=True):
        near = [k for k, side in enumerate(sides) if float(side[2] @ rotation[2]) >= np.cos(SAME_SIDE_RAD)]
        if near:
            sums[near[0]] += share
        else:
            sides.append(rotation)
            sums.append(share)
    order = sorted(range(len(sides)), key=lambda k: -sums[k])
    return [StablePose(_set_down(sides[k], points, center), sums[k]) for k in order if sums[k] >= least]


def _set_down(rotation: Floats, points: Floats, center: Floats) -> Pose:
    matrix = np.eye(4)
    matrix[:3, :3] = rotation
    matrix[:2, 3] = -(rotation @ center)[:2]
    matrix[2, 3] = -float((points @ rotation[2]).min())
    return Pose.from_matrix(matrix)


# Assets ---------------------------------------------------------------------------------------------------------------
# Single assets: built from parameters, checked, written and read.


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
