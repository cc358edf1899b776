"""Light on the surfaces of a room, from many directions, each with its own shadows.

The room is a glowing box: ceiling, walls, open sides and floor reflect light, windows let it in. A direction brings the
light that the room shows there, unless something is between. Near objects block all of it; far ones give some light
themselves instead, as objects in a room do. Brightness is linear, as a fraction of what makes white look white.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from casa_assets.core.numeric import Floats, Ints, Mask, Singles, linear_from_srgb_array, srgb_from_linear_array
from casa_assets.show.stills.renderer import GOLDEN, PLASTIC, CameraFrustum, Canvas

OPAQUE = 0.999  # alpha from which on nothing is seen through
_FAR_DEPTH = 0.99999  # of the depth buffer where nothing is seen
_BEYOND_M, _MAP_NEAR_M = 0.5, 0.1  # between the eye of a map of shadows and what it sees, and where it begins to see
_STEPS = 65535  # of heights in a map
Paint = Callable[[int], tuple[float, float, float]]
_Light = tuple[Floats, Floats, float]  # (3,) unit vector to it, (3,) diffuse light, ambient light
# The first shows colours as they are. With the others, which add and take away along each axis, a white surface shows
# (1 + normal) / 2.
_EVEN = [(np.array([0.0, 0.0, 1.0]), np.zeros(3), 1.0)]
_ALONG_AXES = [
    (sign * axis, 0.5 * sign * axis, 0.5 if axis[0] * sign > 0 else 0.0) for axis in np.eye(3) for sign in (1.0, -1.0)
]
# Linear RGB of each side of the box. Chosen by eye, as is all light here: warm below, cool through what is open; the
# ceiling lights worktops, walls and open sides light fronts, and the floor keeps undersides from going black.
CEILING, WALL, OPEN_SIDE, FLOOR = (1.30, 1.27, 1.21), (0.58, 0.565, 0.54), (0.84, 0.85, 0.87), (0.40, 0.37, 0.335)
_WINDOW = np.array([1.9, 2.05, 2.25], dtype=np.float32)  # on top of the wall
_BLUR, _MIRROR_BLUR = 0.3, 0.8  # of the edges between the sides; sharp ones would draw stripes on walls, and on metal
_WINDOW_BLUR_M = np.float32(0.35)  # how softly a window begins, for the same reason
# The key light: from the open side, above, a little from the left, as of a large window behind the viewer.
_KEY = np.array([-0.42, -0.72, 0.55]) / np.linalg.norm([-0.42, -0.72, 0.55])
_KEY_COLOR = np.array([1.18, 1.15, 1.10], dtype=np.float32)
_KEY_SOFTNESS = 0.09  # half the width of its soft box, rad
_TILT = 0.2  # by which each pixel turns a direction, so that shadows have no steps, rad
_NEAR_M, _FAR_M = 0.03, 1.4  # what hides a place at this distance is black; from the other on it gives most light
_SECOND_HAND = np.array([0.36, 0.345, 0.325], dtype=np.float32)  # light of things between, far away
_FIRST_HAND = np.array([0.02, 0.019, 0.018], dtype=np.float32)
_ON_CEILING, _ON_OPEN_SIDE = np.float32(0.4), np.float32(0.45)  # which shine by themselves
_GUESS_M = 0.2  # how far off a shadow is looked for where none is
_OFF_SURFACE_M = 0.008  # by which places are moved off their surface, so that it does not shade itself
_EXPOSURE = 0.78
_SHOULDER, _ABOVE = 0.6, 0.42  # where the tone curve begins to bend, and how much brighter it gets
_MATT, _GLOW = 0.95, 1.3  # what a surface throws back of its colour, and of what shines by itself
_FREE_LIGHT = 0.8  # on a place with nothing near it; with less, its reflections are dimmer
_LEAST_REFLECTED = 0.04  # of light that comes straight on. Ref: Schlick 1994.
_VEIL, _PAPER = 0.9, 0.955  # light on glass, and sRGB of what lies beyond a room that is seen from outside
_HORIZON, _ZENITH = np.array([0.925, 0.945, 0.96]), np.array([0.70, 0.82, 0.93])  # of the sky that is seen from within
_SECTION, _PLAIN_WALL = 0.43, (0.87, 0.86, 0.84)  # sRGB of walls that the picture cuts, and that close an open side
_SIDES = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], dtype=np.float32)


@dataclass(frozen=True)
class Surfaces:
    """Pixels of one drawing, (H, W) or (H, W, 3), rows from the top.

    Attributes:
        seen: of something solid. places: metres, world frame. normals, to_eye: unit vectors; normals face the eye.
        albedo: sRGB, 0..1. gloss: metallic, roughness, emission, 0..1.
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
    canvas: Canvas, solid: Any, every: Any, lens: CameraFrustum, count: int, size_px: tuple[int, int]
) -> Iterator[Surfaces]:
    """Yield `count` drawings from a camera; of two MjvOptions `solid` shows what is opaque, `every` all."""
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
    """An MjvScene left without shadows, sky, highlights and other lights; `paint`: RGB by material (-1: none)."""
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


def draw_shadow_map(canvas: Canvas, scene: Any, towards: Floats, corners: Floats, size_px: int) -> ShadowMap:
    """The map of a direction, `towards` the light (3,); (8, 3) `corners` of the box round all that throws shadows."""
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
        eye.orthographic, eye.frustum_near, eye.frustum_far = 1, _MAP_NEAR_M, deep
        eye.frustum_center, eye.frustum_width = 0.0, half
        eye.frustum_bottom, eye.frustum_top = -half, half
    canvas.draw_scene(scene, size_px, size_px)
    depth = canvas.read_depth(size_px, size_px)
    return ShadowMap(
        frame=frame.astype(np.float32),
        corner=(middle[:2] - half).astype(np.float32),
        pixel=2.0 * half / size_px,
        # Two bytes are enough, and all maps of a scene are kept for its other cameras.
        heights=np.rint((np.float32(1.0) - depth) * np.float32(_STEPS)).astype(np.uint16),
        least=top - deep,
        step=(deep - _MAP_NEAR_M) / _STEPS,
    )


Beam = tuple[ShadowMap, float]  # of a direction, and the weight of the light from there


@dataclass(frozen=True)
class Patch:
    """A wall or a window: (horizontal, z) corners, metres, in side 0 (lower x), 1 (upper x), 2 (lower y) or 3."""

    side: int
    lower: tuple[float, float]
    upper: tuple[float, float]


@dataclass(frozen=True)
class Room:
    """A box with windows: `lower` and `upper` (3,) corners, metres, world frame, and what is in its sides."""

    lower: Singles
    upper: Singles
    walls: tuple[Patch, ...]
    windows: tuple[Patch, ...]

    @property
    def open_sides(self) -> list[int]:
        """Numbers of the sides without a wall."""
        return sorted({0, 1, 2, 3} - {wall.side for wall in self.walls})

    def seen(self, places: Singles, directions: Singles, blur: float = _BLUR) -> Singles:
        """(N, 3) linear RGB seen from (3, N) places along (3, N) directions; sides merge over a share of the way."""
        ways, sides = self.ways(places, directions)
        nearest = ways.min(axis=0)
        shares = np.clip(1 - (ways - nearest) / (np.float32(blur) * nearest + np.float32(1e-4)), 0.0, 1.0)
        shares /= 2 - shares  # of two that are as near each counts half, and the second one fades evenly
        shares /= shares[0] + shares[1] + shares[2]
        bare = [OPEN_SIDE if side in self.open_sides else WALL for side in range(4)]
        colors = np.array([*bare, FLOOR, CEILING], dtype=np.float32)
        light = np.empty((places.shape[1], 3), dtype=np.float32)
        for channel, color in enumerate(colors.T):
            light[:, channel] = sum(share * color[side] for share, side in zip(shares, sides, strict=True))
        face = sides[ways.argmin(axis=0), np.arange(places.shape[1])] if self.windows else sides[0]
        for side in {window.side for window in self.windows}:
            hit = np.flatnonzero(face == side)
            at = np.stack([places[k, hit] + nearest[hit] * directions[k, hit] for k in (1 - side // 2, 2)], axis=1)
            shown = []
            for window in (w for w in self.windows if w.side == side):
                lower, upper = np.asarray(window.lower, np.float32), np.asarray(window.upper, np.float32)
                inwards = np.minimum(at - lower, upper - at)
                # 1 within, falling softly to 0 beyond the edges.
                shown.append(np.clip((inwards + _WINDOW_BLUR_M) / (2 * _WINDOW_BLUR_M), 0.0, 1.0).prod(axis=1))
            light[hit] += np.max(shown, axis=0)[:, None] * _WINDOW
        return light

    def ways(self, places: Singles, directions: Singles) -> tuple[Singles, Ints]:
        """(3, N) how far rays go to the sides ahead, in lengths of directions, and which these are; 4 is the floor."""
        ahead = directions > 0
        ways = np.where(ahead, self.upper[:, None], self.lower[:, None]) - places
        least = np.float32(1e-4)
        ways /= np.where(np.abs(directions) < least, least, directions)
        return np.abs(ways), ahead + np.array([[0], [2], [4]])

    def is_bare(self, places: Singles, sides: Ints) -> Mask:
        """(N,) True for (3, N) places without a wall, on the sides with (N,) numbers; False on floor and ceiling."""
        bare = sides < 4
        for wall in self.walls:
            along = places[1 - wall.side // 2]
            bare &= (sides != wall.side) | (along < wall.lower[0]) | (along > wall.upper[0])
        return bare


def close_open_sides(seen: Surfaces, room: Room, eye: Floats) -> None:
    """Where an eye in the room looks out through a side without a wall, let it see a plain wall there."""
    out = np.flatnonzero(~seen.seen)
    rays = -seen.to_eye.reshape(-1, 3)[out]
    at = np.asarray(eye, dtype=np.float32)
    ways, sides = room.ways(np.tile(at[:, None], (1, len(out))), rays.T)
    side = sides[ways.argmin(axis=0), np.arange(len(out))]
    places = at + rays * ways.min(axis=0)[:, None]
    bare = room.is_bare(places.T, side)
    out = out[bare]
    seen.seen.reshape(-1)[out] = True
    seen.places.reshape(-1, 3)[out], seen.normals.reshape(-1, 3)[out] = places[bare], _SIDES[side[bare]]
    seen.albedo.reshape(-1, 3)[out], seen.gloss.reshape(-1, 3)[out] = _PLAIN_WALL, (0.0, 0.9, 0.0)


def grey_sections(seen: Surfaces, room: Room) -> None:
    """Make walls grey where a picture without ceiling cuts them: their tops, and their ends at the open sides."""
    for side in [*room.open_sides, 5]:
        axis, others = side // 2, [a for a in (0, 1) if a != side // 2]
        beyond = (seen.places[..., others] < room.lower[others]) | (seen.places[..., others] > room.upper[others])
        sign, edge = (1, room.upper[axis]) if side % 2 else (-1, room.lower[axis])
        turned = sign * seen.normals[..., axis] > 0.9
        cut = beyond.any(axis=2) & turned & (sign * (seen.places[..., axis] - edge) > -0.1)
        seen.albedo[cut], seen.gloss[cut] = _SECTION, (0.0, 0.9, 0.0)


def beams(number: int, passes: int, per_pass: int) -> Iterator[tuple[Floats, float]]:
    """Yield (3,) unit vectors to the light of a drawing and weights: the key light, then `per_pass` from all over."""
    spread, turn = _KEY_SOFTNESS * math.sqrt((number + 0.5) / passes), 2.0 * math.pi * GOLDEN * number
    side = np.cross((0.0, 0.0, 1.0), _KEY)
    side /= np.linalg.norm(side)
    key = _KEY + spread * (math.cos(turn) * side + math.sin(turn) * np.cross(_KEY, side))
    yield key / np.linalg.norm(key), 1.0
    for k in range(per_pass):
        # A Fibonacci lattice on the sphere, dealt out like cards so that each drawing has some of all heights.
        n = k * passes + number
        share = (n + 0.5) / (passes * per_pass)
        # Below the horizon half as dense as above, and with twice the weight.
        z, weight = (-1.0 + 3.0 * share, 1.5) if share < 1 / 3 else (1.5 * (share - 1 / 3), 0.75)
        flat, around = math.sqrt(max(0.0, 1.0 - z * z)), 2.0 * math.pi * GOLDEN * n
        # Light of the whole sphere, times the cosine, adds up to a quarter of its area over pi: four makes one of it.
        yield np.array([flat * math.cos(around), flat * math.sin(around), z]), 4.0 * weight / per_pass


def light_on(surfaces: Surfaces, room: Room, number: int, light: Sequence[Beam]) -> Singles:
    """(H, W, 3) light that the surfaces of drawing `number` gather, 0 where nothing is seen; first the key light."""
    at = np.flatnonzero(surfaces.seen)
    normals = np.ascontiguousarray(surfaces.normals.reshape(-1, 3)[at].T)
    places = np.ascontiguousarray(surfaces.places.reshape(-1, 3)[at].T)
    places += np.float32(_OFF_SURFACE_M) * normals
    rows, columns = np.divmod(at, surfaces.seen.shape[1])
    # Two low-discrepancy sequences over the pixels: neighbours get values far apart. Ref: M. Roberts, R2.
    across = rows / PLASTIC + columns / PLASTIC**2 + number * GOLDEN
    along = rows / PLASTIC**2 - columns / PLASTIC + number * GOLDEN**2
    noise = (np.stack([across, along]) % 1.0).astype(np.float32)
    total = np.zeros((len(at), 3), dtype=np.float32)
    for k, (shadow, weight) in enumerate(light):
        cosine = np.dot(shadow.frame[2], normals)
        lit = np.flatnonzero(cosine > 0.01)
        turn, here = k * GOLDEN % 1.0, places[:, lit]
        tilt = noise[:, lit] + np.array([[turn], [turn * GOLDEN]], dtype=np.float32)
        tilt -= np.floor(tilt) + np.float32(0.5)
        tilt *= np.float32(2.0 * (_TILT if k else _KEY_SOFTNESS))
        gap = shadowing(here, shadow, tilt)
        if k:
            shown = room.seen(here, shadow.frame[:2].T @ tilt + shadow.frame[2][:, None])
            hidden = np.flatnonzero(gap > 0.0)
            far = np.sqrt(np.clip((gap[hidden] - _NEAR_M) / np.float32(_FAR_M - _NEAR_M), 0.0, 1.0))
            shown[hidden] = _FIRST_HAND + far[:, None] * (_SECOND_HAND - _FIRST_HAND)
        else:
            shown = _KEY_COLOR * (gap <= 0.0)[:, None]
        total[lit] += shown * (cosine[lit] * np.float32(weight))[:, None]
    # The ceiling and the plain surfaces in place of missing walls emit light.
    total[(normals[2] < -0.9) & (places[2] > room.upper[2] - 0.05)] += _ON_CEILING
    is_open = np.zeros(len(at), dtype=np.bool_)
    for side in range(4):
        edge = (room.lower, room.upper)[side % 2][side // 2]
        near = np.flatnonzero(np.abs(places[side // 2] - edge) < 0.02)
        is_open[near] |= room.is_bare(places[:, near], np.full(len(near), side))
    total[is_open] += _ON_OPEN_SIDE
    image = np.zeros(surfaces.places.shape, dtype=np.float32)
    image.reshape(-1, 3)[at] = total
    return _smoothed(image, surfaces)


def shadowing(places: Singles, shadow: ShadowMap, tilt: Singles) -> Singles:
    """(N,) metres from each place (3, N) to the object that hides it from the light; 0 if nothing hides it.

    The first lookup finds the distance; the second is shifted sideways by (2, N) `tilt` of it, as a soft light spreads.
    """
    x, y, z = shadow.frame @ places
    bias = np.float32(1.5 * shadow.pixel)
    first = shadow.above(x, y) - z
    free = first <= bias
    reach = np.where(free, np.float32(_GUESS_M), np.minimum(first, np.float32(2.0)))
    gap = shadow.above(x + tilt[0] * reach, y + tilt[1] * reach) - z
    # Found beside a place that is lit: it hides it only if it is that far off.
    gap[(gap <= bias) | (free & (2.0 * gap < reach))] = 0.0
    return np.asarray(gap)


def _smoothed(light: Singles, surfaces: Surfaces) -> Singles:
    """(H, W, 3) light, averaged over neighbours that lie in the same plane."""
    for axis in (0, 1):
        total, weight = light.copy(), np.ones(light.shape[:2], dtype=np.float32)
        for step in (-2, -1, 1, 2):
            normals, places = np.roll(surfaces.normals, step, axis=axis), np.roll(surfaces.places, step, axis=axis)
            alike = np.einsum("ijk,ijk->ij", normals, surfaces.normals) > 0.95
            off = np.abs(np.einsum("ijk,ijk->ij", places - surfaces.places, surfaces.normals))
            share = (alike & (off < 0.01) & np.roll(surfaces.seen, step, axis=axis)).astype(np.float32)
            total += np.roll(light, step, axis=axis) * share[..., None]
            weight += share
        light = total / weight[..., None]
    return light


def shade(seen: Surfaces, light: Singles, room: Room, is_inside: bool) -> Floats:
    """(H, W, 3) sRGB, 0..1, of a drawing in its light; an eye in the room sees the sky through windows."""
    color = linear_from_srgb_array(seen.albedo)
    metallic, rough, glow = (seen.gloss[..., k : k + 1] for k in range(3))
    facing = np.einsum("ijk,ijk->ij", seen.normals, seen.to_eye)[..., None]
    # Surfaces mirror the room and the key light; rough ones mix that with the light there.
    away, shape = 2.0 * facing * seen.normals - seen.to_eye, seen.places.shape
    mirrored = room.seen(seen.places.reshape(-1, 3).T, away.reshape(-1, 3).T, _MIRROR_BLUR).reshape(shape)
    blur = 0.015 + 0.25 * rough**2
    mirrored += _KEY_COLOR * (0.05 / blur) * np.exp((away @ _KEY.astype(np.float32) - 1.0)[..., None] / blur)
    free = np.clip(light.mean(axis=2, keepdims=True) / _FREE_LIGHT, 0.0, 1.0)
    reflected = (free * ((1.0 - 0.5 * rough) * mirrored + 0.5 * rough * light)).astype(np.float32)
    slant = (1.0 - np.clip(facing, 0.0, 1.0)) ** 5
    polish = (1.0 - rough) ** 2 * (_LEAST_REFLECTED + (1.0 - _LEAST_REFLECTED) * slant)
    lit = color * ((1.0 - metallic) * _MATT * light + metallic * reflected + _GLOW * glow)
    lit = (lit + (1.0 - metallic) * polish * reflected) * np.float32(_EXPOSURE)
    # Straight in the dark, bent where it nears white.
    bent = np.float32(_SHOULDER) + np.float32(_ABOVE) * np.tanh((lit - _SHOULDER) / np.float32(_ABOVE))
    tone = srgb_from_linear_array(np.where(lit > _SHOULDER, np.minimum(bent, 1.0), lit))
    # The sky is pale at the horizon, and as pale below it.
    rise = np.clip(-1.6 * seen.to_eye[..., 2:], 0.0, 1.0)
    behind = _HORIZON + rise * (_ZENITH - _HORIZON) if is_inside else np.float32(_PAPER)
    tone = np.where(seen.seen[..., None], tone, behind)
    return np.asarray(tone * seen.clear + np.float32(_VEIL) * seen.veil, dtype=np.float64)
