"""Render one asset's `model.xml` to a still picture."""

from __future__ import annotations

import colorsys
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.errors import CasaError
from casa_assets.preview import studio, tonemap
from casa_assets.preview.camera import View, fit

# Groups of the geoms that are seen and of those that collide: the first number in model.xml, the second in what MuJoCo
# reads from USD.
_VISUAL_GROUPS, _COLLISION_GROUPS = (1, 2), (0, 3)
_DEFAULT_VIEW = View()
# A picture of colliders shows them over the thing in this grey, with this share of their own colour.
_GREY_RGBA = (0.86, 0.87, 0.88, 1.0)
_COLLIDER_OPACITY = 0.68
_MIN_OVERLAY_PASSES = 8
# Hues of colliders: the golden ratio as a share of the circle keeps any number of them apart.
_FIRST_HUE, _HUE_STEP = 0.58, 0.61803398875


class CannotDraw(CasaError):
    """A model cannot be drawn; the message says why."""


def render(model_xml: Path, view: View = _DEFAULT_VIEW, collision: bool = False, pose: str = "") -> bytes:
    """PNG of one asset as it stands, seen from the front and a little from its right and above.

    Args:
        model_xml: MJCF with visual geoms in group 1 and collision geoms in group 0, or USD with 2 and 3; regions are
            called `reg_*`.
        view: direction and size.
        collision: show each collider in a colour of its own, see-through, over the thing in grey.
        pose: keyframe of the model that it stands in; empty: joints at zero.
    Raises:
        CannotDraw: MuJoCo cannot read the model, it has no such keyframe, or nothing in it is visible.
        NoRenderer: there is no OpenGL.
    """
    if collision:
        return _render_colliders(model_xml, view, pose)
    model, data, points = load_into_studio(model_xml, view.size_px, pose=pose)
    return tonemap.png(studio.render(model, data, points, fit(points, view), view))


def _render_colliders(model_xml: Path, view: View, pose: str) -> bytes:
    """PNG of the colliders over the grey thing.

    Two pictures are mixed: in one scene with see-through colliders, surfaces that coincide would flicker.
    """
    thing, thing_data, thing_points = load_into_studio(model_xml, view.size_px, _GREY_RGBA, pose=pose)
    shapes, shape_data, shape_points = load_into_studio(model_xml, view.size_px, None, _COLLISION_GROUPS, pose)
    camera = fit(np.concatenate([thing_points, shape_points]), view)
    # Half the drawings for each of the two.
    fewer = replace(view, passes=max(_MIN_OVERLAY_PASSES, view.passes // 2))
    below = studio.render(thing, thing_data, thing_points, camera, fewer).astype(np.float64)
    above = studio.render(shapes, shape_data, shape_points, camera, fewer).astype(np.float64)
    return tonemap.png(np.rint(below + _COLLIDER_OPACITY * (above - below)).astype(np.uint8))


def load_into_studio(
    model_xml: Path,
    size_px: int,
    paint: tuple[float, ...] | None = None,
    groups: tuple[int, ...] = _VISUAL_GROUPS,
    pose: str = "",
) -> tuple[Any, Any, Floats]:
    """Compile an asset in the studio: (MjModel, MjData, (N, 3) visible points in metres).

    Args:
        model_xml: as for `render`.
        size_px: of the picture to be taken.
        paint: RGBA for everything, instead of its materials.
        groups: of the geoms to be shown; colliders get colours of their own.
        pose: keyframe, or empty.
    Raises:
        CannotDraw: MuJoCo cannot read the model, or it has no geom to show.
    """
    try:
        spec = mujoco.MjSpec.from_file(str(model_xml))
        _keep_groups(spec, groups, paint)
        add_highlights(spec)
        studio.add_studio(spec, size_px)
        model = spec.compile()
    except ValueError as error:
        raise CannotDraw(f"{model_xml.name}: {error}".replace("\n", " ")) from error
    data = mujoco.MjData(model)
    if pose:
        set_keyframe(model, data, pose, model_xml.name)
    mujoco.mj_forward(model, data)
    return model, data, studio.place_floor(model, data)


def set_keyframe(model: Any, data: Any, pose: str, name: str) -> None:
    """Set the data to a keyframe. Raises CannotDraw where the model, here called `name`, has none such."""
    key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, pose)
    if key < 0:
        known = ", ".join(model.key(i).name for i in range(model.nkey)) or "none"
        raise CannotDraw(f"{name}: it has no keyframe {pose!r}; there are {known}")
    mujoco.mj_resetDataKeyframe(model, data, key)


def poses(model_xml: Path) -> tuple[str, ...]:
    """Names of the keyframes of a model, in its order."""
    return tuple(key.name for key in mujoco.MjSpec.from_file(str(model_xml)).keys)


def add_highlights(spec: Any) -> None:
    """Set specular and shininess of an MjSpec's materials from metallic and roughness."""
    for material in spec.materials:
        color = list(material.rgba)
        phong = _phong_terms(material.metallic, material.roughness, color, material.textures)
        material.specular, material.shininess, factor = phong
        material.reflectance = 0.0
        material.rgba = [*(factor * c for c in color[:3]), color[3]]


def _phong_terms(metallic: float, roughness: float, rgba: Any, textures: Any) -> tuple[float, float, float]:
    """(specular, shininess, factor of the colour) that make MuJoCo's lights show a material's metallic and roughness.

    Args:
        metallic, roughness: a negative value means that the file says nothing.
        textures: one item for each role, true where a picture fills it.
    """
    metallic = max(0.0, metallic)
    smooth = 1.0 - (roughness if roughness >= 0.0 else 0.5)
    # Metal mirrors in its own colour: a black one shines less than chrome.
    bright = max(rgba[:3]) if not any(textures) else 1.0
    specular = (1.0 - metallic) * (0.08 + 0.2 * smooth) + metallic * 0.9 * bright
    return specular, 0.05 + 0.45 * smooth**2, 1.0 - metallic * (0.14 + 0.42 * smooth)


def _keep_groups(spec: Any, groups: tuple[int, ...], paint: tuple[float, ...] | None) -> None:
    """Delete all geoms of other groups and all regions (`reg_*`), then the meshes that no geom uses.

    Colliders get colours of their own, and everything gets `paint` where it is given. What stays goes into the group
    that the studio draws. Raises ValueError where nothing stays.
    """
    for geom in list(spec.geoms):
        if geom.group not in groups or geom.name.startswith("reg_"):
            spec.delete(geom)
    if not list(spec.geoms):
        raise ValueError(f"it has no geom in group {' or '.join(map(str, groups))} to be drawn")
    for i, geom in enumerate(spec.geoms):
        if groups == _COLLISION_GROUPS or paint is not None:
            geom.material, geom.rgba = "", list(paint or (*_color(i), 1.0))
        geom.group = studio.VISUAL_GROUP
    used = {geom.meshname for geom in spec.geoms}
    for mesh in list(spec.meshes):
        if mesh.name not in used:
            spec.delete(mesh)


def _color(i: int) -> tuple[float, float, float]:
    """The i-th of colours that differ well from their neighbours."""
    hue, saturation, brightness = (_FIRST_HUE + i * _HUE_STEP) % 1.0, (0.75, 0.55)[i % 2], (0.95, 0.85)[i // 2 % 2]
    return colorsys.hsv_to_rgb(hue, saturation, brightness)
