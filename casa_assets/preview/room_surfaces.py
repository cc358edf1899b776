"""Surfaces that a camera sees, pixel by pixel: position, normal, colour and gloss; and shadow maps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from casa_assets.core.numeric import Floats, Mask, Singles
from casa_assets.preview import renderer
from casa_assets.preview.renderer import CameraFrustum

_OPAQUE = 0.999  # alpha from which on nothing is seen through
_FAR_DEPTH = 0.99999  # of the depth buffer where nothing is seen
_BEYOND_M, _NEAR_M = 0.5, 0.1  # between the eye of a map of shadows and what it sees, and where it begins to see
_STEPS = 65535  # of heights in a map


@dataclass(frozen=True)
class Surfaces:
    """Pixels of one drawing, rows from the top.

    Attributes:
        seen: (H, W) whether anything solid is seen there.
        places: (H, W, 3) metres, world frame. normals: (H, W, 3) unit vectors that face the eye.
        to_eye: (H, W, 3) unit vectors. albedo: (H, W, 3) sRGB, 0..1.
        gloss: (H, W, 3) metallic, roughness, emission, 0..1.
        veil: (H, W, 3) sRGB of what is see-through, times its opacity. clear: (H, W, 3) share of what lies behind it
            that is seen.
    """

    seen: Mask
    places: Singles
    normals: Singles
    to_eye: Singles
    albedo: Singles
    gloss: Singles
    veil: Singles
    clear: Singles


class SurfaceDrawer:
    """Draws surfaces of one model from one camera."""

    def __init__(self, canvas: renderer.Canvas, model: Any, solid: Any, every: Any) -> None:
        """Prepare scenes.

        Args:
            solid, every: MjvOption that shows what is opaque; that shows what is see-through, too.
        """
        self._canvas = canvas
        self._colors = _ambient_alone(plain_scene(canvas.new_scene(solid)))
        self._normals = plain_scene(canvas.new_scene(solid), lambda _: (1.0, 1.0, 1.0))
        _lights_along_axes(self._normals)

        def gloss(material: int) -> tuple[float, float, float]:
            if material < 0:
                return 0.0, 0.5, 0.0
            rough, metallic = float(model.mat_roughness[material]), float(model.mat_metallic[material])
            return max(0.0, metallic), rough if rough >= 0.0 else 0.5, float(model.mat_emission[material])

        self._gloss = _ambient_alone(plain_scene(canvas.new_scene(solid), gloss))
        self._veils = [_veil_scene(canvas.new_scene(every), is_white) for is_white in (False, True)]
        self._has_glass = any(geom.rgba[3] < _OPAQUE for geom in self._veils[0].geoms[: self._veils[0].ngeom])

    def draw(self, lens: CameraFrustum, number: int, width_px: int, height_px: int) -> Surfaces:
        """Surfaces as drawing `number` sees them, which is moved by a part of a pixel."""

        def image(scene: Any) -> Singles:
            lens.aim(scene, number)
            return self._canvas.draw_scene(scene, width_px, height_px).astype(np.float32) * np.float32(1 / 255)

        albedo = image(self._colors)
        depth = self._canvas.read_depth(width_px, height_px)[::-1]
        eye = self._colors.camera[0]
        rays = _rays(eye, width_px, height_px)
        near, far = float(eye.frustum_near), float(eye.frustum_far)
        distance = (near / (1.0 - depth * (1.0 - near / far))).astype(np.float32)
        to_eye = -rays / np.linalg.norm(rays, axis=2, keepdims=True)
        normals = image(self._normals) * np.float32(2.0) - np.float32(1.0)
        length = np.linalg.norm(normals, axis=2, keepdims=True)
        normals = np.where(length > 0.2, normals / np.maximum(length, 1e-3), to_eye)
        normals *= np.where(np.einsum("ijk,ijk->ij", normals, to_eye) < 0, np.float32(-1), np.float32(1))[..., None]
        return Surfaces(
            seen=depth < _FAR_DEPTH,
            places=np.asarray(eye.pos, dtype=np.float32) + rays * distance[..., None],
            normals=normals,
            to_eye=to_eye,
            albedo=albedo,
            gloss=image(self._gloss),
            veil=image(self._veils[0]) if self._has_glass else np.zeros_like(albedo),
            clear=np.float32(1) - image(self._veils[1]) if self._has_glass else np.ones_like(albedo),
        )


def plain_scene(scene: Any, paint: Callable[[int], tuple[float, float, float]] | None = None) -> Any:
    """Take lights, shadows, sky and highlights out of an MjvScene, and return it.

    Args:
        paint: RGB of a geom, used instead of its colour and picture, from the number of its material (-1: none).
    """
    flags = mujoco.mjtRndFlag
    for flag in (flags.mjRND_SHADOW, flags.mjRND_REFLECTION, flags.mjRND_SKYBOX, flags.mjRND_HAZE, flags.mjRND_FOG):
        scene.flags[flag] = 0
    scene.nlight = 0
    for geom in scene.geoms[: scene.ngeom]:
        geom.specular = geom.shininess = geom.reflectance = geom.emission = 0.0
        if paint is not None:
            geom.rgba, geom.matid = [*paint(int(geom.matid)), 1.0], -1
    return scene


def _veil_scene(scene: Any, is_white: bool) -> Any:
    """Paint opaque geoms black; see-through ones keep their colours or become white, to show their opacity."""
    for geom in scene.geoms[: scene.ngeom]:
        if geom.rgba[3] >= _OPAQUE:
            geom.rgba, geom.matid = [0.0, 0.0, 0.0, 1.0], -1
        elif is_white:
            geom.rgba, geom.matid = [1.0, 1.0, 1.0, float(geom.rgba[3])], -1
    return _ambient_alone(plain_scene(scene))


def _ambient_alone(scene: Any) -> Any:
    """Colours as they are."""
    scene.nlight = 1
    _set_light(scene.lights[0], np.array([0.0, 0.0, 1.0]), np.zeros(3), 1.0)
    return scene


def _lights_along_axes(scene: Any) -> None:
    """Lights that add and take away along each axis: a white surface shows (1 + normal) / 2."""
    scene.nlight = 6
    for i, light in enumerate(scene.lights[:6]):
        axis, sign = i // 2, 1 - 2 * (i % 2)
        towards = np.zeros(3)
        towards[axis] = sign
        _set_light(light, towards, 0.5 * np.abs(towards) * sign, 0.5 if i == 0 else 0.0)


def _set_light(light: Any, towards: Floats, diffuse: Floats, ambient: float) -> None:
    light.type, light.headlight, light.texid, light.castshadow = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, 0, -1, 0
    light.dir, light.pos = -towards, 10.0 * towards
    light.ambient, light.diffuse, light.specular = [ambient] * 3, diffuse, [0.0] * 3
    light.attenuation, light.cutoff, light.exponent = [1.0, 0.0, 0.0], 180.0, 0.0


def _rays(eye: Any, width_px: int, height_px: int) -> Singles:
    """(H, W, 3) vectors from an MjvGLCamera through the pixels, one metre deep."""
    ahead, up = np.array(eye.forward), np.array(eye.up)
    right = np.cross(ahead, up)
    near, half = float(eye.frustum_near), float(eye.frustum_width)
    columns = float(eye.frustum_center) + ((np.arange(width_px) + 0.5) * (2.0 / width_px) - 1.0) * half
    bottom, top = float(eye.frustum_bottom), float(eye.frustum_top)
    rows = top - (np.arange(height_px) + 0.5) * ((top - bottom) / height_px)
    rays = ahead + (columns / near)[None, :, None] * right + (rows / near)[:, None, None] * up
    return np.asarray(rays, dtype=np.float32)


@dataclass(frozen=True)
class ShadowMap:
    """Height of objects towards a light that is far away.

    Attributes:
        frame: (3, 3) unit vectors right, up and towards the light, one in each row, world frame.
        corner: (2,) least coordinates along right and up, metres. pixel: width of a pixel, metres.
        heights: (S, S) greatest coordinate towards the light in each pixel; rows go up.
        least, step: coordinate that a height of 0 means, and size of one step, metres.
    """

    frame: Singles
    corner: Singles
    pixel: float
    heights: npt.NDArray[np.uint16]
    least: float
    step: float

    def above(self, x: Singles, y: Singles) -> Singles:
        """Heights at (N,) coordinates along right and up, metres; the nearest pixel's."""
        most, scale = len(self.heights) - 1, np.float32(1.0 / self.pixel)
        column, row = (((at - least) * scale).astype(np.int32) for at, least in zip((x, y), self.corner, strict=True))
        flat = np.clip(row, 0, most) * len(self.heights) + np.clip(column, 0, most)
        found: Singles = self.heights.ravel()[flat].astype(np.float32)
        found *= np.float32(self.step)
        found += np.float32(self.least)
        return np.asarray(found)


def draw_shadow_map(canvas: renderer.Canvas, scene: Any, towards: Floats, corners: Floats, size_px: int) -> ShadowMap:
    """Draw the map of a direction.

    Args:
        scene: MjvScene of what throws shadows, without lights.
        towards: (3,) unit vector to the light, world frame.
        corners: (8, 3) of the box round all that throws shadows, metres.
        size_px: side of the map.
    """
    side = np.cross((0.0, 0.0, 1.0), towards) if abs(towards[2]) < 0.99 else np.array([1.0, 0.0, 0.0])
    right = side / np.linalg.norm(side)
    frame = np.stack([right, np.cross(towards, right), towards])
    local = corners @ frame.T
    least, most = local.min(axis=0), local.max(axis=0)
    # A pixel of margin all round, so that what lies beyond the map meets nothing at its edge.
    half = float((most - least)[:2].max()) / 2.0 * (1.0 + 4.0 / size_px)
    middle = (least + most) / 2.0
    top, deep = float(most[2]) + _BEYOND_M, float(most[2] - least[2]) + 2.0 * _BEYOND_M
    for eye in scene.camera:
        eye.pos, eye.forward, eye.up = np.array([middle[0], middle[1], top]) @ frame, -towards, frame[1]
        eye.orthographic, eye.frustum_near, eye.frustum_far = 1, _NEAR_M, deep
        eye.frustum_center, eye.frustum_width = 0.0, half
        eye.frustum_bottom, eye.frustum_top = -half, half
    depth = canvas.draw_depth(scene, size_px, size_px)
    return ShadowMap(
        frame=frame.astype(np.float32),
        corner=(middle[:2] - half).astype(np.float32),
        pixel=2.0 * half / size_px,
        # Two bytes are enough, and all maps of a scene are kept for its other cameras.
        heights=np.rint((np.float32(1.0) - depth) * np.float32(_STEPS)).astype(np.uint16),
        least=top - deep,
        step=(deep - _NEAR_M) / _STEPS,
    )
