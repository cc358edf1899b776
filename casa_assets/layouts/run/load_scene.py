"""Files of a scene into MuJoCo, and other pictures on its surfaces without compiling it again."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from casa_assets.errors import CasaError, UnknownId
from casa_assets.formats.mjcf.kitchen import FILE
from casa_assets.layouts.run.resolve import ordered_surfaces
from casa_assets.model.asset.material import Material
from casa_assets.model.issue import Files
from casa_assets.model.kitchen.choices import Surface
from casa_assets.model.kitchen.files import BATCH_FILE, LIGHT_FILE
from casa_assets.model.record import Vec2
from casa_assets.model.registry.rows import TextureRecipe
from casa_assets.textures.run.recipes import find_recipe, finish_of

FILES = {"full": FILE, "light": LIGHT_FILE, "batch": BATCH_FILE}
SLEEP = int(mujoco.mjtEnableBit.mjENBL_SLEEP)


def model_of(source: Path | Files, sleep: bool = False) -> mujoco.MjModel:
    """A compiled model of a scene file, or of the files of a scene in memory, in which `scene.xml` names the others.

    Args:
        sleep: let MuJoCo leave out what is at rest until something moves it, which is some times as fast. It is never
            in the files: MuJoCo 3.3 does not know it.
    """
    if isinstance(source, Path):
        model = mujoco.MjModel.from_xml_path(str(source))
    else:
        model = mujoco.MjModel.from_xml_string(*_in_memory(source))
    model.opt.enableflags |= SLEEP if sleep else 0
    return model


def spec_of(source: Path | Files, sleep: bool = False) -> mujoco.MjSpec:
    """An MjSpec of the scene that is not compiled yet, to add a robot and objects to."""
    if isinstance(source, Path):
        spec = mujoco.MjSpec.from_file(str(source))
    else:
        text, assets = _in_memory(source)
        spec = mujoco.MjSpec.from_string(text, assets=assets)
    spec.option.enableflags |= SLEEP if sleep else 0
    return spec


def _in_memory(files: Files) -> tuple[str, dict[str, bytes]]:
    return files.entries[FILE].decode(), {path: data for path, data in files.entries.items() if path != FILE}


@dataclass(frozen=True)
class _Covering:
    """The parts of a model that show one finish.

    Attributes:
        materials, pictures, meshes: their numbers in the model.
        tile_m: true size of the picture that the model was compiled with, in metres.
        coordinates: mesh -> (N, 2) texture coordinates that it was compiled with.
    """

    materials: tuple[int, ...]
    pictures: tuple[int, ...]
    tile_m: Vec2
    coordinates: Mapping[int, Any]


class SurfaceTextures:
    """The pictures on the surfaces of a compiled kitchen; made by `Kitchen.textures_of(model)`."""

    def __init__(self, model: mujoco.MjModel, covers: Mapping[str, Sequence[str]], cache: Path) -> None:
        """Finds them in a model that still has the pictures it was compiled with.

        Args:
            model: MjModel of the scene, which `show` changes in place.
            covers: surface -> finishes that cover it, as scene.json has them.
            cache: folder that keeps painted pictures.
        """
        self._model, self._cache = model, cache
        # A style also names what only other plans have, such as the finish of an island.
        found = {s: [_covering(model, finish) for finish in finishes] for s, finishes in covers.items()}
        self._coverings = {surface: [c for c in coverings if c.pictures] for surface, coverings in found.items()}
        self._changed: set[str] = set()

    def show(self, textures: Mapping[str, str]) -> None:
        """Replace the pictures of the named surfaces, at their true size. Other surfaces keep theirs.

        A renderer that already exists has to be updated with `upload`.

        Args:
            textures: texture by surface: wall, floor, counter, cabinet.
        Raises:
            UnknownId: no such surface or texture.
            CasaError: the model does not hold the scene's pictures (a light one).
        """
        for surface in textures:
            if surface not in list(Surface):
                raise UnknownId("surface", surface, [s.value for s in Surface])
        for surface, name in ordered_surfaces((Surface(s), t) for s, t in textures.items()):
            coverings = self._coverings.get(surface.value)
            if not coverings:
                raise CasaError(
                    f"the model shows no picture on any {surface.value}; load the kitchen with detail 'full'"
                )
            for covering in coverings:
                _show(self._model, covering, name, self._cache)
            self._changed.add(surface.value)

    def upload(self, renderer: mujoco.Renderer) -> None:
        """Upload the changes since the last call to a renderer: about ten times as fast as creating a new renderer."""
        # MuJoCo's Renderer has no public door to its context, in any version from 3.3 to 4.0.
        context = renderer._mjr_context
        if renderer._gl_context is not None:
            renderer._gl_context.make_current()
        coverings = [c for surface in sorted(self._changed) for c in self._coverings[surface]]
        for picture in sorted({p for c in coverings for p in c.pictures}):
            mujoco.mjr_uploadTexture(self._model, context, picture)
        for mesh in sorted({m for c in coverings for m in c.coordinates}):
            mujoco.mjr_uploadMesh(self._model, context, mesh)
        self._changed.clear()


def _covering(model: mujoco.MjModel, finish: str) -> _Covering:
    materials = [i for i in range(model.nmat) if model.material(i).name.endswith(f"__{finish}")]
    pictures = sorted({int(t) for i in materials for t in model.mat_texid[i] if t >= 0})
    shown = np.isin(model.geom_matid, materials) & (model.geom_dataid >= 0)
    coordinates = {}
    for mesh in np.unique(model.geom_dataid[shown]).tolist() if pictures else ():
        first, count = int(model.mesh_texcoordadr[mesh]), int(model.mesh_texcoordnum[mesh])
        if first >= 0:
            coordinates[mesh] = model.mesh_texcoord[first : first + count].copy()
    tile = find_recipe(finish).tile_m if pictures else (1.0, 1.0)
    return _Covering(tuple(materials), tuple(pictures), tile, coordinates)


def _show(model: mujoco.MjModel, covering: _Covering, name: str, cache: Path) -> None:
    for number in covering.pictures:
        width, height = int(model.tex_width[number]), int(model.tex_height[number])
        material, pixels = _picture(find_recipe(name), width, height, cache)
        start = int(model.tex_adr[number])
        model.tex_data[start : start + pixels.size] = pixels.ravel()
    assert material.tile_m is not None, "the finish of a texture has a size"
    # Texture coordinates are metres over the size of the picture.
    scale = np.array(covering.tile_m) / np.array(material.tile_m)
    for mesh, coordinates in covering.coordinates.items():
        first = int(model.mesh_texcoordadr[mesh])
        model.mesh_texcoord[first : first + len(coordinates)] = coordinates * scale
    for i in covering.materials:
        model.mat_rgba[i] = material.base_color
        model.mat_metallic[i], model.mat_roughness[i] = material.metallic, material.roughness


@lru_cache(maxsize=64)  # of 3 MB each
def _picture(recipe: TextureRecipe, width: int, height: int, cache: Path) -> tuple[Material, NDArray[np.uint8]]:
    """The material of a texture, and its picture as (height, width, 3)."""
    material = finish_of(recipe, cache).material
    assert material.base_color_texture is not None, "the finish of a texture has a picture"
    with Image.open(io.BytesIO(material.base_color_texture.png)) as picture:
        return material, np.asarray(picture.convert("RGB").resize((width, height)))
