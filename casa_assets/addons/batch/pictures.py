"""Materials of batch forms and their pictures: each kitchen gets those of all, and differs in numbers alone."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from casa_assets.core.numeric import Floats, linear_from_srgb_array, srgb_from_linear

_COLOR = int(mujoco.mjtTextureRole.mjTEXROLE_RGB)


class Picture(NamedTuple):
    """A picture of a compiled model.

    Attributes:
        name: the same in two kitchens where the picture is. pixels: (height, width, channels).
    """

    name: str
    pixels: NDArray[np.uint8]


class PaintedMaterial(NamedTuple):
    """A material of a compiled model.

    Attributes:
        values: of an MjsMaterial, including its name: equal in two kitchens if the material is the same.
        picture: its texture, or None if it is plain.
    """

    values: Mapping[str, Any]
    picture: Picture | None


def materials_of(model: mujoco.MjModel) -> dict[str, PaintedMaterial]:
    """Materials of a model by their names."""
    found = {}
    for number in range(model.nmat):
        name, texture = str(model.material(number).name), int(model.mat_texid[number, _COLOR])
        values = {
            "name": name,
            "rgba": model.mat_rgba[number],
            "texrepeat": model.mat_texrepeat[number],
            "texuniform": bool(model.mat_texuniform[number]),
            **{
                field: float(getattr(model, f"mat_{field}")[number])
                for field in ("emission", "specular", "shininess", "metallic", "roughness")
            },
        }
        picture = None if texture < 0 else Picture(str(model.tex(texture).name), _pixels(model, texture))
        found[name] = PaintedMaterial(values, picture)
    return found


def add_materials(spec: mujoco.MjSpec, materials: Iterable[PaintedMaterial]) -> None:
    """Add materials and their pictures to a spec that has none of them."""
    known: set[str] = set()
    for material in materials:
        added = spec.add_material(**material.values)
        if material.picture is None:
            continue
        name, pixels = material.picture
        added.textures[_COLOR] = name
        if name not in known:
            height, width, channels = pixels.shape
            texture = spec.add_texture(
                name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, width=width, height=height, nchannel=channels
            )
            texture.data = pixels.tobytes()
            known.add(name)


def plain_colors(model: mujoco.MjModel) -> Floats:
    """(ngeom, 4) colours of geoms as they look from far: those with a picture have its mean, as linear light."""
    colors = np.array(model.geom_rgba, dtype=np.float64)
    for number, material in enumerate(materials_of(model).values()):
        color = np.array(material.values["rgba"], dtype=np.float64)
        if material.picture is not None:
            pixels = material.picture.pixels.reshape(-1, material.picture.pixels.shape[2])[:, :3] / 255
            color[:3] *= [srgb_from_linear(float(value)) for value in linear_from_srgb_array(pixels).mean(axis=0)]
        colors[model.geom_matid == number] = color
    return colors


def _pixels(model: mujoco.MjModel, texture: int) -> NDArray[np.uint8]:
    shape = (int(model.tex_height[texture]), int(model.tex_width[texture]), int(model.tex_nchannel[texture]))
    first = int(model.tex_adr[texture])
    return np.array(model.tex_data[first : first + int(np.prod(shape))]).reshape(shape)
