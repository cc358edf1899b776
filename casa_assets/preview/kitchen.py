"""Render a kitchen's `scene.xml` through its own cameras, as by day with the lamps on.

MuJoCo draws what each camera sees, and what each direction of the light sees; `preview/room/` lights the one by the
other. Each picture is the mean of a few drawings that are moved by a part of a pixel and lit from other directions.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from PIL import Image

from casa_assets.core.typing import Floats, Singles
from casa_assets.preview import renderer, tonemap
from casa_assets.preview.exposure import GOLDEN, Bounds, CameraFrustum, one_group, set_quality
from casa_assets.preview.photoreal.viewpoint import View
from casa_assets.preview.room.lighting import Beam, Receiver, beams, smoothed
from casa_assets.preview.room.shading import shade
from casa_assets.preview.room.shadow_maps import ShadowMap, draw_shadow_map
from casa_assets.preview.room.surfaces import (
    SurfaceDrawer,
    Surfaces,
    close_open_sides,
    grey_sections,
    plain_scene,
)
from casa_assets.preview.room.surroundings import (
    VISUAL_GROUP,
    Surroundings,
    geom_bounds,
    is_clear,
    is_shell,
    surroundings_of,
)
from casa_assets.preview.still import CannotDraw, set_keyframe
from casa_assets.preview.tonemap import Pixels

# Groups of geoms; those that are see-through are put into one of their own while a picture is drawn.
_CLEAR_GROUP, _CEILING_GROUP, _HIDDEN_GROUP = 1, 4, 5
_WALL_PREFIX = "wall_"  # names of walls begin with it
_ON_WALL_M = 0.12  # from the middle of a wall: what is nearer hangs on it
_OFF_SURFACE_M = 0.008  # by which places are moved off their surface, so that it does not shade itself


@dataclass(frozen=True)
class PictureSettings:
    """Size of a picture in pixels, how many drawings it is the mean of, and what they spend on light.

    Attributes:
        directions: that light comes from in each drawing, beside the key light.
        shadow_px: side of the map of the shadows of a direction.
    """

    width_px: int = 960
    height_px: int = 720
    passes: int = 6
    directions: int = 12
    shadow_px: int = 1024


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
    # The buffer also holds the maps of shadows.
    width_px, height_px = max(frame.width_px, frame.shadow_px), max(frame.height_px, frame.shadow_px)
    set_quality(model.vis, width_px, height_px, shadow_px=1)
    data = mujoco.MjData(model)
    set_keyframe(model, data, pose, name)
    mujoco.mj_forward(model, data)
    return LoadedScene(model, data)


@dataclass(frozen=True)
class _Eye:
    """A camera.

    Attributes:
        position: (3,) metres. turn: (3, 3) world_from_camera.
        half_height, rise: of the picture and of its middle over the axis, at one metre, metres.
    """

    name: str
    position: Floats
    turn: Floats
    half_height: float
    rise: float = 0.0


def _eye(made: LoadedScene, camera: str | View, frame: PictureSettings) -> _Eye:
    """A camera of the scene, or one that stands elsewhere."""
    if isinstance(camera, View):
        half_width = math.tan(camera.fov_x / 2)
        half_height = half_width * frame.height_px / frame.width_px
        turn = np.empty(9)
        mujoco.mju_quat2Mat(turn, np.array(camera.quaternion))
        rise = 2.0 * half_width * camera.shift_y
        return _Eye(camera.name, np.array(camera.position), turn.reshape(3, 3), half_height, rise)
    number = mujoco.mj_name2id(made.model, mujoco.mjtObj.mjOBJ_CAMERA, camera)
    if number < 0:
        raise CannotDraw(f"there is no camera {camera!r}; there are {', '.join(made.cameras)}")
    half_height = math.tan(math.radians(float(made.model.cam_fovy[number])) / 2)
    return _Eye(camera, made.data.cam_xpos[number], made.data.cam_xmat[number].reshape(3, 3), half_height)


def render_cameras(
    made: LoadedScene, cameras: Sequence[str | View], frame: PictureSettings = _STANDARD
) -> Iterator[tuple[str, Pixels]]:
    """Render each camera: its name and (height, width, 3) uint8 pixels.

    An eye in the room sees the ceiling, and a plain wall where the room is open; from outside the ceiling is left out.

    Args:
        cameras: names of those of the scene, or views of one's own.
    Raises:
        CannotDraw: there is no such camera. NoRenderer: there is no OpenGL.
    """
    model, data = made.model, made.data
    eyes = [_eye(made, camera, frame) for camera in dict.fromkeys(cameras)]
    if not eyes:
        return
    room = surroundings_of(model, data, _bounds(model, data))
    # The driver is handed meshes and pictures once for all cameras.
    with renderer.canvas(model, data, one_group(VISUAL_GROUP), frame.width_px, frame.height_px) as canvas:
        light = _Light(canvas, model, data, room, frame)
        for eye in eyes:
            yield eye.name, tonemap.to_uint8(_render(canvas, model, data, eye, light))


class _Light:
    """Light of a scene in one pose: from where it comes, and what stands in its way. Its maps serve all cameras."""

    def __init__(
        self, canvas: renderer.Canvas, model: Any, data: Any, room: Surroundings, frame: PictureSettings
    ) -> None:
        self.room, self.frame = room, frame
        self._canvas = canvas
        with _groups_restored(model) as groups:
            for geom in range(model.ngeom):
                if groups[geom] == VISUAL_GROUP and (is_clear(model, geom) or is_shell(model, geom)):
                    groups[geom] = _HIDDEN_GROUP
            self._scene = plain_scene(canvas.new_scene(one_group(VISUAL_GROUP)))
            # Beyond the walls there is nothing to shade.
            lower = np.maximum(_bounds(model, data)[0], room.lower - 0.3)
            upper = np.minimum(_bounds(model, data)[1], room.upper + 0.3)
        self._corners = np.array([[(lower, upper)[k >> i & 1][i] for i in range(3)] for k in range(8)])
        self._maps: dict[tuple[int, int], ShadowMap] = {}

    def maps(self, number: int) -> list[tuple[Beam, ShadowMap]]:
        """Where light comes from in drawing `number`, and what throws shadows there."""
        found = []
        for k, beam in enumerate(beams(number, self.frame.passes, self.frame.directions)):
            at = (number, k)
            if at not in self._maps:
                size_px = self.frame.shadow_px
                self._maps[at] = draw_shadow_map(self._canvas, self._scene, beam.towards, self._corners, size_px)
            found.append((beam, self._maps[at]))
        return found


def _light_on(seen: Surfaces, number: int, maps: Sequence[tuple[Beam, ShadowMap]], room: Surroundings) -> Singles:
    """(H, W, 3) light on the surfaces of drawing `number`."""
    receiver = Receiver(seen, _OFF_SURFACE_M, number)
    for k, (beam, shadow) in enumerate(maps):
        receiver.add(beam, shadow, room, k * GOLDEN % 1.0)
    return smoothed(receiver.image(room), seen)


def _render(canvas: renderer.Canvas, model: Any, data: Any, camera: _Eye, light: _Light) -> Floats:
    """(H, W, 3) sRGB, 0..1, of one camera."""
    frame, room, eye = light.frame, light.room, camera.position
    is_inside = room.contains(eye)
    solid = one_group(VISUAL_GROUP)
    solid.geomgroup[_CEILING_GROUP] = int(is_inside)
    every = one_group(_CLEAR_GROUP)
    every.geomgroup[:] |= solid.geomgroup
    with _groups_restored(model) as groups, _walls_before_eye_hidden(model, data, eye):
        for geom in range(model.ngeom):
            if groups[geom] == VISUAL_GROUP and is_clear(model, geom):
                groups[geom] = _CLEAR_GROUP
        drawer = SurfaceDrawer(canvas, model, solid, every)
    lens = _lens(camera, frame, float(np.linalg.norm(room.upper - room.lower)) / 2)

    def shaded(number: int, seen: Surfaces, maps: Sequence[tuple[Beam, ShadowMap]]) -> Floats:
        """Drawing `number` in its light."""
        if is_inside:
            close_open_sides(seen, room, eye)
        else:
            grey_sections(seen, room)
        return shade(seen, _light_on(seen, number, maps, room), room, is_inside)

    # OpenGL draws in this thread; what it has drawn is shaded in another while it draws the next.
    with ThreadPoolExecutor(1) as pool:
        drawings = [
            pool.submit(shaded, number, drawer.draw(lens, number, frame.width_px, frame.height_px), light.maps(number))
            for number in range(frame.passes)
        ]
    total: Floats = np.zeros(())
    for drawing in drawings:
        total = total + drawing.result()
    return np.asarray(total / frame.passes)


@contextmanager
def _groups_restored(model: Any) -> Iterator[Any]:
    """The groups of the geoms of a model, to be changed; they are as before at the end."""
    before = model.geom_group.copy()
    try:
        yield model.geom_group
    finally:
        model.geom_group[:] = before


@contextmanager
def _walls_before_eye_hidden(model: Any, data: Any, eye: Floats) -> Iterator[None]:
    """While it lasts, walls that stand between the eye and the room are not seen, nor what hangs on them."""
    with _groups_restored(model) as groups:
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
                    groups[geom] = _HIDDEN_GROUP
        yield


def render(
    scene_xml: Path, cameras: Sequence[str], frame: PictureSettings = _STANDARD, pose: str = "start"
) -> dict[str, bytes]:
    """PNG by name of camera."""
    made = open_scene(scene_xml, pose, frame)
    return {name: tonemap.png(pixels) for name, pixels in render_cameras(made, cameras, frame)}


def _bounds(model: Any, data: Any) -> Bounds:
    """Bounds of all that is seen."""
    boxes = [geom_bounds(model, data, geom) for geom in range(model.ngeom) if model.geom_group[geom] == VISUAL_GROUP]
    if not boxes:
        raise CannotDraw("nothing in the scene is visible")
    return np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)


def _lens(camera: _Eye, frame: PictureSettings, radius: float) -> CameraFrustum:
    """CameraFrustum of a camera."""
    near = 0.02
    half = near * camera.half_height
    return CameraFrustum(
        position=camera.position,
        forward=-camera.turn[:, 2],
        up=camera.turn[:, 1],
        near=near,
        far=20.0 * radius,
        half_width=half * frame.width_px / frame.height_px,
        half_height=half,
        jitter=1.3 * 2.0 * half / frame.height_px,
        rise=near * camera.rise,
    )


def picture(pixels: Pixels) -> Image.Image:
    """Pixels as a Pillow image."""
    return Image.fromarray(pixels)
