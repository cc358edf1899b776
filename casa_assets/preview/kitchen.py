"""Render a kitchen's `scene.xml` through its own cameras, in soft daylight.

Each picture is the mean of many drawings; see `exposure.py` for the reason.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from PIL import Image

from casa_assets.core.typing import Floats
from casa_assets.preview import renderer, tonemap
from casa_assets.preview.exposure import (
    CameraFrustum,
    LightRig,
    drawing_ids,
    mean_of_drawings,
    one_group,
    set_extent,
    set_quality,
)
from casa_assets.preview.still import CannotDraw, add_highlights_to_model, set_keyframe
from casa_assets.preview.tonemap import Pixels

_VISUAL_GROUP, _HIDDEN_GROUP = 2, 5  # groups of geoms; the ceiling has one of its own
_WALL_PREFIX = "wall_"  # names of walls begin with it
_ON_WALL_M = 0.12  # from the middle of a wall: what is nearer hangs on it
_BACKGROUND_WHITE = 0.955  # brightness of what lies beyond the room
# Brightness of the brightest surfaces, and the exponent of the tone curve. Chosen by eye, as are the lights: a white
# wall keeps its shading, a black front its form.
_SURFACE_WHITE, _GAMMA = 0.93, 0.92
_SKY_SEEN = 0.5  # share of the sky that a place in the room sees, on average
_SHINE = 0.8  # brightness of highlights over that of the light


def _shine(around: float, diffuse: float) -> float:
    return _SHINE * diffuse


# Two large lamps stand behind whoever looks, left and right, 49 degrees up; each drawing has one of them.
_RIG = LightRig(
    ambient=0.3,
    key=0.24,
    sky=0.6,
    bounce=0.55,
    key_azimuths=(-0.65, 0.65),
    key_elevation=0.85,
    softness=0.16,
    key_shine=_SHINE * 0.24,
    sky_shine=_shine,
    bounce_shine=_shine,
    sky_lights=2,
    bounce_lights=3,
    sky_rise=(0.42, 0.58),
    bounce_rise=(0.15, 0.7),
    distance=3.0,
    shadow_reach=1.6,
    sky_follows_viewer=False,
)
_RIG_WITHOUT_SHADOWS = replace(_RIG, sky=_SKY_SEEN * _RIG.sky, sky_casts=False)


@dataclass(frozen=True)
class PictureSettings:
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


_STANDARD = PictureSettings()


@dataclass(frozen=True)
class LoadedScene:
    """A compiled scene and its state, ready to be rendered from several cameras."""

    model: Any
    data: Any

    @property
    def cameras(self) -> tuple[str, ...]:
        """Names of its cameras."""
        return tuple(self.model.camera(i).name for i in range(self.model.ncam))


def open_scene(scene_xml: Path, pose: str = "start", frame: PictureSettings = _STANDARD) -> LoadedScene:
    """Compile a scene and put it into a keyframe.

    Raises:
        CannotDraw: MuJoCo cannot read it, or it has no such keyframe.
    """
    try:
        model = mujoco.MjModel.from_xml_path(str(scene_xml))
    except ValueError as error:
        raise CannotDraw(f"{scene_xml}: {error}".replace("\n", " ")) from error
    return scene_from_model(model, str(scene_xml), pose, frame)


def scene_from_model(model: Any, name: str, pose: str = "start", frame: PictureSettings = _STANDARD) -> LoadedScene:
    """Prepare a compiled scene for rendering and put it into a keyframe; the MjModel is changed.

    Raises:
        CannotDraw: it has no such keyframe; it is called `name` then.
    """
    add_highlights_to_model(model)
    set_quality(model.vis, frame.width_px, frame.height_px, frame.shadow_px)
    data = mujoco.MjData(model)
    set_keyframe(model, data, pose, name)
    mujoco.mj_forward(model, data)
    return LoadedScene(model, data)


def render_cameras(
    made: LoadedScene, cameras: Sequence[str], frame: PictureSettings = _STANDARD
) -> Iterator[tuple[str, Pixels]]:
    """Render each camera: its name and (height, width, 3) uint8 pixels. The ceiling is left out.

    Raises:
        CannotDraw: there is no such camera. NoRenderer: there is no OpenGL.
    """
    model, data = made.model, made.data
    lower, upper = _bounds(model, data)
    center, radius = (lower + upper) / 2, float(np.linalg.norm(upper - lower)) / 2
    set_extent(model, radius, _RIG)
    numbers = {name: mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_CAMERA, name) for name in cameras}
    for name, number in numbers.items():
        if number < 0:
            raise CannotDraw(f"there is no camera {name!r}; there are {', '.join(made.cameras)}")
    if not numbers:
        return
    # The driver is handed meshes and pictures once for all cameras.
    with renderer.canvas(model, data, one_group(_VISUAL_GROUP), frame.width_px, frame.height_px) as canvas:
        for name, number in numbers.items():
            with _walls_before_eye_hidden(model, data, data.cam_xpos[number]):
                canvas.refresh()
            _set_lights(canvas.scene)
            back = data.cam_xmat[number].reshape(3, 3)[:, 2]
            viewer = math.atan2(back[1], back[0]) if np.hypot(back[0], back[1]) > 0.1 else -math.pi / 2
            rig = _RIG if frame.sky_casts else _RIG_WITHOUT_SHADOWS
            lens = _lens(data, model, number, frame, radius)
            exposure = mean_of_drawings(canvas, lens, rig, frame.passes, viewer, center, radius)
            yield name, _tone_map(exposure, _background(canvas))


@contextmanager
def _walls_before_eye_hidden(model: Any, data: Any, eye: Floats) -> Iterator[None]:
    """While it lasts, walls that stand between the eye and the room are not seen, nor what hangs on them."""
    before = model.geom_group.copy()
    for wall in range(1, model.nbody):
        if not model.body(wall).name.startswith(_WALL_PREFIX):
            continue
        turn, at = data.xmat[wall].reshape(3, 3), data.xpos[wall]
        # A wall faces the room with its -y; the origin of its frame is in the middle of its thickness.
        if float((eye - at) @ turn[:, 1]) < 0.3:
            continue
        reach = np.abs(model.geom_aabb[model.geom_bodyid == wall][:, [0, 3]]).sum(axis=1).max()
        for geom in range(model.ngeom):
            along, out, _ = (data.geom_xpos[geom] - at) @ turn
            if abs(along) < reach + 0.1 and -_ON_WALL_M < out < 0.3:
                model.geom_group[geom] = _HIDDEN_GROUP
    try:
        yield
    finally:
        model.geom_group[:] = before


def render(
    scene_xml: Path, cameras: Sequence[str], frame: PictureSettings = _STANDARD, pose: str = "start"
) -> dict[str, bytes]:
    """PNG by name of camera."""
    made = open_scene(scene_xml, pose, frame)
    return {name: tonemap.png(pixels) for name, pixels in render_cameras(made, cameras, frame)}


def _bounds(model: Any, data: Any) -> tuple[Floats, Floats]:
    """(3,) lower and (3,) upper corner of the bounds of all that is seen, world frame, metres."""
    lower, upper = [], []
    for geom in range(model.ngeom):
        if model.geom_group[geom] != _VISUAL_GROUP:
            continue
        middle, half = model.geom_aabb[geom][:3], model.geom_aabb[geom][3:]
        turn = data.geom_xmat[geom].reshape(3, 3)
        at, reach = data.geom_xpos[geom] + turn @ middle, np.abs(turn) @ half
        lower.append(at - reach)
        upper.append(at + reach)
    if not lower:
        raise CannotDraw("nothing in the scene is visible")
    return np.min(lower, axis=0), np.max(upper, axis=0)


def _lens(data: Any, model: Any, camera: int, frame: PictureSettings, radius: float) -> CameraFrustum:
    """CameraFrustum of a camera of the scene."""
    near = 0.02
    half = near * math.tan(math.radians(float(model.cam_fovy[camera])) / 2)
    turn = data.cam_xmat[camera].reshape(3, 3)
    return CameraFrustum(
        position=data.cam_xpos[camera],
        forward=-turn[:, 2],
        up=turn[:, 1],
        near=near,
        far=20.0 * radius,
        half_width=half * frame.width_px / frame.height_px,
        half_height=half,
        jitter=1.3 * 2.0 * half / frame.height_px,
    )


def _set_lights(scene: Any) -> None:
    """Replace the lights of an MjvScene by those of the rig, all off."""
    scene.nlight = _RIG.count
    for light in scene.lights[: scene.nlight]:
        light.type, light.headlight, light.texid = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, 0, -1
        light.attenuation, light.cutoff, light.exponent = [0.0] * 3, 0.0, 0.0


def _background(canvas: renderer.Canvas) -> Floats:
    """(H, W, 1) 1 where nothing of the kitchen is seen."""
    with drawing_ids(canvas):
        seen = canvas.draw().astype(np.int32).sum(axis=2) > 0
    return np.asarray(np.where(seen, 0.0, 1.0)[..., None])


def _tone_map(exposure: Floats, background: Floats) -> Pixels:
    """Scale an exposure so that the brightest surfaces are near white; pixels beyond the room become background."""
    inside = exposure[background[..., 0] < 0.5]
    lit = float(np.percentile(inside, 97)) if len(inside) else 1.0
    tone = np.clip(exposure * (_SURFACE_WHITE / max(lit, 0.2)), 0.0, None)
    tone = np.where(tone > 0.8, 0.8 + 0.2 * np.tanh((tone - 0.8) / 0.2), tone) ** _GAMMA
    return tonemap.to_uint8(tone * (1.0 - background) + _BACKGROUND_WHITE * background)


def picture(pixels: Pixels) -> Image.Image:
    """Pixels as a Pillow image."""
    return Image.fromarray(pixels)
