"""Pictures of assets and kitchens; here: the backends of OpenGL that draw without a screen."""

from __future__ import annotations

import os

# In this order: EGL uses a GPU where there is one and Mesa's software renderer where there is none.
BACKENDS = ("egl", "osmesa")
SYSTEM_PACKAGES = "libegl1 libgl1 libgl1-mesa-dri"
LIBRARIES = {"egl": "libegl1", "osmesa": "libosmesa6"}
# The variable by which a user chooses a backend, and that to which the command line moves it.
MUJOCO_GL, CASA_GL = "MUJOCO_GL", "CASA_ASSETS_GL"


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
    """Why a backend does not draw, in plain words.

    Args:
        message: what was raised. Where PyOpenGL does not find a library, that is about an attribute of None.
    """
    return f"its library is not installed ({LIBRARIES[name]})" if "NoneType" in message else message
