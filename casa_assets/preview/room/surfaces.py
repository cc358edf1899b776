"""What a camera sees, pixel by pixel: where it is, how it is turned, its colour, how it shines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from casa_assets.core.typing import Floats, Mask, Singles
from casa_assets.preview import renderer
from casa_assets.preview.exposure import CameraFrustum
from casa_assets.preview.room.surroundings import Surroundings

_DIRECTIONAL = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
_OPAQUE = 0.999  # alpha from which on nothing is seen through
_FAR_DEPTH = 0.99999  # of the depth buffer where nothing is seen
_SECTION = 0.43  # grey of walls where the picture cuts them, sRGB
_SECTION_M = 0.1  # how far from the edge of the room a cut may be
_PLAIN_WALL = (0.87, 0.86, 0.84)  # of the wall that closes an open side for an eye within, sRGB
_SIDES = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], dtype=np.float32)


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
        self._colors = plain_scene(canvas.new_scene(solid))
        _only_ambient(self._colors)
        self._normals = plain_scene(canvas.new_scene(solid), lambda _: (1.0, 1.0, 1.0))
        _lights_along_axes(self._normals)

        def gloss(material: int) -> tuple[float, float, float]:
            if material < 0:
                return 0.0, 0.5, 0.0
            rough, metallic = float(model.mat_roughness[material]), float(model.mat_metallic[material])
            return max(0.0, metallic), rough if rough >= 0.0 else 0.5, float(model.mat_emission[material])

        self._gloss = plain_scene(canvas.new_scene(solid), gloss)
        _only_ambient(self._gloss)
        self._veils = [_veil_scene(canvas.new_scene(every), is_white) for is_white in (False, True)]
        self._has_glass = any(_is_clear(geom) for geom in self._veils[0].geoms[: self._veils[0].ngeom])

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
        veil = image(self._veils[0]) if self._has_glass else np.zeros_like(albedo)
        return Surfaces(
            seen=depth < _FAR_DEPTH,
            places=np.asarray(eye.pos, dtype=np.float32) + rays * distance[..., None],
            normals=normals,
            to_eye=to_eye,
            albedo=albedo,
            gloss=image(self._gloss),
            veil=veil,
            clear=np.float32(1) - image(self._veils[1]) if self._has_glass else np.ones_like(albedo),
        )


def close_open_sides(seen: Surfaces, room: Surroundings, eye: Floats) -> None:
    """Where an eye in the room looks out through a side without a wall, let it see a plain wall there."""
    out = np.flatnonzero(~seen.seen)
    rays = -seen.to_eye.reshape(-1, 3)[out]
    at = np.asarray(eye, dtype=np.float32)
    way, side = room.way_out(np.tile(at[:, None], (1, len(out))), rays.T)
    places = at + rays * way[:, None]
    bare = room.is_bare(places.T, side)
    out, places, side = out[bare], places[bare], side[bare]
    seen.seen.reshape(-1)[out] = True
    for field, values in (
        (seen.places, places),
        (seen.normals, _SIDES[side]),
        (seen.albedo, _PLAIN_WALL),
        (seen.gloss, (0.0, 0.9, 0.0)),
    ):
        field.reshape(-1, 3)[out] = values


def grey_sections(seen: Surfaces, room: Surroundings) -> None:
    """Make walls grey where a picture without ceiling cuts them: their tops, and their ends at the open sides."""
    for axis, end in [(2, True), *sorted(room.open_sides)]:
        others = [a for a in (0, 1) if a != axis]
        beyond = (seen.places[..., others] < room.lower[others]) | (seen.places[..., others] > room.upper[others])
        sign, edge = (1, room.upper[axis]) if end else (-1, room.lower[axis])
        turned = sign * seen.normals[..., axis] > 0.9
        cut = beyond.any(axis=2) & turned & (sign * (seen.places[..., axis] - edge) > -_SECTION_M)
        seen.albedo[cut] = _SECTION
        seen.gloss[cut] = (0.0, 0.9, 0.0)


def plain_scene(scene: Any, paint: Callable[[int], tuple[float, float, float]] | None = None) -> Any:
    """Take lights, shadows, sky and highlights out of an MjvScene, and return it.

    Args:
        paint: RGB of a geom in place of its own colour and picture, from the number of its material (-1: none).
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
    """What is see-through before black, in its own colours, or white: then it shows its opacity."""
    for geom in scene.geoms[: scene.ngeom]:
        if not _is_clear(geom):
            geom.rgba, geom.matid = [0.0, 0.0, 0.0, 1.0], -1
        elif is_white:
            geom.rgba, geom.matid = [1.0, 1.0, 1.0, float(geom.rgba[3])], -1
    _only_ambient(plain_scene(scene))
    return scene


def _is_clear(geom: Any) -> bool:
    return float(geom.rgba[3]) < _OPAQUE


def _only_ambient(scene: Any) -> None:
    """Colours as they are."""
    scene.nlight = 1
    _set_light(scene.lights[0], np.array([0.0, 0.0, 1.0]), np.zeros(3), 1.0)


def _lights_along_axes(scene: Any) -> None:
    """Lights that add and take away along each axis: a white surface shows (1 + normal) / 2."""
    scene.nlight = 6
    for i, light in enumerate(scene.lights[:6]):
        axis, sign = i // 2, 1 - 2 * (i % 2)
        towards = np.zeros(3)
        towards[axis] = sign
        _set_light(light, towards, 0.5 * np.abs(towards) * sign, 0.5 if i == 0 else 0.0)


def _set_light(light: Any, towards: Floats, diffuse: Floats, ambient: float) -> None:
    light.type, light.headlight, light.texid, light.castshadow = _DIRECTIONAL, 0, -1, 0
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
