"""Files of a scene, on disk or in memory, into MuJoCo; other pictures on its surfaces without compiling it again."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from PIL import Image

from casa_assets.errors import CasaError, UnknownId
from casa_assets.export.mjcf.scene.kitchen import FILE
from casa_assets.model.files import Files
from casa_assets.model.kitchen.surface import Surface
from casa_assets.pipeline.kitchens.resolve import ordered_surfaces
from casa_assets.pipeline.kitchens.scene_files import LIGHT_FILE
from casa_assets.pipeline.textures.recipes import find_recipe, finish_of

FILES = {"full": FILE, "light": LIGHT_FILE}


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
    model.opt.enableflags |= _flags(sleep)
    return model


def spec_of(source: Path | Files, sleep: bool = False) -> mujoco.MjSpec:
    """An MjSpec of the scene that is not compiled yet, to add a robot and objects to."""
    if isinstance(source, Path):
        spec = mujoco.MjSpec.from_file(str(source))
    else:
        text, rest = _in_memory(source)
        spec = mujoco.MjSpec.from_string(text, assets=rest)
    spec.option.enableflags |= _flags(sleep)
    return spec


def _in_memory(files: Files) -> tuple[str, dict[str, bytes]]:
    return files.entries[FILE].decode(), {path: data for path, data in files.entries.items() if path != FILE}


def _flags(sleep: bool) -> int:
    return int(mujoco.mjtEnableBit.mjENBL_SLEEP) if sleep else 0


def swap_textures(model: Any, covers: Mapping[str, Sequence[str]], textures: Mapping[str, str], cache: Path) -> None:
    """Put other pictures on surfaces of a compiled model, at their true size; nothing is compiled again.

    A renderer that has drawn the model before has to be made anew, or told by `mjr_uploadTexture` and `mjr_uploadMesh`.

    Args:
        model: MjModel of the scene, changed in place. textures: texture by surface.
        covers: finishes that cover each surface, as scene.json has them.
        cache: folder that keeps painted pictures.
    Raises:
        UnknownId: no such surface or texture. CasaError: the model does not hold the scene's pictures (a light one).
    """
    for surface in textures:
        if surface not in list(Surface):
            raise UnknownId("surface", surface, [s.value for s in Surface])
    for surface, name in ordered_surfaces((Surface(s), t) for s, t in textures.items()):
        # A style also names what only other plans have, such as the finish of an island.
        shown = [_swap(model, old, name, cache) for old in covers.get(surface.value, ())]
        if not any(shown):
            raise CasaError(f"the model shows no picture on any {surface.value}; load the scene with weight 'full'")


def _swap(model: Any, old: str, new: str, cache: Path) -> bool:
    """True if the model shows the old picture, and so now shows the new one."""
    materials = [i for i in range(model.nmat) if model.material(i).name.endswith(f"__{old}")]
    pictured = {int(t) for i in materials for t in model.mat_texid[i] if t >= 0}
    if not pictured:
        return False
    finish = finish_of(find_recipe(new), cache)
    texture = finish.material.base_color_texture
    tile, before = finish.material.tile_m, find_recipe(old).tile_m
    assert texture is not None
    assert tile is not None
    for number in pictured:
        size = (int(model.tex_width[number]), int(model.tex_height[number]))
        picture = Image.open(io.BytesIO(texture.png)).convert("RGB").resize(size)
        start = int(model.tex_adr[number])
        model.tex_data[start : start + 3 * size[0] * size[1]] = np.asarray(picture).ravel()
    # Texture coordinates are metres over the size of the picture.
    scale = np.array([before[0] / tile[0], before[1] / tile[1]])
    for mesh in sorted({int(model.geom_dataid[g]) for g in range(model.ngeom) if model.geom_matid[g] in materials}):
        first, count = int(model.mesh_texcoordadr[mesh]), int(model.mesh_texcoordnum[mesh])
        if mesh >= 0 and first >= 0:
            model.mesh_texcoord[first : first + count] *= scale
    for i in materials:
        model.mat_rgba[i] = finish.material.base_color
        model.mat_metallic[i], model.mat_roughness[i] = finish.material.metallic, finish.material.roughness
    return True
