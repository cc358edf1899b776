"""Find the Blender that is installed: the program, or a Python that has its module bpy."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

# Names the program `blender`, or a Python that has the module bpy.
VARIABLE = "CASA_BLENDER"
# Blender as a module conflicts with this package's numpy and is there for one version of Python: it lives by itself.
_PLACE = "~/.local/share/casa-assets/blender"
INSTALL = f"python3.11 -m venv {_PLACE} && {_PLACE}/bin/pip install bpy==5.0.1"
_CHECKOUT = Path(__file__).parents[2] / ".venv-blender" / "bin" / "python"


def find_blender() -> str:
    """Path of a Blender, or of a Python with bpy; empty where there is none.

    As CASA_BLENDER says, of the checkout (`.venv-blender`), of the user (see INSTALL), or `blender` on the PATH.
    """
    named = os.environ.get(VARIABLE, "")
    home = os.environ.get("XDG_DATA_HOME", "") or str(Path.home() / ".local" / "share")
    users = str(Path(home) / "casa-assets" / "blender" / "bin" / "python")
    for path in (named, str(_CHECKOUT), users, shutil.which("blender") or ""):
        if path and os.access(path, os.X_OK):
            return path
    return ""


def command(program: str, script: Path, *arguments: str) -> list[str]:
    """Command line that runs a script by `program`, which is a Blender or a Python with bpy."""
    if Path(program).name.lower().startswith("blender"):
        options = ["--background", "--factory-startup", "--disable-autoexec", "--python-exit-code", "1", "--python"]
        return [program, *options, str(script), "--", *arguments]
    return [program, "-I", str(script), *arguments]


def environment(folder: Path) -> dict[str, str]:
    """Environment of that process: nothing of the user's but what a program needs; what it keeps goes into `folder`."""
    kept = {key: os.environ[key] for key in ("PATH", "LANG", "LD_LIBRARY_PATH") if key in os.environ}
    return {**kept, "HOME": str(folder), "TMPDIR": str(folder), "BLENDER_USER_RESOURCES": str(folder / "user")}
