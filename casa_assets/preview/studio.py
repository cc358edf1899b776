"""Studio for stills of assets: light floor, soft dome light, and a camera that fits what it shows.

Each picture is the mean of many drawings; see `exposure.py` for the reason.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
from PIL import Image, ImageFilter

from casa_assets.core.typing import Floats, Mask
from casa_assets.preview import renderer, tonemap
from casa_assets.preview.camera import Camera, View
from casa_assets.preview.exposure import (
    GOLDEN,
    CameraFrustum,
    LightRig,
    drawing_ids,
    mean_of_drawings,
    one_group,
    set_extent,
    set_quality,
)
from casa_assets.preview.tonemap import Pixels

# Of the geoms that are drawn.
VISUAL_GROUP = 1
# Grey of the floor, 0..1, and its emission, which softens the shadows on it. Chosen by eye.
_FLOOR_GREY, _FLOOR_EMISSION = 0.66, 0.25
# A large mesh is drawn fewer times: up to this many faces it is drawn the full number of times, and 12 times at least.
_FULL_PASSES_FACES, _MIN_PASSES = 12_000, 12
_FLOOR = "studio__floor"
_CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


def _panel(around: float) -> float:
    """Brightness of the room at an angle (rad) from the camera: two panels, left and right, for metal to reflect."""
    off = abs((around + math.pi) % (2.0 * math.pi) - math.pi)
    return 0.2 + 1.8 * max(0.0, math.cos(2.0 * (off - 1.35))) ** 2


# Chosen by eye: a white mug keeps its shading, a black one its form. Highlights exceed 1 because each direction is lit
# in one drawing only and then shared by all. The key light stands over the left shoulder of the viewer, within a soft
# box of about 12 degrees; the sky begins 8 degrees above the floor.
_RIG = LightRig(
    ambient=0.22,
    key=0.38,
    sky=0.76,
    bounce=0.30,
    key_azimuths=(-0.75,),
    key_elevation=0.80,
    softness=0.21,
    key_shine=0.9,
    sky_shine=lambda around, _: 4.0 / 2 * _panel(around),
    bounce_shine=lambda around, _: 9.0 / 4 * _panel(around),
    sky_lights=2,
    bounce_lights=4,
    sky_rise=(0.14, 0.86),
    bounce_rise=(-0.05, 0.95),
    distance=4.0,
    shadow_reach=2.2,
    sky_follows_viewer=True,
)


def add_studio(spec: Any, size_px: int) -> None:
    """Add the studio (floor, lights, frame buffer size) to an MjSpec, in place of its own lights and cameras."""
    for item in [*spec.lights, *spec.cameras]:
        spec.delete(item)
    set_quality(spec.visual, size_px, size_px, shadow_px=1024)
    material = spec.add_material()
    material.name = "studio__paper"
    material.rgba = [_FLOOR_GREY, _FLOOR_GREY, _FLOOR_GREY, 1.0]
    material.emission = _FLOOR_EMISSION
    material.specular = material.shininess = material.reflectance = 0.0
    floor = spec.worldbody.add_geom()
    floor.name, floor.material, floor.group = _FLOOR, material.name, VISUAL_GROUP
    floor.type, floor.size = mujoco.mjtGeom.mjGEOM_PLANE, [1.0, 1.0, 1.0]
    floor.contype = floor.conaffinity = 0
    for i in range(_RIG.count):
        light = spec.worldbody.add_light()
        light.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
        light.castshadow = i <= _RIG.sky_lights


def place_floor(model: Any, data: Any) -> Floats:
    """Put the floor under the visible vertices and return those: (N, 3), metres, world frame.

    Args:
        model, data: a model in the studio after `mj_forward`.
    """
    floor = int(model.geom(_FLOOR).id)
    points = np.concatenate([_vertices(model, data, g) for g in range(model.ngeom) if g != floor])
    lower, upper = points.min(axis=0), points.max(axis=0)
    radius = _radius(points)
    model.geom_size[floor] = 40.0 * radius
    data.geom_xpos[floor] = [*((lower + upper)[:2] / 2.0), lower[2] - 1e-4 * radius]
    set_extent(model, radius, _RIG)
    return points


def render(model: Any, data: Any, points: Floats, camera: Camera, view: View, both_sides: bool = False) -> Pixels:
    """Render a model that stands on the studio's floor.

    Args:
        model, data: as `place_floor` left them.
        points: (N, 3) metres, world frame, from `place_floor`.
        camera: fitted to the points.
        view: size and number of drawings.
        both_sides: shows faces from behind too.
    Returns:
        (size_px, size_px, 3) uint8.
    Raises:
        NoRenderer: there is no OpenGL.
    """
    center, radius = (points.min(axis=0) + points.max(axis=0)) / 2.0, _radius(points)
    passes = max(
        min(_MIN_PASSES, view.passes), min(view.passes, view.passes * _FULL_PASSES_FACES // max(1, model.nmeshface))
    )
    viewer = math.atan2(-camera.forward[1], -camera.forward[0])
    near = 0.05 * radius
    half = camera.half * near
    lens = CameraFrustum(
        position=camera.position,
        forward=camera.forward,
        up=camera.up,
        near=near,
        far=200.0 * radius,
        half_width=half,
        half_height=half,
        # A little more than one pixel: neighbours share some light, as they do on film.
        jitter=1.4 * 2.0 * half / view.size_px,
    )
    with renderer.canvas(model, data, one_group(VISUAL_GROUP), view.size_px, view.size_px) as canvas:
        canvas.scene.flags[mujoco.mjtRndFlag.mjRND_CULL_FACE] = int(not both_sides)
        exposure = mean_of_drawings(canvas, lens, _RIG, passes, viewer, center, radius)
        background = _background(canvas, int(model.geom(_FLOOR).id))
    return tonemap.tone_map(tonemap.blur_background(exposure, background), background)


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
    z, turn = 1.0 - (2.0 * n + 1.0) / len(n), 2.0 * np.pi * GOLDEN * n
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)


def _background(canvas: renderer.Canvas, floor: int) -> Mask:
    """(size_px, size_px) where nothing but floor is seen, clear of the asset's edges."""
    with drawing_ids(canvas):
        floor_id = next(g.segid + 1 for g in canvas.scene.geoms[: canvas.scene.ngeom] if g.objid == floor)
        ids = canvas.draw().astype(np.int32) @ np.array([1, 256, 65536])
    floor_only = Image.fromarray(np.where(ids == floor_id, 255, 0).astype(np.uint8))
    return np.asarray(floor_only.filter(ImageFilter.MinFilter(5))) > 0
