"""Studio for stills of assets: light floor, soft dome light, and a camera that is fitted to what it shows.

MuJoCo's classic renderer has hard shadows and no light that walls or a floor throw back. So each picture is the mean of
many drawings, each with the camera moved by less than a pixel (smooth edges), the key light moved within its soft box
(soft shadows) and other directions of the sky lit (dark creases).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from PIL import Image, ImageFilter

from casa_assets.core.numeric import Floats, Mask
from casa_assets.show.stills import pictures, renderer
from casa_assets.show.stills.pictures import Pixels
from casa_assets.show.stills.renderer import GOLDEN, PLASTIC, CameraFrustum, one_group, set_quality

# Of the geoms that are drawn.
VISUAL_GROUP = 1
# Grey of the floor, 0..1, and its emission, which softens the shadows on it. Chosen by eye.
_FLOOR_GREY, _FLOOR_EMISSION = 0.66, 0.25
# A large mesh is drawn fewer times: up to this many faces it is drawn the full number of times, and 12 times at least.
_FULL_PASSES_FACES, _MIN_PASSES = 12_000, 12
_FLOOR = "studio__floor"
_CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
# Brightness of light from everywhere, of the key light, of all lights of the sky and of all from below, as fractions
# of white. Chosen by eye: a white mug keeps its shading, a black one its form. Highlights exceed 1 because each is
# lit in one drawing only and then shared by all.
_AMBIENT, _KEY, _SKY, _BOUNCE = 0.22, 0.38, 0.76, 0.30
_KEY_SHINE, _SKY_SHINE, _BOUNCE_SHINE = 0.9, 4.0 / 2, 9.0 / 4
# The key light is over the left shoulder of the viewer, within a soft box of about 12 degrees: rad.
_KEY_ASIDE, _KEY_ELEVATION, _KEY_SOFTNESS = -0.75, 0.80, 0.21
_SKY_LIGHTS, _BOUNCE_LIGHTS = 2, 4  # numbers of lights in each drawing
# Sine of the angle above the horizon where the sky begins, 8 degrees above the floor, and how far up from there; the
# highest angle that light from below comes from, and how far down from there, rad.
_SKY_RISE, _BOUNCE_RISE = (0.14, 0.86), (-0.05, 0.95)
_DISTANCE, _SHADOW_REACH = 4.0, 2.2  # of the lights, and half the width of the maps of shadows, in radii of the scene


@dataclass(frozen=True)
class View:
    """Direction, size and quality of a picture.

    Attributes:
        azimuth_deg: 0 looks at the front (which faces -y), positive walks round to the thing's right side (+x).
        elevation_deg: at least 12, or the end of the floor comes into sight. size_px: width and height.
        fill: fraction of the frame that the thing spans, in its wider direction. field_of_view_deg: vertical.
        passes: drawings that are averaged; more make softer shadows and smoother edges.
    """

    azimuth_deg: float = 35.0
    elevation_deg: float = 25.0
    size_px: int = 512
    fill: float = 0.80
    field_of_view_deg: float = 22.0
    passes: int = 18


@dataclass(frozen=True)
class Camera:
    """A fitted camera: (3,) metres and unit vectors, world frame; `half`: tangent of half the field of view."""

    position: Floats
    right: Floats
    up: Floats
    forward: Floats
    half: float

    def project(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        """(x, y, depth) of (N, 3) world points: x right and y up in -1..1 within the frame, depth in metres."""
        local = points - self.position
        depth = local @ self.forward
        return local @ self.right / (depth * self.half), local @ self.up / (depth * self.half), depth


def fit(points: Floats, view: View) -> Camera:
    """The camera that sees all (N, 3) points (metres, world frame), centred, as large as `view.fill` allows."""
    azimuth, elevation = math.radians(view.azimuth_deg), math.radians(view.elevation_deg)
    flat = math.cos(elevation)
    forward = np.array([-math.sin(azimuth) * flat, math.cos(azimuth) * flat, -math.sin(elevation)])
    right = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
    up = np.cross(right, forward)
    half = math.tan(math.radians(view.field_of_view_deg) / 2.0)
    slope = half * view.fill
    x, y, z = points @ right, points @ up, points @ forward
    # |x - center| <= slope * (z + distance) for all points is linear in (center, distance): two walls that meet.
    distance = max(float(np.max(v - slope * z) + np.max(-v - slope * z)) / (2.0 * slope) for v in (x, y))
    distance = max(distance, 1e-6 - float(z.min()))
    across, along = (_middle(v, z + distance) for v in (x, y))
    return Camera(right * across + up * along - forward * distance, right, up, forward, half)


def _middle(across: Floats, depth: Floats) -> float:
    """Camera position across its view that puts the outermost points equally far from the frame, metres."""
    center = 0.0
    for _ in range(12):
        seen = (across - center) / depth
        center += float((seen.max() + seen.min()) / 2.0 * depth.mean())
    return center


def _panel(around: float) -> float:
    """Brightness of the room at an angle (rad) from the camera: two panels, left and right, for metal to reflect."""
    off = abs((around + math.pi) % (2.0 * math.pi) - math.pi)
    return 0.2 + 1.8 * max(0.0, math.cos(2.0 * (off - 1.35))) ** 2


def add_studio(spec: Any, size_px: int) -> None:
    """Add the studio (floor, lights, frame buffer size) to an MjSpec, replacing the lights and cameras that it has."""
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
    for i in range(1 + _SKY_LIGHTS + _BOUNCE_LIGHTS):
        light = spec.worldbody.add_light()
        light.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
        light.castshadow = i <= _SKY_LIGHTS


def place_floor(model: Any, data: Any) -> Floats:
    """Put the floor under the visible vertices, after `mj_forward`, and return those: (N, 3), metres, world frame."""
    floor = int(model.geom(_FLOOR).id)
    points = np.concatenate([_vertices(model, data, g) for g in range(model.ngeom) if g != floor])
    lower, upper = points.min(axis=0), points.max(axis=0)
    radius = _radius(points)
    model.geom_size[floor] = 40.0 * radius
    data.geom_xpos[floor] = [*((lower + upper)[:2] / 2.0), lower[2] - 1e-4 * radius]
    model.stat.extent, model.vis.map.shadowclip = radius, _SHADOW_REACH
    return points


def render(model: Any, data: Any, points: Floats, camera: Camera, view: View, both_sides: bool = False) -> Pixels:
    """(size_px, size_px, 3) uint8 of a model that `place_floor` has put on the studio's floor. Raises NoRenderer."""
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
        exposure = _mean_of_drawings(canvas, lens, passes, viewer, center, radius)
        background = _background(canvas, int(model.geom(_FLOOR).id))
    return pictures.tone_map(pictures.blur_background(exposure, background), background)


def _mean_of_drawings(
    canvas: renderer.Canvas, lens: CameraFrustum, passes: int, viewer: float, center: Floats, radius: float
) -> Floats:
    """(H, W, 3) mean of the drawings, 0..1; `viewer`: where the viewer comes from, rad to the left of the x axis."""
    total: Floats = np.zeros(())
    for i in range(passes):
        lens.aim(canvas.scene, i)
        _set_lights(canvas.scene, i, passes, viewer)
        for light in canvas.scene.lights[: canvas.scene.nlight]:
            light.pos = center - np.array(light.dir) * _DISTANCE * radius
        total = total + canvas.draw()
    return np.asarray(total / (255.0 * passes))


def _set_lights(scene: Any, i: int, passes: int, viewer: float) -> None:
    key, sky, bounce = scene.lights[0], scene.lights[1 : 1 + _SKY_LIGHTS], scene.lights[1 + _SKY_LIGHTS : scene.nlight]
    spread, turn = _KEY_SOFTNESS * math.sqrt((i + 0.5) / passes), 2.0 * math.pi * GOLDEN * i
    azimuth = viewer + _KEY_ASIDE + spread * math.cos(turn)
    _set_light(key, azimuth, _KEY_ELEVATION + spread * math.sin(turn), _KEY, _KEY_SHINE, casts=True)
    key.ambient = [_AMBIENT] * 3
    lowest, up = _SKY_RISE
    for n, light in enumerate(sky, start=i * _SKY_LIGHTS):
        # A Fibonacci lattice on the dome; no lower than where shadows would leave the map.
        rise = math.asin(lowest + up * ((n + 0.5) / (passes * _SKY_LIGHTS)))
        around = 2.0 * math.pi * GOLDEN * n
        _set_light(light, viewer + around, rise, _SKY / _SKY_LIGHTS, _SKY_SHINE * _panel(around), casts=True)
    highest, down = _BOUNCE_RISE
    for n, light in enumerate(bounce, start=i * _BOUNCE_LIGHTS):
        around, rise = 2.0 * math.pi * GOLDEN * n, highest - down * ((n / PLASTIC) % 1.0)
        shine = _BOUNCE_SHINE * _panel(around)
        _set_light(light, viewer + around, rise, _BOUNCE / _BOUNCE_LIGHTS, shine, casts=False)


def _set_light(light: Any, azimuth: float, elevation: float, diffuse: float, specular: float, casts: bool) -> None:
    flat = math.cos(elevation)
    light.dir = [-flat * math.cos(azimuth), -flat * math.sin(azimuth), -math.sin(elevation)]
    light.ambient, light.diffuse, light.specular = [0.0] * 3, [diffuse] * 3, [specular] * 3
    light.castshadow = int(casts)


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
    for flag in (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR):
        canvas.scene.flags[flag] = 1  # a drawing shows the number of each thing instead of its colour
    floor_id = next(g.segid + 1 for g in canvas.scene.geoms[: canvas.scene.ngeom] if g.objid == floor)
    ids = canvas.draw().astype(np.int32) @ np.array([1, 256, 65536])
    floor_only = Image.fromarray(np.where(ids == floor_id, 255, 0).astype(np.uint8))
    return np.asarray(floor_only.filter(ImageFilter.MinFilter(5))) > 0
