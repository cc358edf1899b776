"""A kitchen's `scene.xml` into pictures of it, through its own cameras, in soft daylight.

MuJoCo's classic renderer has hard shadows and no light that walls throw back. A picture is the mean of many drawings,
each with the camera moved by less than a pixel and with other directions of the sky lit: smooth edges, soft shadows,
dark corners.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from PIL import Image

from casa_assets.preview import darkroom, renderer
from casa_assets.preview.camera import Floats
from casa_assets.preview.darkroom import Pixels
from casa_assets.preview.still import CannotDraw, polish, put_into

SEEN, CEILING, _HIDDEN = 1, 2, 5  # groups of geoms
_WALL = "wall_"  # names of walls begin with it
_ON_WALL = 0.12  # metres from the middle of a wall within which something hangs on it
# Fractions of white, by eye: a white wall keeps its shading, a black front its form.
_AMBIENT, _SUN, _SKY, _BOUNCE = 0.3, 0.24, 0.6, 0.55
_SKY_SEEN = 0.5  # of a place in the room, on average
_SHINE = 0.8
_DOMES, _BOUNCES = 2, 3
_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
_PLASTIC = 1.32471795724474602596
_SHADOW_REACH, _LIGHT_AT = 1.6, 3.0
_PAPER = 0.955  # brightness of what lies beyond the room
_WHITEST, _GAMMA = 0.93, 0.92
# Two large lamps stand behind whoever looks, left and right, 49 degrees up; each drawing has one of them.
_SUN_ASIDE, _SUN_UP = 0.65, 0.85
_LIGHTS = 1 + _DOMES + _BOUNCES


@dataclass(frozen=True)
class Frame:
    """Size of a picture in pixels, how many drawings it is the mean of, and what they spend on shadows.

    Attributes:
        shadow_px: side of the map of a lamp's shadows.
        sky_casts: whether the sky casts shadows. Where it does not, every place sees half of it, and a picture takes
            half of the time.
    """

    width_px: int = 960
    height_px: int = 720
    passes: int = 40
    shadow_px: int = 2048
    sky_casts: bool = True


_STANDARD = Frame()


@dataclass(frozen=True)
class Set:
    """A compiled scene and its state, ready to be photographed from several sides."""

    model: Any
    data: Any

    @property
    def cameras(self) -> tuple[str, ...]:
        """Names of its cameras."""
        return tuple(self.model.camera(i).name for i in range(self.model.ncam))


def prepare(scene_xml: Path, pose: str = "start", frame: Frame = _STANDARD) -> Set:
    """Reads a scene and puts it into a keyframe.

    Raises:
        CannotDraw: MuJoCo cannot read it, or it has no such keyframe.
    """
    try:
        model = mujoco.MjModel.from_xml_path(str(scene_xml))
    except ValueError as error:
        raise CannotDraw(f"{scene_xml}: {error}".replace("\n", " ")) from error
    return staged(model, str(scene_xml), pose, frame)


def staged(model: Any, name: str, pose: str = "start", frame: Frame = _STANDARD) -> Set:
    """A scene that MuJoCo has read, put into a keyframe; the MjModel is changed.

    Raises:
        CannotDraw: it has no such keyframe; it is called `name` then.
    """
    polish(model)
    model.vis.headlight.active = 0
    model.vis.global_.offwidth, model.vis.global_.offheight = frame.width_px, frame.height_px
    model.vis.quality.offsamples, model.vis.quality.shadowsize = 0, frame.shadow_px
    data = mujoco.MjData(model)
    put_into(model, data, pose, name)
    mujoco.mj_forward(model, data)
    return Set(model, data)


def photograph(made: Set, cameras: Sequence[str], frame: Frame = _STANDARD) -> Iterator[tuple[str, Pixels]]:
    """Name of each camera and its picture, (height, width, 3) uint8. The ceiling is left out.

    Raises:
        CannotDraw: there is no such camera. NoRenderer: there is no OpenGL.
    """
    model, data = made.model, made.data
    lower, upper = _bounds(model, data)
    center, radius = (lower + upper) / 2, float(np.linalg.norm(upper - lower)) / 2
    model.stat.extent, model.vis.map.shadowclip = radius, _SHADOW_REACH
    option = mujoco.MjvOption()
    option.geomgroup[:] = [0, 1, 0, 0, 0, 0]
    option.sitegroup[:] = 0
    numbers = {name: mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_CAMERA, name) for name in cameras}
    for name, number in numbers.items():
        if number < 0:
            raise CannotDraw(f"there is no camera {name!r}; there are {', '.join(made.cameras)}")
    if not numbers:
        return
    # The driver is handed meshes and pictures once for all cameras.
    with renderer.canvas(model, data, option, frame.width_px, frame.height_px) as canvas:
        for name, number in numbers.items():
            with _looked_through(model, data, data.cam_xpos[number]):
                canvas.refresh()
            _hang_lamps(canvas.scene)
            back = data.cam_xmat[number].reshape(3, 3)[:, 2]
            behind = math.atan2(back[1], back[0]) if np.hypot(back[0], back[1]) > 0.1 else -math.pi / 2
            total = np.zeros((frame.height_px, frame.width_px, 3))
            for i in range(frame.passes):
                _aim(canvas.scene, data, model, number, frame, i, radius)
                _light(canvas.scene, i, frame, behind)
                for light in canvas.scene.lights[: canvas.scene.nlight]:
                    light.pos = center - np.array(light.dir) * _LIGHT_AT * radius
                total += canvas.draw()
            beyond = _beyond(canvas)
            yield name, _develop(total / (255.0 * frame.passes), beyond)


@contextmanager
def _looked_through(model: Any, data: Any, eye: Floats) -> Iterator[None]:
    """While it lasts, walls that stand between the eye and the room are not seen, nor what hangs on them."""
    before = model.geom_group.copy()
    for wall in range(1, model.nbody):
        if not model.body(wall).name.startswith(_WALL):
            continue
        turn, at = data.xmat[wall].reshape(3, 3), data.xpos[wall]
        # A wall faces the room with its -y; the origin of its frame is in the middle of its thickness.
        if float((eye - at) @ turn[:, 1]) < 0.3:
            continue
        reach = np.abs(model.geom_aabb[model.geom_bodyid == wall][:, [0, 3]]).sum(axis=1).max()
        for geom in range(model.ngeom):
            along, out, _ = (data.geom_xpos[geom] - at) @ turn
            if abs(along) < reach + 0.1 and -_ON_WALL < out < 0.3:
                model.geom_group[geom] = _HIDDEN
    try:
        yield
    finally:
        model.geom_group[:] = before


def render(scene_xml: Path, cameras: Sequence[str], frame: Frame = _STANDARD, pose: str = "start") -> dict[str, bytes]:
    """PNG by name of camera."""
    made = prepare(scene_xml, pose, frame)
    return {name: darkroom.png(pixels) for name, pixels in photograph(made, cameras, frame)}


def _bounds(model: Any, data: Any) -> tuple[Floats, Floats]:
    """Least and greatest corner of all that is seen, metres."""
    lows, highs = [], []
    for geom in range(model.ngeom):
        if model.geom_group[geom] != SEEN:
            continue
        middle, half = model.geom_aabb[geom][:3], model.geom_aabb[geom][3:]
        turn = data.geom_xmat[geom].reshape(3, 3)
        at, reach = data.geom_xpos[geom] + turn @ middle, np.abs(turn) @ half
        lows.append(at - reach)
        highs.append(at + reach)
    if not lows:
        raise CannotDraw("nothing in the scene is visible")
    return np.min(lows, axis=0), np.max(highs, axis=0)


def _aim(scene: Any, data: Any, model: Any, camera: int, frame: Frame, i: int, radius: float) -> None:
    """Puts both eyes of the scene at a camera, moved by a part of a pixel."""
    near = 0.02
    half = near * math.tan(math.radians(float(model.cam_fovy[camera])) / 2)
    pixel = 1.3 * 2.0 * half / frame.height_px
    right = ((0.5 + i / _PLASTIC) % 1.0 - 0.5) * pixel
    up = ((0.5 + i / _PLASTIC**2) % 1.0 - 0.5) * pixel
    turn = data.cam_xmat[camera].reshape(3, 3)
    for eye in scene.camera:
        eye.pos, eye.forward, eye.up = data.cam_xpos[camera], -turn[:, 2], turn[:, 1]
        eye.orthographic = 0
        eye.frustum_near, eye.frustum_far = near, 20.0 * radius
        eye.frustum_center, eye.frustum_width = right, half * frame.width_px / frame.height_px
        eye.frustum_bottom, eye.frustum_top = up - half, up + half


def _hang_lamps(scene: Any) -> None:
    """Lamps of our own in place of the scene's, which `_light` turns on."""
    scene.nlight = _LIGHTS
    for light in scene.lights[:_LIGHTS]:
        light.type, light.headlight, light.texid = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, 0, -1
        light.attenuation, light.cutoff, light.exponent = [0.0] * 3, 0.0, 0.0


def _light(scene: Any, i: int, frame: Frame, behind: float) -> None:
    """The lights of drawing `i`: the sun within a soft box, some of the sky, and what floor and walls throw back.

    Args:
        behind: direction that the viewer comes from, radians to the left of the x axis.
    """
    lights, passes = scene.lights[: scene.nlight], frame.passes
    sun, domes, bounces = lights[0], lights[1 : 1 + _DOMES], lights[1 + _DOMES :]
    spread = 0.16 * math.sqrt((i + 0.5) / passes)
    turn = 2.0 * math.pi * _GOLDEN * i
    _set(
        sun,
        behind + (_SUN_ASIDE if i % 2 else -_SUN_ASIDE) + spread * math.cos(turn),
        _SUN_UP + spread * math.sin(turn),
        _SUN,
        True,
    )
    sun.ambient = [_AMBIENT] * 3
    sky = _SKY if frame.sky_casts else _SKY_SEEN * _SKY
    for n, light in enumerate(domes, start=i * _DOMES):
        rise = math.asin(0.42 + 0.58 * ((n + 0.5) / (passes * _DOMES)))
        _set(light, 2.0 * math.pi * _GOLDEN * n, rise, sky / _DOMES, frame.sky_casts)
    for n, light in enumerate(bounces, start=i * _BOUNCES):
        rise = 0.15 - 0.7 * ((n / _PLASTIC) % 1.0)
        _set(light, 2.0 * math.pi * _GOLDEN * n, rise, _BOUNCE / _BOUNCES, False)


def _set(light: Any, azimuth: float, elevation: float, diffuse: float, casts: bool) -> None:
    """Light that comes from there (rad, world frame), as a fraction of white."""
    flat = math.cos(elevation)
    light.dir = [-flat * math.cos(azimuth), -flat * math.sin(azimuth), -math.sin(elevation)]
    light.ambient, light.diffuse, light.specular = [0.0] * 3, [diffuse] * 3, [_SHINE * diffuse] * 3
    light.castshadow = int(casts)


def _beyond(canvas: renderer.Canvas) -> Floats:
    """(H, W, 1) 1 where nothing of the kitchen is seen."""
    flags = (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR)
    for flag in flags:
        canvas.scene.flags[flag] = 1
    seen = canvas.draw().astype(np.int32).sum(axis=2) > 0
    for flag in flags:
        canvas.scene.flags[flag] = 0
    return np.asarray(np.where(seen, 0.0, 1.0)[..., None])


def _develop(exposure: Floats, beyond: Floats) -> Pixels:
    """Exposure so that the brightest surfaces are near white; what lies beyond the room becomes paper."""
    inside = exposure[beyond[..., 0] < 0.5]
    lit = float(np.percentile(inside, 97)) if len(inside) else 1.0
    tone = np.clip(exposure * (_WHITEST / max(lit, 0.2)), 0.0, None)
    tone = np.where(tone > 0.8, 0.8 + 0.2 * np.tanh((tone - 0.8) / 0.2), tone) ** _GAMMA
    tone = tone * (1.0 - beyond) + _PAPER * beyond
    return np.asarray(np.clip(np.rint(tone * 255.0), 0, 255), dtype=np.uint8)


def picture(pixels: Pixels) -> Image.Image:
    """Pixels as a Pillow image."""
    return Image.fromarray(pixels)
