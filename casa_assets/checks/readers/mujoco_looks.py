"""Compiled MuJoCo model -> what its visuals look like."""

from __future__ import annotations

from pathlib import PurePosixPath

import mujoco

from casa_assets.checks.package.facts import VisualFacts
from casa_assets.core.color import linear_from_srgb
from casa_assets.model.record import Vec4

COLOR = int(mujoco.mjtTextureRole.mjTEXROLE_RGB)


def looks(model: mujoco.MjModel) -> tuple[VisualFacts, ...]:
    """Named geoms that have a material and touch nothing, sorted by name; what hangs on the world is left out."""
    found = []
    for geom in range(model.ngeom):
        name, material = model.geom(geom).name, int(model.geom_matid[geom])
        collides = model.geom_contype[geom] or model.geom_conaffinity[geom]
        if material < 0 or collides or not name or not model.geom_bodyid[geom]:
            continue
        color = linear(tuple(float(n) for n in model.mat_rgba[material]))
        glow = float(model.mat_emission[material])
        found.append(
            VisualFacts(
                name=name,
                color=color,
                light=(glow * color[0], glow * color[1], glow * color[2]),
                picture=_picture(model, int(model.mat_texid[material][COLOR])),
            )
        )
    return tuple(sorted(found, key=lambda look: look.name))


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
