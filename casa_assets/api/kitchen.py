"""A plan in a style as an object that can be loaded into MuJoCo or written to disk."""

from __future__ import annotations

import json
import os
import re
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, overload

import mujoco

from casa_assets.api.behaviors import StartStates
from casa_assets.core.system import cache_dir
from casa_assets.errors import CasaError, UnknownId
from casa_assets.export.mjcf.scene import batch
from casa_assets.export.mjcf.scene import kitchen as mjcf
from casa_assets.geometry.lightweight import light_scene
from casa_assets.layouts.order.request import KitchenRequest as Resolved
from casa_assets.model.asset.asset import Asset
from casa_assets.model.files import Files
from casa_assets.model.kitchen.choices import Surface
from casa_assets.model.kitchen.scene import Placement, Scene
from casa_assets.pipeline.cache.asset_store import AssetStore
from casa_assets.pipeline.ingest.job import writing
from casa_assets.pipeline.kitchens.batch_form import batch_of
from casa_assets.pipeline.kitchens.kept import is_drawn, is_whole
from casa_assets.pipeline.kitchens.load_scene import FILES, SurfaceTextures, model_of, spec_of
from casa_assets.pipeline.kitchens.recipe import SceneRecipe, recipe_of
from casa_assets.pipeline.kitchens.resolve import build_scene, draw_surfaces, ordered_models, ordered_surfaces, resolve
from casa_assets.pipeline.kitchens.scene_files import SCENE_JSON, START_STATES
from casa_assets.pipeline.kitchens.scene_folders import BuildOptions, is_current, publish_scene, scene_key
from casa_assets.pipeline.kitchens.scene_json import describe, surface_finishes
from casa_assets.pipeline.kitchens.state_file import read_current_states
from casa_assets.pipeline.library import library as disk
from casa_assets.registry.kitchens import plan_names

Weight = Literal["full", "light", "batch"]
# Where the command line puts scenes that are not told where to go; it is read here and never written.
SCENES_FOLDER = Path("out/scenes")
_ID = re.compile(r"[a-z][a-z0-9]*(_{1,2}[a-z0-9]+)*")


class Kitchen:
    """A kitchen, made by `kitchen(...)`; it is composed when one of its parts is first used.

    Attributes:
        id: such as `galley__rustic__s7`; the same id gives the same scene files with one version of the program.
        plan, style: names.
        seed: seed that drew the lengths, or None.
        closed: whether open walls are drawn too.
        surfaces: surface -> texture, for those that differ from the style's.
        models: role -> model, for those that differ from the style's.
    """

    def __init__(self, recipe: SceneRecipe) -> None:
        """Check the recipe. Raises CasaError if the plan and the style do not fit together."""
        self._recipe = recipe
        resolve(recipe)
        self.id, self.plan, self.style = recipe.scene_id, recipe.plan, recipe.style
        self.seed, self.closed = recipe.seed, recipe.closed
        self.surfaces: Mapping[str, str] = {surface.value: name for surface, name in recipe.surfaces}
        self.models: Mapping[str, str] = dict(recipe.models)

    def __repr__(self) -> str:
        """Text such as `<Kitchen galley__rustic__s7>`."""
        return f"<Kitchen {self.id}>"

    @cached_property
    def _built(self) -> tuple[Resolved, Scene]:
        return build_scene(self._recipe, cache_dir())

    @property
    def scene(self) -> Scene:
        """The resolved scene: assets, placements, cameras, lights. Metres, z up, world frame."""
        return self._built[1]

    @property
    def resolved(self) -> Resolved:
        """The plan in metres: room, openings, runs, units and the position of each requested item."""
        return self._built[0]

    @property
    def placements(self) -> tuple[Placement, ...]:
        """Placed assets: a name, the id of the asset, world_from_asset, and the starting positions of its joints."""
        return self.scene.placements

    @property
    def assets(self) -> Mapping[str, Asset]:
        """Every asset that is used in it, by id, each once."""
        return {asset.id: asset for asset in self.scene.assets}

    @cached_property
    def facts(self) -> dict[str, Any]:
        """The content of `scene.json`: fixtures, joints, regions in the world frame, tasks, parking places."""
        return describe(self._recipe, *self._built)

    def to_mjmodel(self, weight: Weight = "full", sleep: bool = False) -> mujoco.MjModel:
        """Compile a model with the keyframes `start`, `closed` and `open`; nothing is written except to the cache.

        Args:
            weight: `full`; `light`: primitive shapes in plain colours; or `batch`: fewer primitives, merged across
                fixtures, some joints locked, bodies at rest asleep, for thousands of copies at once.
            sleep: let MuJoCo skip bodies at rest until something moves them; the batch form always does.
        Raises:
            UnknownId: no such weight. CasaError: a part cannot be built.
        """
        return model_of(self._mjcf(weight), sleep)

    def to_mjspec(self, weight: Weight = "full", sleep: bool = False) -> mujoco.MjSpec:
        """An MjSpec of the kitchen, to attach a robot and objects to before it is compiled."""
        return spec_of(self._mjcf(weight), sleep)

    def textures_of(self, model: mujoco.MjModel) -> SurfaceTextures:
        """Return the surface pictures in a compiled model, which can then be replaced without recompiling it.

        Args:
            model: compiled from this kitchen in its full form, including anything that was added to its spec; it is
                changed in place.
        """
        return SurfaceTextures(model, surface_finishes(self.resolved.style), cache_dir())

    def write(self, folder: str | Path, picture: bool = False) -> Path:
        """Write MJCF (full and light), USD and scene.json, as `casa-assets scenes new` does.

        Args:
            folder: folder of scenes, created if missing; files shared by scenes are put into `assets` in it.
            picture: draw `overview.png` too.
        Returns:
            `<folder>/<id>`. If it exists already and is up to date, it is left unchanged.
        Raises:
            OutputError: the folder cannot be written to, or another run is writing to it.
        """
        library, key = disk.Library(Path(folder)), scene_key(self._recipe)
        target = library.root / self.id
        with library.locked(), writing(library.root):
            library.sweep()
            if not is_whole(target, key) or (picture and not is_drawn(target, key)):
                publish_scene(self._recipe, *self._built, library, BuildOptions(drawn=picture), key)
        return target

    def _mjcf(self, weight: Weight) -> Files:
        """The files of its MJCF in memory."""
        if weight not in FILES:
            raise UnknownId("weight", weight, FILES)
        if weight == "batch":
            entries = dict(batch.write(batch_of(self.scene, cache_dir()), shared="assets").entries)
            return Files.of({mjcf.FILE: entries.pop(batch.FILE), **entries})
        store = AssetStore(cache_dir())
        form = self.scene if weight == "full" else light_scene(self.scene, store.lightened)
        files = mjcf.write(form, shared="assets")
        store.tidy()
        return files


def kitchen(
    plan: str,
    style: str,
    seed: int | None = None,
    surfaces: Mapping[str, str] | Literal["random"] | None = None,
    closed: bool = False,
    objects: int = 0,
    objects_seed: int = 0,
    mixed: bool = False,
    models: Mapping[str, str] | None = None,
) -> Kitchen:
    """Return a floor plan in a style.

    Args:
        plan: name of a floor plan, see `plans()`.
        style: name of a style, see `styles()`.
        seed: seed that draws the lengths of the plan within their bounds; None: the lengths of the plan.
        surfaces: wall, floor, counter or cabinet -> texture, see `surfaces()`; `random`: each drawn independently by
            the seed.
        closed: draw the walls too that a plan leaves open.
        objects: number of objects to put where people keep them: plates in cupboards, food in the refrigerator. If
            there is not enough room, there are fewer; `facts["objects"]` lists them.
        objects_seed: seed that draws the objects and their places.
        mixed: draw fronts, appliances, furniture and small objects from all styles, by the seed.
        models: role of a style, such as `range` or `fridge` -> model that replaces the style's: a preset of a family
            (`range/pro_six`), or an asset of a library of the project (`library:<id>`).
    Raises:
        UnknownId: no such plan, style, surface, texture, role or model; the error names the nearest.
        CasaError: a number of objects is negative, a model does not suit its role, its role is not in the plan, or the
            plan does not fit together with these lengths or this style.
    """
    for name, number in (("objects", objects), ("objects_seed", objects_seed)):
        if number < 0:
            raise CasaError(f"{name}={number}: it has to be 0 or more")
    finishes = draw_surfaces(seed or 0) if surfaces == "random" else ordered_surfaces(_pairs(surfaces or {}))
    chosen = ordered_models((models or {}).items())
    return Kitchen(SceneRecipe(plan, style, seed, finishes, closed, objects, objects_seed, mixed, chosen))


def _pairs(surfaces: Mapping[str, str]) -> Iterator[tuple[Surface, str]]:
    """Pairs of a surface and its texture. Raises UnknownId."""
    for name, texture in surfaces.items():
        if name not in list(Surface):
            raise UnknownId("surface", name, [s.value for s in Surface])
        yield Surface(name), texture


@overload
def load_scene(
    scene: str | Path,
    textures: Mapping[str, str] | None = None,
    weight: Weight = "full",
    out: Path | str | None = None,
    as_spec: Literal[False] = False,
    sleep: bool = False,
    seed: int | None = None,
) -> mujoco.MjModel: ...


@overload
def load_scene(
    scene: str | Path,
    textures: Mapping[str, str] | None = None,
    weight: Weight = "full",
    out: Path | str | None = None,
    *,
    as_spec: Literal[True],
    sleep: bool = False,
    seed: int | None = None,
) -> mujoco.MjSpec: ...


@overload
def load_scene(
    scene: str | Path,
    textures: Mapping[str, str] | None = None,
    weight: Weight = "full",
    out: Path | str | None = None,
    as_spec: bool = False,
    sleep: bool = False,
    seed: int | None = None,
) -> mujoco.MjModel | mujoco.MjSpec: ...


def load_scene(
    scene: str | Path,
    textures: Mapping[str, str] | None = None,
    weight: Weight = "full",
    out: Path | str | None = None,
    as_spec: bool = False,
    sleep: bool = False,
    seed: int | None = None,
) -> mujoco.MjModel | mujoco.MjSpec:
    """Load a kitchen into MuJoCo, by its id or from its folder.

    An id is looked for in `out`, or in `out/scenes` of the working folder. A scene that an older version of this
    package wrote there is not loaded but made again: in `out` if that is given, else in memory.

    Args:
        scene: id such as `l_small__coastal`, or an id printed by `casa-assets scenes new`, such as
            `galley__rustic__s7__t5c1d2e3f`; or the path of a scene's folder or of one of its XML files, which is loaded
            as it is.
        textures: pictures that differ from the scene's, by surface: wall, floor, counter, cabinet. Not for specs.
        weight: `full`; `light`: primitive shapes in plain colours; or `batch`: at most 300 of them, for thousands of
            copies at once, as `casa-assets scenes batch` writes it. For the path of an XML file, the form that it holds
            is used.
        out: folder of scenes; the scene is written to it if missing.
        as_spec: return an MjSpec, to which a robot and objects can be added, instead of a compiled MjModel.
        sleep: let MuJoCo skip bodies at rest until something moves them, which is several times as fast; the batch form
            always does.
        seed: seed that draws the lengths of the plan, as for `kitchen()` and `casa-assets scenes new`; for an id
            without a seed.
    Returns:
        MjModel or MjSpec. Keyframes: start, closed, open.
    Raises:
        UnknownId: no such scene, weight, surface or texture. CasaError: the scene cannot be built or found, or both
            `textures` and `as_spec` are given.
    """
    if weight not in FILES:
        raise UnknownId("weight", weight, FILES)
    if textures and as_spec:
        raise CasaError("textures are swapped in a compiled model; give surfaces to kitchen() and take its to_mjspec()")
    place = None if out is None else Path(out)
    source, covered = _found(scene if seed is None else _seeded(scene, seed, place), weight, place)
    if as_spec:
        return spec_of(source, sleep)
    model = model_of(source, sleep)
    if textures:
        SurfaceTextures(model, covered, cache_dir()).show(textures)
    return model


def start_states(scene: str | Path, model: mujoco.MjModel, out: Path | str | None = None) -> StartStates:
    """Return the start states that `casa-assets scenes states` drew for a kitchen, to reset simulations of it.

    Args:
        scene: id, looked for in `out` or in `out/scenes` of the working folder; or the path of a scene's folder.
        model: compiled from that kitchen in its full or light form, including anything that was added to its spec.
        out: folder of scenes.
    Raises:
        CasaError: there are no start states, the file is damaged, they belong to another scene.xml than the one next to
            them, or the model lacks one of their joints.
    """
    folder = Path(scene) if _is_path(scene) else (SCENES_FOLDER if out is None else Path(out)) / str(scene)
    found = read_current_states(folder, folder / FILES["full"])
    return StartStates(found, model, folder / START_STATES)


def _found(scene: str | Path, weight: Weight, out: Path | None) -> tuple[Path | Files, Mapping[str, list[str]]]:
    """The MJCF of a scene, on disk or in memory, and the finishes that cover its surfaces."""
    place = SCENES_FOLDER if out is None else out
    found = folder_or_kitchen(scene, weight, place)
    if isinstance(found, Kitchen):
        is_written = out is not None and weight != "batch"
        source = found.write(place) / FILES[weight] if is_written else found._mjcf(weight)
        return source, surface_finishes(found.resolved.style)
    file = found / FILES[weight] if found.is_dir() else found
    if not file.is_file():
        if found.is_dir() and weight == "batch":
            where = f"casa-assets scenes batch {found.name} --out {shlex.quote(str(found.parent))}"
            raise CasaError(f"{file}: there is no such file; {where} writes it")
        raise CasaError(f"{file}: there is no such file; name the folder of a scene, an XML file of it, or an id")
    return file, _covers(file.parent)


def folder_or_kitchen(scene: str | Path, weight: Weight, out: Path) -> Path | Kitchen:
    """Return the path of a scene, or its kitchen if there is no up-to-date file on disk.

    A path is returned unchanged. For an id it is the scene's folder in `out` if its file of this weight is up to date.
    """
    if _is_path(scene):
        return Path(scene)
    recipe = recipe_of(str(scene), (out,))
    folder = out / recipe.scene_id
    return folder if is_current(recipe, out) and (folder / FILES[weight]).is_file() else Kitchen(recipe)


def _seeded(scene: str | Path, seed: int, out: Path | None) -> str:
    """Id of a kitchen with a seed. Raises CasaError for a path, and for an id that has another seed."""
    if _is_path(scene):
        raise CasaError(f"{scene}: is a path, and what stands there has its lengths; give an id with a seed")
    recipe = recipe_of(str(scene), (SCENES_FOLDER if out is None else out,))
    if recipe.seed not in (None, seed):
        raise CasaError(f"{scene}: has the seed {recipe.seed}; leave the seed {seed} out, or write s{seed} in the id")
    return replace(recipe, seed=seed).scene_id


def _is_path(scene: str | Path) -> bool:
    if isinstance(scene, Path) or os.sep in scene or _ID.fullmatch(scene) is None:
        return True
    return scene.partition("__")[0] not in plan_names() and Path(scene).is_dir()


def _covers(folder: Path) -> Mapping[str, list[str]]:
    """Finishes that cover the surfaces of a scene on disk; empty if its scene.json does not state them."""
    try:
        covers = json.loads((folder / SCENE_JSON).read_text(encoding="utf-8"))["covers"]
        return {str(surface): [str(name) for name in names] for surface, names in covers.items()}
    except (OSError, ValueError, KeyError, AttributeError, TypeError):
        return {}
