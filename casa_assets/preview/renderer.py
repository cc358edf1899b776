"""An OpenGL context without a screen, and MuJoCo models into arrays of pixels."""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

import mujoco
import numpy as np

from casa_assets.errors import CasaError
from casa_assets.preview.darkroom import Pixels

# In this order: EGL uses a GPU where there is one and Mesa's software renderer where there is none.
BACKENDS = ("egl", "osmesa")

# What importing or opening a backend raises where its library is missing or finds no device.
_FAILURES = (ImportError, AttributeError, OSError, RuntimeError, TypeError)


class NoRenderer(CasaError):
    """No way to draw without a screen was found; says what was tried and what to install."""

    def __init__(self, tried: dict[str, str]) -> None:
        self.tried = tried
        reasons = "; ".join(f"{name}: {why}" for name, why in tried.items())
        super().__init__(
            "no OpenGL without a screen is to be had, so no picture can be drawn. On Debian or Ubuntu run "
            f"`apt-get install libegl1 libgl1-mesa-dri` (or libosmesa6), elsewhere install Mesa's EGL. Tried {reasons}"
        )


class Canvas:
    """One compiled model, ready to be drawn again and again at one size.

    Attributes:
        scene: the abstract scene; its lights and cameras may be changed between drawings.
    """

    def __init__(self, model: Any, data: Any, option: Any, width_px: int, height_px: int) -> None:
        self._rect = mujoco.MjrRect(0, 0, width_px, height_px)
        self._pixels = np.empty((height_px, width_px, 3), dtype=np.uint8)
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self.scene = mujoco.MjvScene(model, maxgeom=model.ngeom + 8)
        camera = mujoco.MjvCamera()
        category = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(model, data, option, None, camera, category, self.scene)

    def draw(self) -> Pixels:
        """(height, width, 3) pixels, first row at the top; valid until the next call."""
        mujoco.mjr_render(self._rect, self.scene, self._context)
        mujoco.mjr_readPixels(self._pixels, None, self._rect, self._context)
        return self._pixels[::-1]

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
    made = Canvas(model, data, option, width_px, height_px)
    try:
        yield made
    finally:
        made.close()


def backend() -> str:
    """Name of the backend in use: `egl` or `osmesa`. Raises NoRenderer."""
    return str(type(_context(os.getpid())).__module__.rpartition(".")[2])


@lru_cache(maxsize=1)
def _context(pid: int) -> Any:
    """The process's one context. `pid` is the key: a context does not survive a fork.

    mujoco picks its own backend once, from MUJOCO_GL, while it is imported, which is too early for a process that was
    forked from a server. So its backends are opened here by name and the variable is only read as a wish.
    """
    wish = os.environ.get("MUJOCO_GL", "").strip().lower()
    tried: dict[str, str] = {}
    for name in (wish,) if wish in BACKENDS else BACKENDS:
        try:
            return _open(name)
        except _FAILURES as error:
            tried[name] = f"{type(error).__name__}: {error}".splitlines()[0][:200]
    raise NoRenderer(tried)


def _open(name: str) -> Any:
    """A current context of that backend."""
    before = os.environ.get("PYOPENGL_PLATFORM")
    try:
        make: Callable[[int, int], Any] = importlib.import_module(f"mujoco.{name}").GLContext
        made = make(64, 64)
        made.make_current()
    except _FAILURES:
        # Importing a backend sets the variable, and the next backend refuses to load where it finds another name.
        os.environ.pop("PYOPENGL_PLATFORM", None)
        if before is not None:
            os.environ["PYOPENGL_PLATFORM"] = before
        raise
    return made
