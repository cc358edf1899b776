"""Compiled MuJoCo model -> what its visuals look like."""

from __future__ import annotations

from functools import cache
from pathlib import PurePosixPath

import mujoco
import numpy as np

from casa_assets.checks.package.facts import VisualFacts
from casa_assets.core.color import linear_from_srgb
from casa_assets.model.record import Vec3, Vec4

COLOR = int(mujoco.mjtTextureRole.mjTEXROLE_RGB)


def looks(model: mujoco.MjModel) -> tuple[VisualFacts, ...]:
    """Named geoms that have a material and touch nothing, sorted by name; what hangs on the world is left out."""
    found = []
    collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    surfaces = cache(lambda material: _surface(model, material))
    for geom in np.flatnonzero(~collides & (model.geom_matid >= 0) & (model.geom_bodyid != 0)).tolist():
        name = model.geom(geom).name
        if name:
            color, light, picture = surfaces(int(model.geom_matid[geom]))
            found.append(VisualFacts(name=name, color=color, light=light, picture=picture))
    return tuple(sorted(found, key=lambda look: look.name))


def _surface(model: mujoco.MjModel, material: int) -> tuple[Vec4, Vec3, str]:
    """Colour, light that it gives off and picture of a material, as `VisualFacts` has them."""
    color = linear(tuple(float(n) for n in model.mat_rgba[material]))
    glow = float(model.mat_emission[material])
    light = (glow * color[0], glow * color[1], glow * color[2])
    return color, light, _picture(model, int(model.mat_texid[material][COLOR]))


def linear(rgba: tuple[float, ...]) -> Vec4:
    """Display colour -> linear, alpha as it is."""
    red, green, blue, alpha = rgba
    dark = [linear_from_srgb(c) for c in (red, green, blue)]
    return dark[0], dark[1], dark[2], alpha


def _picture(model: mujoco.MjModel, texture: int) -> str:
    """File name of a texture, empty where there is none."""
    if texture < 0:
        return ""
    paths, start = bytes(model.paths), int(model.tex_pathadr[texture])
    return PurePosixPath(paths[start : paths.index(0, start)].decode()).name
