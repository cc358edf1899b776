"""Choose a backend of OpenGL that draws without a screen, and open its context; mujoco is imported to open it alone."""

from __future__ import annotations

import errno
import importlib
import os
import sys
from functools import lru_cache
from typing import Any

from casa_assets.errors import CasaError

# In this order: EGL uses a GPU where there is one and Mesa's software renderer elsewhere.
BACKENDS = ("egl", "osmesa")
SYSTEM_PACKAGES = "libegl1 libgl1 libgl1-mesa-dri"
LIBRARIES = {"egl": "libegl1", "osmesa": "libosmesa6"}
# The variable by which a user chooses a backend, and that to which the command line moves it.
MUJOCO_GL, CASA_GL = "MUJOCO_GL", "CASA_ASSETS_GL"

# Raised where a backend is imported or opened and its library is missing or finds no device.
_FAILURES = (ImportError, AttributeError, OSError, RuntimeError, TypeError)
# The process that opened a context; a forked child finds its parent's number here.
_opened: list[int] = []


def keep_from_mujoco() -> None:
    """Let this process and its workers import mujoco whatever backend is chosen.

    Importing mujoco opens the library of the backend that MUJOCO_GL names and fails if it is missing, even for what
    draws nothing. The choice is kept in another variable, and the renderer reports what is missing.
    """
    if chosen := os.environ.pop(MUJOCO_GL, ""):
        os.environ[CASA_GL] = chosen


def chosen_backend() -> str:
    """The backend that the user chose; empty for none, or one that needs a screen."""
    wish = os.environ.get(CASA_GL, os.environ.get(MUJOCO_GL, "")).strip().lower()
    return wish if wish in BACKENDS else ""


def install_line(name: str = "") -> str:
    """The command that installs what a backend needs, or any of them, on Debian and Ubuntu."""
    return f"sudo apt-get install -y {LIBRARIES[name] if name == 'osmesa' else SYSTEM_PACKAGES}"


def why_not(name: str, message: str) -> str:
    """Why a backend does not draw; what PyOpenGL raises without its library is about an attribute of None."""
    return f"its library is not installed ({LIBRARIES[name]})" if "NoneType" in message else message


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


def backend() -> str:
    """Name of the backend in use: `egl` or `osmesa`. Raises NoRenderer."""
    return str(context(os.getpid()).backend)


@lru_cache(maxsize=1)
def context(pid: int) -> Any:
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
