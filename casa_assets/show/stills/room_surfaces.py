"""Surfaces that a camera sees, pixel by pixel: position, normal, colour and gloss; and shadow maps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from casa_assets.core.numeric import Floats, Mask, Singles
from casa_assets.show.stills import renderer
from casa_assets.show.stills.renderer import CameraFrustum

OPAQUE = 0.999  # alpha from which on nothing is seen through
_FAR_DEPTH = 0.99999  # of the depth buffer where nothing is seen
_BEYOND_M, _NEAR_M = 0.5, 0.1  # between the eye of a map of shadows and what it sees, and where it begins to see
_STEPS = 65535  # of heights in a map
Paint = Callable[[int], tuple[float, float, float]]
_Light = tuple[Floats, Floats, float]  # (3,) unit vector to it, (3,) diffuse light, ambient light
# The first shows colours as they are. With the others, which add and take away along each axis, a white surface shows
# (1 + normal) / 2.
_EVEN = [(np.array([0.0, 0.0, 1.0]), np.zeros(3), 1.0)]
_ALONG_AXES = [
    (sign * axis, 0.5 * sign * axis, 0.5 if axis[0] * sign > 0 else 0.0) for axis in np.eye(3) for sign in (1.0, -1.0)
]


@dataclass(frozen=True)
class Surfaces:
    """Pixels of one drawing, (H, W) or (H, W, 3), rows from the top.

    Attributes:
        seen: whether anything solid is seen there. places: metres, world frame. normals, to_eye: unit vectors; normals
            face the eye. albedo: sRGB, 0..1. gloss: metallic, roughness, emission, 0..1.
        veil: sRGB of what is see-through, times its opacity. clear: share of what lies behind it that is seen.
    """

    seen: Mask
    places: Singles
    normals: Singles
    to_eye: Singles
    albedo: Singles
    gloss: Singles
    veil: Singles
    clear: Singles


def draw_surfaces(
    canvas: renderer.Canvas, solid: Any, every: Any, lens: CameraFrustum, count: int, size_px: tuple[int, int]
) -> Iterator[Surfaces]:
    """Yield what `count` drawings of a model from one camera show, each moved by a part of a pixel.

    Of two MjvOptions `solid` shows what is opaque, `every` what is see-through, too.
    """
    model = canvas.model

    def gloss(material: int) -> tuple[float, float, float]:
        if material < 0:
            return 0.0, 0.5, 0.0
        rough, metallic = float(model.mat_roughness[material]), float(model.mat_metallic[material])
        return max(0.0, metallic), rough if rough >= 0.0 else 0.5, float(model.mat_emission[material])

    def image(scene: Any, number: int) -> Singles:
        lens.aim(scene, number)
        return canvas.draw_scene(scene, *size_px).astype(np.float32) * np.float32(1 / 255)

    color_scene = plain_scene(canvas.new_scene(solid), _EVEN)
    normal_scene = plain_scene(canvas.new_scene(solid), _ALONG_AXES, lambda _: (1.0, 1.0, 1.0))
    gloss_scene = plain_scene(canvas.new_scene(solid), _EVEN, gloss)
    # See-through geoms in their colours, and in white, which shows their opacity; opaque ones are black.
    veils = [canvas.new_scene(every) for _ in range(2)]
    for is_white, scene in enumerate(veils):
        for geom in scene.geoms[: scene.ngeom]:
            if geom.rgba[3] >= OPAQUE:
                geom.rgba, geom.matid = [0.0, 0.0, 0.0, 1.0], -1
            elif is_white:
                geom.rgba, geom.matid = [1.0, 1.0, 1.0, float(geom.rgba[3])], -1
        plain_scene(scene, _EVEN)
    has_glass = any(geom.rgba[3] < OPAQUE for geom in veils[0].geoms[: veils[0].ngeom])
    for number in range(count):
        albedo = image(color_scene, number)
        depth = canvas.read_depth(*size_px)[::-1]
        eye, rays = color_scene.camera[0], _rays(color_scene.camera[0], *size_px)
        near, far = float(eye.frustum_near), float(eye.frustum_far)
        distance = (near / (1.0 - depth * (1.0 - near / far))).astype(np.float32)
        to_eye = -rays / np.linalg.norm(rays, axis=2, keepdims=True)
        normals = image(normal_scene, number) * np.float32(2.0) - np.float32(1.0)
        length = np.linalg.norm(normals, axis=2, keepdims=True)
        normals = np.where(length > 0.2, normals / np.maximum(length, 1e-3), to_eye)
        normals *= np.where(np.einsum("ijk,ijk->ij", normals, to_eye) < 0, np.float32(-1), np.float32(1))[..., None]
        yield Surfaces(
            seen=depth < _FAR_DEPTH,
            places=np.asarray(eye.pos, dtype=np.float32) + rays * distance[..., None],
            normals=normals,
            to_eye=to_eye,
            albedo=albedo,
            gloss=image(gloss_scene, number),
            veil=image(veils[0], number) if has_glass else np.zeros_like(albedo),
            clear=np.float32(1) - image(veils[1], number) if has_glass else np.ones_like(albedo),
        )


def _rays(eye: Any, width_px: int, height_px: int) -> Singles:
    """(H, W, 3) vectors from an MjvGLCamera through the pixels, one metre deep."""
    ahead, up, near = np.array(eye.forward), np.array(eye.up), float(eye.frustum_near)
    across = ((np.arange(width_px) + 0.5) * (2.0 / width_px) - 1.0) * float(eye.frustum_width)
    columns = float(eye.frustum_center) + across
    bottom, top = float(eye.frustum_bottom), float(eye.frustum_top)
    rows = top - (np.arange(height_px) + 0.5) * ((top - bottom) / height_px)
    rays = ahead + (columns / near)[None, :, None] * np.cross(ahead, up) + (rows / near)[:, None, None] * up
    return np.asarray(rays, dtype=np.float32)


def plain_scene(scene: Any, lights: Sequence[_Light] = (), paint: Paint | None = None) -> Any:
    """Leave an MjvScene without shadows, sky, highlights and other lights than these, and return it.

    `paint` gives the RGB of a geom, instead of its colour and picture, from the number of its material (-1: none).
    """
    flags = mujoco.mjtRndFlag
    for flag in (flags.mjRND_SHADOW, flags.mjRND_REFLECTION, flags.mjRND_SKYBOX, flags.mjRND_HAZE, flags.mjRND_FOG):
        scene.flags[flag] = 0
    for geom in scene.geoms[: scene.ngeom]:
        geom.specular = geom.shininess = geom.reflectance = geom.emission = 0.0
        if paint is not None:
            geom.rgba, geom.matid = [*paint(int(geom.matid)), 1.0], -1
    scene.nlight = len(lights)
    for light, (towards, diffuse, ambient) in zip(scene.lights, lights, strict=False):
        light.type, light.headlight, light.texid, light.castshadow = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, 0, -1, 0
        light.dir, light.pos = -towards, 10.0 * towards
        light.ambient, light.diffuse, light.specular = [ambient] * 3, diffuse, [0.0] * 3
        light.attenuation, light.cutoff, light.exponent = [1.0, 0.0, 0.0], 180.0, 0.0
    return scene


@dataclass(frozen=True)
class ShadowMap:
    """Height of objects towards a light that is far away; metres.

    Attributes:
        frame: (3, 3) rows right, up and towards the light, world frame. corner: (2,) least coordinates along right, up.
        heights: (S, S) greatest coordinate towards the light in each pixel, in steps above `least`; rows go up.
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
        steps: Singles = self.heights.ravel()[flat].astype(np.float32)
        return steps * np.float32(self.step) + np.float32(self.least)


def draw_shadow_map(canvas: renderer.Canvas, scene: Any, towards: Floats, corners: Floats, size_px: int) -> ShadowMap:
    """Draw the map of a direction, `towards` the light (3,), of an MjvScene without lights.

    `corners` (8, 3) are those of the box round all that throws shadows, metres, world frame.
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
