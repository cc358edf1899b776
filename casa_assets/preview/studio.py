"""The studio every picture is taken in: light floor, soft light from a dome, a camera that fits what it sees.

MuJoCo's classic renderer has hard shadows and no environment to reflect. A picture is therefore the mean of many
drawings: each has the camera moved by less than a pixel (smooth edges), the key light moved within its soft box (soft
shadows) and other directions of the dome lit (dark creases, and a sheen on metal).
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
from PIL import Image, ImageFilter

from casa_assets.preview import darkroom, renderer
from casa_assets.preview.camera import Camera, Floats, View
from casa_assets.preview.darkroom import Mask, Pixels

# The light of one drawing, as fractions of white. Chosen by eye: a white mug keeps its shading, a black one its form.
# Highlights exceed 1 because each direction is lit in one drawing only and then shared by all.
_AMBIENT = 0.22
_KEY, _KEY_SHINE = 0.38, 0.9
_SKY, _SKY_SHINE = 0.76, 4.0
_BOUNCE, _BOUNCE_SHINE = 0.30, 9.0
# Lights per drawing besides the key: directions of the dome, and directions from which the floor throws light back.
_DOMES, _BOUNCES = 2, 4
# Colour of the floor, and light of its own that softens the shadows on it.
_PAPER, _GLOW = 0.66, 0.25
# Half the width of the shadow maps, and how far off the lights stand, in radii of the thing.
_SHADOW_REACH, _LIGHT_AT = 2.2, 4.0
# A large mesh is drawn fewer times: this many faces are drawn the full number of times.
_FACES, _FEWEST = 12_000, 12
# Steps of these fractions fill a line or a square evenly. Ref: M. Roberts, the R2 sequence.
_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
_PLASTIC = 1.32471795724474602596
_FLOOR = "studio__floor"
_CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


def furnish(spec: Any, size_px: int) -> None:
    """Clears an MjSpec of lights and cameras and adds the studio: floor, lights, a frame that is large enough."""
    for thing in [*spec.lights, *spec.cameras]:
        spec.delete(thing)
    spec.visual.headlight.active = 0
    spec.visual.global_.offwidth = spec.visual.global_.offheight = size_px
    spec.visual.quality.offsamples = 0
    spec.visual.quality.shadowsize = 1024
    material = spec.add_material()
    material.name = "studio__paper"
    material.rgba = [_PAPER, _PAPER, _PAPER, 1.0]
    material.emission = _GLOW
    material.specular = material.shininess = material.reflectance = 0.0
    floor = spec.worldbody.add_geom()
    floor.name, floor.material, floor.group = _FLOOR, material.name, 1
    floor.type, floor.size = mujoco.mjtGeom.mjGEOM_PLANE, [1.0, 1.0, 1.0]
    floor.contype = floor.conaffinity = 0
    for i in range(1 + _DOMES + _BOUNCES):
        light = spec.worldbody.add_light()
        light.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
        light.castshadow = i <= _DOMES


def stand(model: Any, data: Any) -> Floats:
    """(N, 3) vertices of all that is to be seen, metres, world frame; puts the floor under them.

    Args:
        model, data: a furnished model after `mj_forward`.
    """
    floor = int(model.geom(_FLOOR).id)
    points = np.concatenate([_vertices(model, data, g) for g in range(model.ngeom) if g != floor])
    lower, upper = points.min(axis=0), points.max(axis=0)
    radius = _radius(points)
    model.geom_size[floor] = 40.0 * radius
    data.geom_xpos[floor] = [*((lower + upper)[:2] / 2.0), lower[2] - 1e-4 * radius]
    model.stat.extent, model.vis.map.shadowclip = radius, _SHADOW_REACH
    return points


def photograph(model: Any, data: Any, points: Floats, camera: Camera, view: View, both_sides: bool = False) -> Pixels:
    """The picture of a furnished model on its floor.

    Args:
        model, data: as `stand` left them.
        points: (N, 3) metres, world frame, from `stand`.
        camera: fitted to the points.
        view: size and number of drawings.
        both_sides: shows faces from behind too.
    Returns:
        (size_px, size_px, 3) uint8.
    Raises:
        NoRenderer: there is no OpenGL.
    """
    center, radius = (points.min(axis=0) + points.max(axis=0)) / 2.0, _radius(points)
    option = mujoco.MjvOption()
    option.geomgroup[:] = [0, 1, 0, 0, 0, 0]
    option.sitegroup[:] = 0
    passes = max(min(_FEWEST, view.passes), min(view.passes, view.passes * _FACES // max(1, model.nmeshface)))
    total = np.zeros((view.size_px, view.size_px, 3))
    with renderer.canvas(model, data, option, view.size_px, view.size_px) as canvas:
        canvas.scene.flags[mujoco.mjtRndFlag.mjRND_CULL_FACE] = int(not both_sides)
        for i in range(passes):
            _aim(canvas.scene, camera, view.size_px, radius, i)
            _light(canvas.scene, camera, i, passes)
            for light in canvas.scene.lights[: canvas.scene.nlight]:
                light.pos = center - np.array(light.dir) * _LIGHT_AT * radius
            total += canvas.draw()
        paper = _paper(canvas, int(model.geom(_FLOOR).id))
    return darkroom.develop(darkroom.smooth(total / (255.0 * passes), paper), paper)


def _radius(points: Floats) -> float:
    """Half the diagonal of the bounds, metres, > 0."""
    return float(np.linalg.norm(points.max(axis=0) - points.min(axis=0))) / 2.0 + 1e-9


def _vertices(model: Any, data: Any, geom: int) -> Floats:
    """(N, 3) vertices of a mesh geom, of the ball or of the box round any other; metres, world frame."""
    mesh = int(model.geom_dataid[geom])
    if mesh >= 0 and model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        start = int(model.mesh_vertadr[mesh])
        local = model.mesh_vert[start : start + int(model.mesh_vertnum[mesh])]
    else:
        kind = mujoco.mjtGeom(int(model.geom_type[geom]))
        is_round = kind in (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_ELLIPSOID)
        local = model.geom_aabb[geom][:3] + model.geom_aabb[geom][3:] * (_ball() if is_round else _CORNERS)
    return np.asarray(local @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom], dtype=np.float64)


def _ball() -> Floats:
    """(200, 3) points on the unit sphere, a Fibonacci lattice."""
    n = np.arange(200)
    z, turn = 1.0 - (2.0 * n + 1.0) / len(n), 2.0 * np.pi * _GOLDEN * n
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)


def _aim(scene: Any, camera: Camera, size_px: int, radius: float, i: int) -> None:
    """Puts both eyes of the scene at the camera, moved by a part of a pixel."""
    near = 0.05 * radius
    half = camera.half * near
    # A little more than one pixel: neighbours share some light, as they do on film.
    width = 1.4 * 2.0 * half / size_px
    right = ((0.5 + i / _PLASTIC) % 1.0 - 0.5) * width
    up = ((0.5 + i / _PLASTIC**2) % 1.0 - 0.5) * width
    for eye in scene.camera:
        eye.pos, eye.forward, eye.up = camera.position, camera.forward, camera.up
        eye.orthographic = 0
        eye.frustum_near, eye.frustum_far = near, 200.0 * radius
        eye.frustum_center, eye.frustum_width = right, half
        eye.frustum_bottom, eye.frustum_top = up - half, up + half


def _light(scene: Any, camera: Camera, i: int, passes: int) -> None:
    """Sets the lights for drawing `i`: the key, some of the dome, and what the floor throws back."""
    facing = math.atan2(-camera.forward[1], -camera.forward[0])
    key, domes, bounces = scene.lights[0], scene.lights[1 : 1 + _DOMES], scene.lights[1 + _DOMES : scene.nlight]
    # Over the photographer's left shoulder, within a soft box of about 12 degrees.
    spread = 0.21 * math.sqrt((i + 0.5) / passes)
    turn = 2.0 * math.pi * _GOLDEN * i
    _set(key, facing - 0.75 + spread * math.cos(turn), 0.80 + spread * math.sin(turn), _KEY, _KEY_SHINE)
    key.ambient = [_AMBIENT] * 3
    for n, light in enumerate(domes, start=i * _DOMES):
        # A Fibonacci lattice on the dome; no lower than 8 degrees, where shadows would leave the map.
        rise = math.asin(0.14 + 0.86 * ((n + 0.5) / (passes * _DOMES)))
        around = 2.0 * math.pi * _GOLDEN * n
        _set(light, facing + around, rise, _SKY / _DOMES, _SKY_SHINE / _DOMES * _panel(around))
    for n, light in enumerate(bounces, start=i * _BOUNCES):
        around = 2.0 * math.pi * _GOLDEN * n
        rise = -0.05 - 0.95 * ((n / _PLASTIC) % 1.0)
        _set(light, facing + around, rise, _BOUNCE / _BOUNCES, _BOUNCE_SHINE / _BOUNCES * _panel(around))


def _panel(around: float) -> float:
    """Brightness of the room at an angle (rad) from the camera: two panels, left and right, for metal to reflect."""
    off = abs((around + math.pi) % (2.0 * math.pi) - math.pi)
    return 0.2 + 1.8 * max(0.0, math.cos(2.0 * (off - 1.35))) ** 2


def _set(light: Any, azimuth: float, elevation: float, diffuse: float, specular: float) -> None:
    """Light that comes from there (rad, world frame), as fractions of white."""
    flat = math.cos(elevation)
    light.dir = [-flat * math.cos(azimuth), -flat * math.sin(azimuth), -math.sin(elevation)]
    light.ambient, light.diffuse, light.specular = [0.0] * 3, [diffuse] * 3, [specular] * 3


def _paper(canvas: renderer.Canvas, floor: int) -> Mask:
    """(size_px, size_px) where nothing but floor is seen, clear of the thing's edges."""
    for flag in (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR):
        canvas.scene.flags[flag] = 1
    number = next(g.segid + 1 for g in canvas.scene.geoms[: canvas.scene.ngeom] if g.objid == floor)
    ids = canvas.draw().astype(np.int32) @ np.array([1, 256, 65536])
    alone = Image.fromarray(np.where(ids == number, 255, 0).astype(np.uint8))
    return np.asarray(alone.filter(ImageFilter.MinFilter(5))) > 0
