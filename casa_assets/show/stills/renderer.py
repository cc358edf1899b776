"""Open an OpenGL context without a screen, and draw MuJoCo models to pixels.

Pictures are means of several drawings, in each of which the camera is moved by less than a pixel.
"""

from __future__ import annotations

import errno
import importlib
import math
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import mujoco
import numpy as np

from casa_assets.core.numeric import Floats, Singles
from casa_assets.errors import CasaError
from casa_assets.show.stills import BACKENDS, MUJOCO_GL, chosen_backend, install_line, why_not
from casa_assets.show.stills.pictures import Pixels

# What importing or opening a backend raises where its library is missing or finds no device.
_FAILURES = (ImportError, AttributeError, OSError, RuntimeError, TypeError)


# The process that opened a context; a forked child finds its parent's number here.
_opened: list[int] = []


class NoRenderer(CasaError):
    """This machine cannot draw without a screen; says what was tried, why it failed and what to install."""

    def __init__(self, tried: dict[str, str]) -> None:
        self.tried = tried
        reasons = "; ".join(f"{name}: {why_not(name, why) if name in BACKENDS else why}" for name, why in tried.items())
        chosen = next(iter(tried)) if len(tried) == 1 and chosen_backend() in tried else ""
        other = f", or leave {MUJOCO_GL}={chosen} out" if chosen else ""
        super().__init__(
            f"no picture can be drawn on this machine ({reasons}); run `{install_line(chosen)}` (Debian, Ubuntu; "
            f"elsewhere install Mesa's EGL){other}. `casa-assets doctor` tests it"
        )

    def __reduce__(self) -> tuple[type, tuple[dict[str, str]]]:
        return (type(self), (self.tried,))


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

    def draw_depth(self, scene: Any, width_px: int, height_px: int) -> Singles:
        """(height, width) depth buffer of a scene, 0 near to 1 far, first row at the bottom."""
        mujoco.mjr_render(mujoco.MjrRect(0, 0, width_px, height_px), scene, self._context)
        return self.read_depth(width_px, height_px)

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
    """A Canvas that is closed at the end.

    Args:
        model, data: MjModel and MjData; the model's `offwidth` and `offheight` hold the size.
        option: MjvOption, which groups are shown.
    Raises:
        NoRenderer: neither EGL nor OSMesa works.
    """
    _context(os.getpid()).make_current()
    try:
        made = Canvas(model, data, option, width_px, height_px)
    except mujoco.FatalError as error:
        # A broken EGL that was tried first stands in the way of OSMesa within the same process.
        raise NoRenderer({backend(): f"{error}; try again with MUJOCO_GL=osmesa in the environment"}) from error
    try:
        yield made
    finally:
        made.close()


def backend() -> str:
    """Name of the backend in use: `egl` or `osmesa`. Raises NoRenderer."""
    return str(_context(os.getpid()).backend)


@lru_cache(maxsize=1)
def _context(pid: int) -> Any:
    """The process's one context; `pid` is the key because a context does not survive a fork.

    mujoco picks its own backend once, from MUJOCO_GL, while it is imported, which is too early for a process that was
    forked from a server. So its backends are opened here by name: the one that the user chose, or the first that works.
    A limit on memory that leaves no room for a driver is no lack of one.
    """
    if _opened:
        # The drivers' locks and threads were copied half: the next call would wait for ever.
        raise NoRenderer(
            {"fork": f"process {_opened[0]} had drawn before it forked; start workers by forkserver or spawn"}
        )
    wish = chosen_backend()
    tried: dict[str, str] = {}
    for name in (wish,) if wish else BACKENDS:
        try:
            made = _open(name)
        except _FAILURES as error:
            if isinstance(error, OSError) and error.errno == errno.ENOMEM:
                raise MemoryError(f"{name} cannot be loaded: no memory is left") from error
            tried[name] = f"{type(error).__name__}: {error}".splitlines()[0][:200]
        else:
            _opened.append(pid)
            return made
    raise NoRenderer(tried)


def _open(name: str) -> Any:
    """A current context of that backend."""
    before = os.environ.get("PYOPENGL_PLATFORM")
    try:
        kind: type = importlib.import_module(f"mujoco.{name}").GLContext
        # It lives as long as the process; mujoco's own clean-up at exit finds half of its modules gone.
        made: Any = type(kind.__name__, (kind,), {"__del__": lambda self: None, "backend": name})(64, 64)
        made.make_current()
    except _FAILURES:
        # PyOpenGL settles on a platform when it is first imported; the next backend needs one that is still open.
        for module in [m for m in sys.modules if m.split(".")[0] == "OpenGL" or m.startswith(f"mujoco.{name}")]:
            del sys.modules[module]
        os.environ.pop("PYOPENGL_PLATFORM", None)
        if before is not None:
            os.environ["PYOPENGL_PLATFORM"] = before
        raise
    return made


# (3,) lower and (3,) upper corner of a box, metres.
Bounds = tuple[Floats, Floats]

# Multiples of GOLDEN, modulo 1, fill a line evenly. Multiples of 1/p and 1/p^2, where p is PLASTIC, are the steps along
# the two sides of a square and fill it evenly. Ref: M. Roberts, the R2 sequence.
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
PLASTIC = 1.32471795724474602596


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
