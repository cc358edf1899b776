"""Render a kitchen's `scene.xml` through its own cameras, as by day with the lamps on.

MuJoCo draws what each camera sees, and what each direction of the light sees; `room_light.py` lights the one by the
other. A picture is the mean of drawings moved by a part of a pixel and lit from other directions. Why MuJoCo's own
lights are not used: docs/explanation/libraries.md.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from casa_assets.core.numeric import Floats
from casa_assets.show.stills.photoreal import View
from casa_assets.show.stills.pictures import Pixels, to_uint8
from casa_assets.show.stills.renderer import Bounds, CameraFrustum, Canvas, canvas, one_group, set_quality
from casa_assets.show.stills.room_light import (
    OPAQUE,
    Beam,
    Patch,
    Room,
    Surfaces,
    beams,
    close_open_sides,
    draw_shadow_map,
    draw_surfaces,
    grey_sections,
    light_on,
    plain_scene,
    shade,
)
from casa_assets.show.stills.still import CannotDraw, set_keyframe

_Light = list[list[Beam]]  # of each drawing
# Groups of geoms; those that are see-through are put into a separate one while a picture is drawn.
_CLEAR_GROUP, _VISUAL_GROUP, _CEILING_GROUP, _HIDDEN_GROUP = 1, 2, 4, 5
_FLOOR, _CEILING, _WALL_PREFIX = "floor", "ceiling", "wall_"  # names of the bodies of a room; walls begin with it
_ON_WALL_M = 0.12  # from the middle of a wall: what is nearer hangs on it
_IN_WALL_M = 0.25  # from the inner face of a wall outwards: glass there is a window


@dataclass(frozen=True)
class PictureSettings:
    """Size of a picture, drawings that it is the mean of, directions of light in each, and side of a map of shadows."""

    width_px: int = 960
    height_px: int = 720
    passes: int = 6
    directions: int = 12
    shadow_px: int = 1024


@dataclass(frozen=True)
class LoadedScene:
    """A compiled scene (MjModel, MjData), ready to be rendered from several cameras."""

    model: Any
    data: Any

    @property
    def cameras(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(self.model.camera(i).name for i in range(self.model.ncam))


def open_scene(scene_xml: Path, frame: PictureSettings, pose: str = "start") -> LoadedScene:
    """Compile a scene and put it into a keyframe. Raises CannotDraw if MuJoCo cannot, or it has no such keyframe."""
    try:
        model = mujoco.MjModel.from_xml_path(str(scene_xml))
    except ValueError as error:
        raise CannotDraw(f"{scene_xml}: {error}".replace("\n", " ")) from error
    return scene_from_model(model, str(scene_xml), frame, pose)


def scene_from_model(model: Any, name: str, frame: PictureSettings, pose: str = "start") -> LoadedScene:
    """Prepare a compiled scene, here called `name`, as `open_scene` does; the MjModel is changed."""
    # The buffer also holds the maps of shadows.
    width_px, height_px = (max(side, frame.shadow_px) for side in (frame.width_px, frame.height_px))
    set_quality(model.vis, width_px, height_px, shadow_px=1)
    data = mujoco.MjData(model)
    set_keyframe(model, data, pose, name)
    mujoco.mj_forward(model, data)
    return LoadedScene(model, data)


def render_cameras(
    made: LoadedScene, cameras: Sequence[str | View], frame: PictureSettings
) -> Iterator[tuple[str, Pixels]]:
    """Name and (height, width, 3) uint8 pixels of cameras of the scene, by their names, or of other views.

    An eye in the room sees the ceiling, and a plain wall where the room is open; from outside the ceiling is left out.
    Raises CannotDraw if there is no such camera, NoRenderer.
    """
    model, data = made.model, made.data
    room = room_of(model, data, _bounds(model, data))
    far = 10.0 * float(np.linalg.norm(room.upper - room.lower))
    lenses = [_lens(made, camera, frame, far) for camera in dict.fromkeys(cameras)]
    if not lenses:
        return
    # The driver is handed meshes and pictures once for all cameras.
    with canvas(model, data, one_group(_VISUAL_GROUP), frame.width_px, frame.height_px) as drawing:
        light = _light(drawing, made, room, frame)
        for name, lens in lenses:
            yield name, to_uint8(_render(drawing, made, lens, room, light, frame))


def _lens(made: LoadedScene, camera: str | View, frame: PictureSettings, far: float) -> tuple[str, CameraFrustum]:
    """Name and frustum of a camera of the scene, or of a separate view."""
    aspect, near, rise = frame.width_px / frame.height_px, 0.02, 0.0
    if isinstance(camera, View):
        half_width, turn = math.tan(camera.fov_x / 2), np.empty(9)
        mujoco.mju_quat2Mat(turn, np.array(camera.quaternion))
        name, position, half = camera.name, np.array(camera.position), half_width / aspect
        rise = 2.0 * half_width * camera.shift_y
    else:
        number = mujoco.mj_name2id(made.model, mujoco.mjtObj.mjOBJ_CAMERA, camera)
        if number < 0:
            raise CannotDraw(f"there is no camera {camera!r}; there are {', '.join(made.cameras)}")
        name, position, turn = camera, made.data.cam_xpos[number], made.data.cam_xmat[number]
        half = math.tan(math.radians(float(made.model.cam_fovy[number])) / 2)
    forward, up = -turn.reshape(3, 3)[:, 2], turn.reshape(3, 3)[:, 1]
    jitter = 1.3 * 2.0 * near * half / frame.height_px
    return name, CameraFrustum(position, forward, up, near, far, near * half * aspect, near * half, jitter, near * rise)


def _light(canvas: Canvas, made: LoadedScene, room: Room, frame: PictureSettings) -> _Light:
    """The shadow map and the weight of each direction of the light of each drawing."""
    model = made.model
    with _groups_restored(model) as groups:
        for geom in np.flatnonzero(groups == _VISUAL_GROUP).tolist():
            if _is_shell(model.body(model.geom_bodyid[geom]).name) or _is_clear(model, geom):
                groups[geom] = _HIDDEN_GROUP
        scene = plain_scene(canvas.new_scene(one_group(_VISUAL_GROUP)))
        least, most = _bounds(model, made.data)
    # Beyond the walls there is nothing to shade.
    box = np.maximum(least, room.lower - 0.3), np.minimum(most, room.upper + 0.3)
    corners = np.array([[box[k >> i & 1][i] for i in range(3)] for k in range(8)])
    drawings = (beams(number, frame.passes, frame.directions) for number in range(frame.passes))
    return [[(draw_shadow_map(canvas, scene, to, corners, frame.shadow_px), w) for to, w in d] for d in drawings]


def _render(
    canvas: Canvas, made: LoadedScene, lens: CameraFrustum, room: Room, light: _Light, frame: PictureSettings
) -> Floats:
    """(H, W, 3) sRGB, 0..1, of one camera."""
    model, eye = made.model, lens.position
    is_inside = bool((eye > room.lower).all() and (eye < room.upper).all())
    solid, every = one_group(_VISUAL_GROUP), one_group(_CLEAR_GROUP)
    solid.geomgroup[_CEILING_GROUP] = int(is_inside)
    every.geomgroup[:] |= solid.geomgroup

    def shaded(number: int, seen: Surfaces) -> Floats:
        if is_inside:
            close_open_sides(seen, room, eye)
        else:
            grey_sections(seen, room)
        return shade(seen, light_on(seen, room, number, light[number]), room, is_inside)

    with _groups_restored(model) as groups, ThreadPoolExecutor(1) as pool:
        _hide_walls_before(model, made.data, eye)
        groups[[g for g in np.flatnonzero(groups == _VISUAL_GROUP).tolist() if _is_clear(model, g)]] = _CLEAR_GROUP
        drawn = draw_surfaces(canvas, solid, every, lens, frame.passes, (frame.width_px, frame.height_px))
        # OpenGL draws in this thread; what it has drawn is shaded in another while it draws the next.
        shadings = [pool.submit(shaded, number, seen) for number, seen in enumerate(drawn)]
    total: Floats = sum((shading.result() for shading in shadings), np.zeros(()))
    return total / frame.passes


@contextmanager
def _groups_restored(model: Any) -> Iterator[Any]:
    """The groups of the geoms of a model, to be changed; they are as before at the end."""
    before = model.geom_group.copy()
    try:
        yield model.geom_group
    finally:
        model.geom_group[:] = before


def _hide_walls_before(model: Any, data: Any, eye: Floats) -> None:
    for wall in range(1, model.nbody):
        if not model.body(wall).name.startswith(_WALL_PREFIX):
            continue
        turn, at = data.xmat[wall].reshape(3, 3), data.xpos[wall]
        # A wall faces the room with its -y; the origin of its frame is in the middle of its thickness.
        if float((eye - at) @ turn[:, 1]) < 0.3:
            continue
        reach = np.abs(model.geom_aabb[model.geom_bodyid == wall][:, [0, 3]]).sum(axis=1).max()
        along, out, _ = ((data.geom_xpos - at) @ turn).T
        model.geom_group[(np.abs(along) < reach + 0.1) & (out > -_ON_WALL_M) & (out < 0.3)] = _HIDDEN_GROUP


def room_of(model: Any, data: Any, bounds: Bounds) -> Room:
    """The room of a compiled kitchen after `mj_forward`; `bounds`, of all that is visible, replace a missing floor."""
    lower, upper = (corner.copy() for corner in bounds)
    bodies = {model.body(i).name: i for i in range(1, model.nbody)}
    parts = {name: np.flatnonzero(model.geom_bodyid == i) for name, i in bodies.items() if _is_shell(name)}
    # Of a body its boxes where it has some, as the bounds of a mesh may lie askew.
    flat = {name: geoms[model.geom_type[geoms] == mujoco.mjtGeom.mjGEOM_BOX] for name, geoms in parts.items()}
    boxes = {name: _boxes(model, data, flat[name] if len(flat[name]) else geoms) for name, geoms in parts.items()}
    if _FLOOR in boxes:
        least, most = boxes[_FLOOR].min(axis=0)[0], boxes[_FLOOR].max(axis=0)[1]
        lower[:2], upper[:2], lower[2] = least[:2], most[:2], most[2]
    if _CEILING in boxes:
        upper[2] = _boxes(model, data, parts[_CEILING])[:, 0, 2].max()  # beams hang from it
    walls, windows = [], []
    for name in (name for name in boxes if name.startswith(_WALL_PREFIX)):
        # It faces the room with its -y.
        outwards = data.xmat[bodies[name]].reshape(3, 3)[:, 1]
        axis = int(np.abs(outwards[:2]).argmax())
        side = 2 * axis + int(outwards[axis] > 0)
        if abs(data.xpos[bodies[name]][axis] - (lower, upper)[side % 2][axis]) < _IN_WALL_M:
            start, end = boxes[name][:, 0, 1 - axis].min() - 0.01, boxes[name][:, 1, 1 - axis].max() + 0.01
            walls.append(Patch(side, (start, lower[2]), (end, upper[2])))
    clear = [g for g in np.flatnonzero(model.geom_group == _VISUAL_GROUP).tolist() if _is_clear(model, g)]
    for (least, most), side in product(_boxes(model, data, clear), range(4)):
        axis, middle = side // 2, (least + most) / 2.0
        out = (middle - upper)[axis] if side % 2 else (lower - middle)[axis]
        if 0.0 < out < _IN_WALL_M and (most - least)[axis] < 0.2:
            windows.append(Patch(side, tuple(least[[1 - axis, 2]]), tuple(most[[1 - axis, 2]])))
    return Room(lower.astype(np.float32), upper.astype(np.float32), tuple(walls), tuple(windows))


def _bounds(model: Any, data: Any) -> Bounds:
    boxes = _boxes(model, data, np.flatnonzero(model.geom_group == _VISUAL_GROUP))
    if not len(boxes):
        raise CannotDraw("nothing in the scene is visible")
    return boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)


def _boxes(model: Any, data: Any, geoms: Iterable[int]) -> Floats:
    """(N, 2, 3) lower and upper corner of the bounds of each geom, world frame, metres."""
    found = []
    for geom in geoms:
        turn, half = data.geom_xmat[geom].reshape(3, 3), model.geom_aabb[geom][3:]
        middle = data.geom_xpos[geom] + turn @ model.geom_aabb[geom][:3]
        found.append((middle - np.abs(turn) @ half, middle + np.abs(turn) @ half))
    return np.array(found).reshape(-1, 2, 3)


def _is_shell(name: str) -> bool:
    return name in (_FLOOR, _CEILING) or name.startswith(_WALL_PREFIX)


def _is_clear(model: Any, geom: int) -> bool:
    material = int(model.geom_matid[geom])
    return float((model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom])[3]) < OPAQUE
