"""A plan in a style as an object that can be loaded into MuJoCo, written to disk, checked and looked at."""

from __future__ import annotations

import copy
import json
import shlex
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, Concatenate, Literal, ParamSpec, TypeVar

import mujoco

from casa_assets.addons.batch.batch_form import batch_of
from casa_assets.api.behaviors import StartStates
from casa_assets.asset.lightweight import light_scene
from casa_assets.core.system import cache_dir
from casa_assets.errors import CasaError, OutputError, UnknownId
from casa_assets.families.asset_store import AssetStore
from casa_assets.formats.mjcf import batch
from casa_assets.formats.mjcf import kitchen as mjcf
from casa_assets.layouts.order.build_order import KitchenRequest as Resolved
from casa_assets.layouts.run.check import run_checks_on_scene
from casa_assets.layouts.run.kept import is_drawn, is_whole
from casa_assets.layouts.run.load_scene import FILES, SurfaceTextures, model_of, spec_of
from casa_assets.layouts.run.recipe import SceneRecipe, recipe_of
from casa_assets.layouts.run.resolve import build_scene, draw_surfaces, ordered_models, ordered_surfaces, resolve
from casa_assets.layouts.run.scene_folders import BuildOptions, publish_scene, scene_key
from casa_assets.layouts.run.scene_json import describe, design_of, surface_finishes
from casa_assets.layouts.run.state_file import read_current_states
from casa_assets.library.library import Library
from casa_assets.model.issue import Files, Report
from casa_assets.model.kitchen.choices import Surface
from casa_assets.model.kitchen.files import SCENE_JSON, START_STATES
from casa_assets.model.kitchen.scene import Scene
from casa_assets.projects import in_use, using
from casa_assets.runs.outcome import writing

if TYPE_CHECKING:
    import trimesh

P = ParamSpec("P")
R = TypeVar("R")
Detail = Literal["full", "light", "batch"]
# Where the command line puts scenes if no folder is named; it is read here and never written.
SCENES_FOLDER = Path("out/scenes")


def _in_its_project(method: Callable[Concatenate[Kitchen, P], R]) -> Callable[Concatenate[Kitchen, P], R]:
    """Decorator: the method uses the project that was in use when the kitchen was made or opened."""

    @wraps(method)
    def run(self: Kitchen, /, *args: P.args, **kwargs: P.kwargs) -> R:
        with using(self._use):
            return method(self, *args, **kwargs)

    return run


class Kitchen:
    """A kitchen, made by `kitchen(...)` or opened by `load(folder)`; it is composed when a part is first used.

    Attributes:
        id: such as `galley__rustic__s7`; the same id gives the same scene files with one version of the program.
        detail: form in which MuJoCo gets it. `full`; `light`: primitive shapes in plain colours; or `batch`: fewer
            primitives, merged across fixtures, some joints locked, bodies at rest asleep, for thousands of copies.
        folder: folder that it was opened from, whose files are used as they are; None if it was made.
    """

    def __init__(self, source: SceneRecipe | Path, detail: Detail = "full") -> None:
        """Made by `kitchen` and `load`. Raises CasaError if the plan and the style do not fit together."""
        if detail not in FILES:
            raise UnknownId("detail", detail, FILES)
        self.detail, self._use = detail, in_use()
        if isinstance(source, SceneRecipe):
            resolve(source)
            self.id, self.folder, self.recipe = source.scene_id, None, source
        else:
            self.id, self.folder = source.absolute().name, source

    def __repr__(self) -> str:
        """Text such as `<Kitchen galley__rustic__s7>`."""
        return f"<Kitchen {self.id}>"

    @cached_property
    @_in_its_project
    def recipe(self) -> SceneRecipe:
        """Its recipe: plan, style, seed, surfaces, models, objects and so on."""
        assert self.folder is not None
        return recipe_of(self.id, (self.folder.absolute().parent,))

    @cached_property
    @_in_its_project
    def _built(self) -> tuple[Resolved, Scene]:
        return build_scene(self.recipe, cache_dir())

    @property
    def scene(self) -> Scene:
        """The resolved scene: assets, placements, cameras, lights. Metres, z up, world frame."""
        return self._built[1]

    @cached_property
    @_in_its_project
    def facts(self) -> dict[str, Any]:
        """The content of `scene.json`: fixtures, joints, regions in the world frame, tasks, parking places."""
        if self.folder is None:
            return describe(self.recipe, *self._built)
        path = self.folder / SCENE_JSON
        try:
            found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise OutputError(str(path), f"is missing or damaged: {error}") from error
        return found

    def with_detail(self, detail: Detail) -> Kitchen:
        """Return the same kitchen in another form; what is composed already is shared."""
        if detail not in FILES:
            raise UnknownId("detail", detail, FILES)
        other = copy.copy(self)
        other.detail = detail
        return other

    def to_mjspec(self, sleep: bool = False) -> mujoco.MjSpec:
        """Return an MjSpec, to attach a robot and objects to before it is compiled; see `to_mjmodel`."""
        return spec_of(self._source(), sleep)

    def to_mjmodel(self, sleep: bool = False) -> mujoco.MjModel:
        """Return a compiled model with the keyframes `start`, `closed` and `open`; only the cache is written.

        Args:
            sleep: let MuJoCo skip bodies at rest until something moves them, which is several times as fast; the batch
                form always does.
        Raises:
            CasaError: a part cannot be built, or the folder has no file of this form.
        """
        return model_of(self._source(), sleep)

    def to_trimesh(self, what: Literal["visual", "collision"] = "visual") -> trimesh.Scene:
        """Return its visual meshes or its collision shapes in full detail; metres, z up, every joint where it starts.

        There is a node per link of each placement, such as `fridge__door`, and below it one for each geometry.
        """
        from casa_assets.mesh.trimesh_exchange import kitchen_to_trimesh

        return kitchen_to_trimesh(self.scene, what)

    @_in_its_project
    def textures_of(self, model: mujoco.MjModel) -> SurfaceTextures:
        """Return the surface pictures in a compiled model, which can then be replaced without recompiling it.

        Args:
            model: compiled from this kitchen in its full form, including anything that was added to its spec; it is
                changed in place.
        """
        covers = surface_finishes(self._built[0].style) if self.folder is None else self.facts.get("covers", {})
        return SurfaceTextures(model, covers, cache_dir())

    def start_states(self, model: mujoco.MjModel) -> StartStates:
        """Return the start states that `casa-assets scenes states` drew in its folder, to reset simulations of it.

        Args:
            model: compiled from this kitchen in its full or light form, including anything that was added to its spec.
        Raises:
            CasaError: it was not opened from a folder, there are no start states, the file is damaged, they belong to
                another scene.xml than the one next to them, or the model lacks one of their joints.
        """
        if self.folder is None:
            raise CasaError(f"{self.id}: start states are in the folder of a kitchen; open it with casa_assets.load")
        found = read_current_states(self.folder, self.folder / FILES["full"])
        return StartStates(found, model, self.folder / START_STATES)

    @_in_its_project
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
        library, key = Library(Path(folder)), scene_key(self.recipe)
        target = library.root / self.id
        with library.locked(), writing(library.root):
            library.sweep()
            if not is_whole(target, key) or (picture and not is_drawn(target, key)):
                publish_scene(self.recipe, *self._built, library, BuildOptions(drawn=picture), key)
        return target

    @_in_its_project
    def check(self) -> Report:
        """Run every check that applies, which takes ten to twenty seconds.

        The files in its folder are checked, or, if it was made, those that `write` writes to a temporary folder.
        """
        resolved, scene = self._built
        with tempfile.TemporaryDirectory(prefix="casa-assets-") as place:
            folder = self.folder or self.write(place)
            return run_checks_on_scene(scene, design_of(resolved, scene), folder)[0]

    @_in_its_project
    def show(self, pose: str = "", web: bool = False) -> None:
        """Show it until the window is closed, or until Ctrl-C ends the page.

        Args:
            pose: keyframe to begin in, such as `open`.
            web: serve a page for the browser even if there is a screen for MuJoCo's viewer.
        """
        from casa_assets.api.assets import show_subject
        from casa_assets.show.view import subject

        place = SCENES_FOLDER if self.folder is None else self.folder.absolute().parent
        show_subject(subject.Kitchen(self.recipe, place, is_named_by_path=self.folder is not None), pose, web)

    @_in_its_project
    def _source(self) -> Path | Files:
        """The MJCF of its form: a file in its folder, or files in memory."""
        if (folder := self.folder) is not None:
            file = folder / FILES[self.detail]
            if file.is_file():
                return file
            if folder.is_dir() and self.detail == "batch":
                where = f"casa-assets scenes batch {folder.name} --out {shlex.quote(str(folder.parent))}"
                raise CasaError(f"{file}: there is no such file; {where} writes it")
            raise CasaError(f"{file}: there is no such file; name the folder of a scene")
        if self.detail == "batch":
            entries = dict(batch.write(batch_of(self.scene, cache_dir()), shared="assets").entries)
            return Files.of({mjcf.FILE: entries.pop(batch.FILE), **entries})
        store = AssetStore(cache_dir())
        form = self.scene if self.detail == "full" else light_scene(self.scene, store.lightened)
        files = mjcf.write(form, shared="assets")
        store.tidy()
        return files


def kitchen(
    plan: str,
    style: str | None = None,
    *,
    seed: int | None = None,
    detail: Detail = "full",
    surfaces: Mapping[str, str] | Literal["random"] | None = None,
    closed: bool = False,
    objects: int = 0,
    objects_seed: int = 0,
    mixed: bool = False,
    models: Mapping[str, str] | None = None,
) -> Kitchen:
    """Return a floor plan in a style.

    Args:
        plan: name of a floor plan, see `plans()`. Without a style: the id of a kitchen, such as `l_small__coastal`, or
            one printed by `casa-assets scenes new`, such as `galley__rustic__s7__t5c1d2e3f`. What such an id holds as a
            digest is looked for in `out/scenes` of the working folder.
        style: name of a style, see `styles()`.
        seed: seed that draws the lengths of the plan within their bounds; None: the lengths of the plan.
        detail: `full`, `light` or `batch`; see `Kitchen`.
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
        UnknownId: no such plan, style, id, detail, surface, texture, role or model; the error names the nearest.
        CasaError: a number of objects is negative, a model does not suit its role, its role is not in the plan, the
            plan does not fit together with these lengths or this style, or the id has another seed.
    """
    for name, number in (("objects", objects), ("objects_seed", objects_seed)):
        if number < 0:
            raise CasaError(f"{name}={number}: it has to be 0 or more")
    recipe = recipe_of(plan, (SCENES_FOLDER,)) if style is None else SceneRecipe(plan, style)
    if seed is not None and recipe.seed not in (None, seed):
        raise CasaError(f"{plan}: has the seed {recipe.seed}; leave the seed {seed} out, or write s{seed} in the id")
    seed = recipe.seed if seed is None else seed
    finishes = draw_surfaces(seed or 0) if surfaces == "random" else ordered_surfaces(_pairs(surfaces or {}))
    recipe = replace(
        recipe,
        seed=seed,
        surfaces=finishes or recipe.surfaces,
        closed=closed or recipe.closed,
        objects=objects or recipe.objects,
        objects_seed=objects_seed or recipe.objects_seed,
        mixed=mixed or recipe.mixed,
        models=ordered_models((models or {}).items()) or recipe.models,
    )
    return Kitchen(recipe, detail)


def _pairs(surfaces: Mapping[str, str]) -> Iterator[tuple[Surface, str]]:
    """Pairs of a surface and its texture. Raises UnknownId."""
    for name, texture in surfaces.items():
        if name not in list(Surface):
            raise UnknownId("surface", name, [s.value for s in Surface])
        yield Surface(name), texture
