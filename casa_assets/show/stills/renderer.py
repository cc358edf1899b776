"""Draw MuJoCo models to pixels without a screen.

Pictures are means of several drawings, in each of which the camera is moved by less than a pixel.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from casa_assets.core.numeric import Floats, Singles
from casa_assets.show.stills import opengl
from casa_assets.show.stills.pictures import Pixels

# (3,) lower and (3,) upper corner of a box, metres.
Bounds = tuple[Floats, Floats]
# Multiples of GOLDEN, modulo 1, fill a line evenly. Multiples of 1/p and 1/p^2, where p is PLASTIC, are the steps along
# the two sides of a square and fill it evenly. Ref: M. Roberts, the R2 sequence.
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
PLASTIC = 1.32471795724474602596


class Canvas:
    """One compiled model, ready to be drawn again and again at one size.

    Attributes:
        model: MjModel. scene: the abstract scene; its lights and cameras may be changed between drawings.
    """

    def __init__(self, model: Any, data: Any, option: Any, width_px: int, height_px: int) -> None:
        self.model, self._data, self._size_px = model, data, (width_px, height_px)
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50)
        self.scene = self.new_scene(option)

    def new_scene(self, option: Any) -> Any:
        """Another abstract scene of the same model, which shows what `option` (MjvOption) says."""
        scene = mujoco.MjvScene(self.model, maxgeom=self.model.ngeom + 8)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        category = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(self.model, self._data, option, None, mujoco.MjvCamera(), category, scene)
        return scene

    def draw_scene(self, scene: Any, width_px: int, height_px: int) -> Pixels:
        """(height, width, 3) pixels of a scene, first row at the top. The model's frame buffer holds the size."""
        rect, pixels = mujoco.MjrRect(0, 0, width_px, height_px), np.empty((height_px, width_px, 3), dtype=np.uint8)
        mujoco.mjr_render(rect, scene, self._context)
        mujoco.mjr_readPixels(pixels, None, rect, self._context)
        return pixels[::-1]

    def read_depth(self, width_px: int, height_px: int) -> Singles:
        """(height, width) depth buffer of what was drawn last, 0 near to 1 far, first row at the bottom."""
        depth = np.empty((height_px, width_px), dtype=np.float32)
        mujoco.mjr_readPixels(None, depth, mujoco.MjrRect(0, 0, width_px, height_px), self._context)
        return depth

    def draw(self) -> Pixels:
        """(height, width, 3) pixels, first row at the top."""
        return self.draw_scene(self.scene, *self._size_px)

    def close(self) -> None:
        """Gives the memory of the GPU (or of Mesa) back."""
        self._context.free()


@contextmanager
def canvas(model: Any, data: Any, option: Any, width_px: int, height_px: int) -> Iterator[Canvas]:
    """A Canvas that is closed at the end; the model's `offwidth` and `offheight` hold the size. Raises NoRenderer."""
    opengl.context(os.getpid()).make_current()
    try:
        made = Canvas(model, data, option, width_px, height_px)
    except mujoco.FatalError as error:
        # A broken EGL that was tried first is in the way of OSMesa within the same process.
        raise opengl.NoRenderer(
            {opengl.backend(): f"{error}; try again with MUJOCO_GL=osmesa in the environment"}
        ) from error
    try:
        yield made
    finally:
        made.close()


@dataclass(frozen=True)
class CameraFrustum:
    """Pose and frustum of a camera; lengths in metres, those of the picture on the near plane.

    Attributes:
        position, forward, up: (3,) world frame. near, far: planes between which something is seen.
        jitter: side of the square that the picture is moved within between drawings.
        rise: how far the middle of the picture lies above the axis: a shifted lens.
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
    """Set up `MjSpec.visual` or `MjModel.vis`: the frame buffer's size, the side of shadow maps, no headlight."""
    visual.headlight.active = 0
    visual.global_.offwidth, visual.global_.offheight = width_px, height_px
    visual.quality.offsamples, visual.quality.shadowsize = 0, shadow_px
