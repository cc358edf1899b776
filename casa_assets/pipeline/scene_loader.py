"""A scene on disk into MuJoCo, and other pictures on its surfaces without compiling its geometry again."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from PIL import Image

from casa_assets.errors import CasaError, UnknownId
from casa_assets.model.surface import Surface
from casa_assets.pipeline import library as disk
from casa_assets.pipeline.kitchens import Recipe, chosen
from casa_assets.pipeline.scenes import FACTS, LIGHT_FILE, SceneBuilt, build_all
from casa_assets.pipeline.textures import finish_of, recipe
from casa_assets.registry_kitchens import plan_names, style_names

FILES = {"full": "scene.xml", "light": LIGHT_FILE}


def load_scene(
    scene: str | Path,
    textures: Mapping[str, str] | None = None,
    weight: str = "full",
    out: Path | str = "out/scenes",
    as_spec: bool = False,
    sleep: bool = False,
) -> Any:
    """A kitchen as a MuJoCo model; it is built first where it is not there yet.

    Args:
        scene: id such as `l_small__coastal`, or the folder of a built scene.
        textures: pictures that differ from the scene's, by surface: wall, floor, counter, cabinet. Not for specs.
        weight: `full`, or `light`: primitive shapes in plain colours, for many simulations at once.
        out: folder of the scenes.
        as_spec: an MjSpec to add a robot and objects to, instead of a compiled MjModel.
        sleep: let MuJoCo leave out what is at rest until something moves it, which is some times as fast. Never in the
            files: MuJoCo 3.3 does not know it.
    Returns:
        mujoco.MjModel or mujoco.MjSpec. Keyframes: start, closed, open.
    Raises:
        UnknownId: no such scene, weight, surface or texture. CasaError: the scene cannot be built.
    """
    if weight not in FILES:
        raise UnknownId("weight", weight, FILES)
    folder = scene if isinstance(scene, Path) else _built(scene, Path(out))
    path = str(folder / FILES[weight])
    flags = int(mujoco.mjtEnableBit.mjENBL_SLEEP) if sleep else 0
    if as_spec:
        spec = mujoco.MjSpec.from_file(path)
        spec.option.enableflags |= flags
        return spec
    model = mujoco.MjModel.from_xml_path(path)
    model.opt.enableflags |= flags
    if textures:
        swap_textures(model, folder, textures, disk.Library(folder.parent).cache)
    return model


def _built(scene: str, out: Path) -> Path:
    folder = out / scene
    if (folder / FACTS).is_file():
        return folder
    plan, _, style = scene.partition("__")
    if plan not in plan_names() or style not in style_names():
        raise UnknownId("scene", scene, [f"{p}__{s}" for p in plan_names() for s in style_names()])
    made: list[SceneBuilt] = list(build_all([Recipe(plan, style)], out, 1, drawn=False))
    if not made[0].folder:
        raise CasaError(made[0].says)
    return folder


def swap_textures(model: Any, folder: Path, textures: Mapping[str, str], cache: Path) -> None:
    """Put other pictures on surfaces of a compiled model, at their true size; nothing is compiled again.

    A renderer that has drawn the model before has to be made anew, or told by `mjr_uploadTexture` and `mjr_uploadMesh`.

    Args:
        model: MjModel of the scene, changed in place. folder: of the scene. textures: texture by surface.
        cache: folder that keeps painted pictures.
    Raises:
        UnknownId: no such surface or texture. CasaError: the model does not hold the scene's pictures (a light one).
    """
    for surface in textures:
        if surface not in list(Surface):
            raise UnknownId("surface", surface, [s.value for s in Surface])
    covers = json.loads((folder / FACTS).read_text(encoding="utf-8"))["covers"]
    for surface, name in chosen((Surface(s), t) for s, t in textures.items()):
        # A style also names what only other plans have, such as the finish of an island.
        shown = [_swap(model, old, name, cache) for old in covers[surface.value]]
        if not any(shown):
            raise CasaError(f"the model shows no picture on any {surface.value}; load the scene with weight 'full'")


def _swap(model: Any, old: str, new: str, cache: Path) -> bool:
    """Whether the model shows the old picture, and so now shows the new one."""
    materials = [i for i in range(model.nmat) if model.material(i).name.endswith(f"__{old}")]
    pictured = {int(t) for i in materials for t in model.mat_texid[i] if t >= 0}
    if not pictured:
        return False
    finish = finish_of(recipe(new), cache)
    texture = finish.material.base_color_texture
    tile, before = finish.material.tile_m, recipe(old).tile_m
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
