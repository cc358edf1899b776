"""Average many MuJoCo drawings into one picture with soft shadows and smooth edges.

MuJoCo's classic renderer has hard shadows and no light that walls or a floor throw back. Each drawing has the camera
moved by less than a pixel (smooth edges), the key light moved within its soft box (soft shadows) and other directions
of the sky lit (dark creases). Angles are radians, brightness is a fraction of white.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.preview import renderer

# (3,) lower and (3,) upper corner of a box, metres.
Bounds = tuple[Floats, Floats]

# Multiples of GOLDEN, modulo 1, fill a line evenly. Multiples of 1/p and 1/p^2, where p is PLASTIC, are the steps along
# the two sides of a square and fill it evenly. Ref: M. Roberts, the R2 sequence.
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
PLASTIC = 1.32471795724474602596


@dataclass(frozen=True)
class LightRig:
    """The lights of a drawing: a key light in a soft box, some of the sky, and what floor and walls throw back.

    Attributes:
        ambient: light from everywhere. key, sky, bounce: brightness of each kind, the latter two of all their lights.
        key_azimuths: angles of the key light beside the viewer, one for each drawing in turn.
        key_elevation: angle of the key light above the horizon.
        softness: half the width of its soft box.
        key_shine: brightness of its highlights. sky_shine, bounce_shine: of theirs, from the angle beside the viewer
            and the brightness of one light.
        sky_lights, bounce_lights: numbers of lights of the sky, and from below, in each drawing.
        sky_rise: sine of the angle above the horizon where the sky begins, and how far up from there.
        bounce_rise: highest angle that light from below comes from, and how far down from there.
        distance: how far from the middle of the scene the lights stand, in radii of the scene.
        shadow_reach: half the width of the shadow maps, in radii of the scene.
        sky_follows_viewer: whether the lights of the sky and from below turn with the viewer.
    """

    ambient: float
    key: float
    sky: float
    bounce: float
    key_azimuths: Sequence[float]
    key_elevation: float
    softness: float
    key_shine: float
    sky_shine: Callable[[float, float], float]
    bounce_shine: Callable[[float, float], float]
    sky_lights: int
    bounce_lights: int
    sky_rise: tuple[float, float]
    bounce_rise: tuple[float, float]
    distance: float
    shadow_reach: float
    sky_follows_viewer: bool

    @property
    def count(self) -> int:
        """Number of lights in a drawing."""
        return 1 + self.sky_lights + self.bounce_lights

    def light(self, scene: Any, i: int, passes: int, viewer: float) -> None:
        """Set the lights of an MjvScene for drawing `i` of `passes`.

        Args:
            viewer: direction that the viewer comes from, rad to the left of the x axis.
        """
        lights = scene.lights[: self.count]
        key, sky, bounce = lights[0], lights[1 : 1 + self.sky_lights], lights[1 + self.sky_lights :]
        spread = self.softness * math.sqrt((i + 0.5) / passes)
        turn = 2.0 * math.pi * GOLDEN * i
        azimuth = viewer + self.key_azimuths[i % len(self.key_azimuths)] + spread * math.cos(turn)
        set_light(key, azimuth, self.key_elevation + spread * math.sin(turn), self.key, self.key_shine, casts=True)
        key.ambient = [self.ambient] * 3
        facing = viewer if self.sky_follows_viewer else 0.0
        lowest, up = self.sky_rise
        for n, light in enumerate(sky, start=i * self.sky_lights):
            # A Fibonacci lattice on the dome; no lower than where shadows would leave the map.
            rise = math.asin(lowest + up * ((n + 0.5) / (passes * self.sky_lights)))
            around, diffuse = 2.0 * math.pi * GOLDEN * n, self.sky / self.sky_lights
            set_light(light, facing + around, rise, diffuse, self.sky_shine(around, diffuse), casts=True)
        highest, down = self.bounce_rise
        for n, light in enumerate(bounce, start=i * self.bounce_lights):
            around, diffuse = 2.0 * math.pi * GOLDEN * n, self.bounce / self.bounce_lights
            rise = highest - down * ((n / PLASTIC) % 1.0)
            set_light(light, facing + around, rise, diffuse, self.bounce_shine(around, diffuse), casts=False)


def set_light(light: Any, azimuth: float, elevation: float, diffuse: float, specular: float, casts: bool) -> None:
    """Make an MjvLight come from there, world frame."""
    flat = math.cos(elevation)
    light.dir = [-flat * math.cos(azimuth), -flat * math.sin(azimuth), -math.sin(elevation)]
    light.ambient, light.diffuse, light.specular = [0.0] * 3, [diffuse] * 3, [specular] * 3
    light.castshadow = int(casts)


@dataclass(frozen=True)
class CameraFrustum:
    """Pose and frustum of a camera.

    Attributes:
        position, forward, up: (3,) metres and unit vectors, world frame.
        near, far: planes between which something is seen, metres.
        half_width, half_height: of the picture on the near plane, metres.
        jitter: side of the square that the picture is moved within between drawings, metres on the near plane.
        rise: how far the middle of the picture lies above the axis, metres on the near plane: a shifted lens.
    """

    position: Floats
    forward: Floats
    up: Floats
    near: float
    far: float
    half_width: float
    half_height: float
    jitter: float
    rise: float = 0.0

    def aim(self, scene: Any, i: int) -> None:
        """Put both eyes of an MjvScene there, moved by a part of a pixel for drawing `i`."""
        right = ((0.5 + i / PLASTIC) % 1.0 - 0.5) * self.jitter
        up = ((0.5 + i / PLASTIC**2) % 1.0 - 0.5) * self.jitter + self.rise
        for eye in scene.camera:
            eye.pos, eye.forward, eye.up = self.position, self.forward, self.up
            eye.orthographic = 0
            eye.frustum_near, eye.frustum_far = self.near, self.far
            eye.frustum_center, eye.frustum_width = right, self.half_width
            eye.frustum_bottom, eye.frustum_top = up - self.half_height, up + self.half_height


def one_group(group: int) -> Any:
    """An MjvOption that shows the geoms of one group and nothing else."""
    option = mujoco.MjvOption()
    option.geomgroup[:] = 0
    option.geomgroup[group] = 1
    option.sitegroup[:] = 0
    return option


def set_quality(visual: Any, width_px: int, height_px: int, shadow_px: int) -> None:
    """Set up the frame buffer of `MjSpec.visual` or `MjModel.vis`: its size, no headlight, no multisampling.

    Args:
        shadow_px: side of the shadow map of a light.
    """
    visual.headlight.active = 0
    visual.global_.offwidth, visual.global_.offheight = width_px, height_px
    visual.quality.offsamples, visual.quality.shadowsize = 0, shadow_px


def set_extent(model: Any, radius: float, rig: LightRig) -> None:
    """Fit the shadow maps of an MjModel to a scene of that radius, metres."""
    model.stat.extent, model.vis.map.shadowclip = radius, rig.shadow_reach


def mean_of_drawings(
    canvas: renderer.Canvas,
    lens: CameraFrustum,
    rig: LightRig,
    passes: int,
    viewer: float,
    center: Floats,
    radius: float,
) -> Floats:
    """(H, W, 3) mean of the drawings, 0..1.

    Args:
        passes: number of drawings.
        viewer: direction that the viewer comes from, rad to the left of the x axis.
        center, radius: of the scene, metres; (3,) in the world frame.
    """
    total: Floats = np.zeros(())
    for i in range(passes):
        lens.aim(canvas.scene, i)
        rig.light(canvas.scene, i, passes, viewer)
        for light in canvas.scene.lights[: canvas.scene.nlight]:
            light.pos = center - np.array(light.dir) * rig.distance * radius
        total = total + canvas.draw()
    return np.asarray(total / (255.0 * passes))


@contextmanager
def drawing_ids(canvas: renderer.Canvas) -> Iterator[None]:
    """While it lasts, a drawing shows the number of each thing instead of its colour."""
    flags = (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR)
    for flag in flags:
        canvas.scene.flags[flag] = 1
    try:
        yield
    finally:
        for flag in flags:
            canvas.scene.flags[flag] = 0
