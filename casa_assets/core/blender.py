"""Find an installed Blender: the program, or a Python that has its module bpy."""

from __future__ import annotations

import os
import shlex
import shutil
from pathlib import Path

from casa_assets.projects import user_environment

# Names the program `blender`, or a Python that has the module bpy.
VARIABLE = "CASA_BLENDER"
# Blender as a module conflicts with this package's numpy and is there for one version of Python: it lives by itself.
_MODULE = "bpy==5.0.1"
_CHECKOUT = Path(__file__).parents[2] / ".venv-blender" / "bin" / "python"


def find_blender() -> str:
    """Path of a Blender, or of a Python with bpy; empty if neither is found.

    If CASA_BLENDER is set, only that one. Otherwise the one of the checkout (`.venv-blender`), of the user (see
    `how_to_install`), or `blender` on the PATH.
    """
    named = os.environ.get(VARIABLE, "")
    if named:
        return named if os.access(named, os.X_OK) else ""
    users = str(user_environment("blender") / "bin" / "python")
    for path in (str(_CHECKOUT), users, shutil.which("blender") or ""):
        if path and os.access(path, os.X_OK):
            return path
    return ""


def how_to_install() -> str:
    """Advice to the user if `find_blender` finds no Blender: a clause that follows "Blender, "."""
    named = os.environ.get(VARIABLE, "")
    if named:
        return f"{VARIABLE} names {named!r}, which is no program: correct it, or unset it"
    place = shlex.quote(str(user_environment("blender")))
    return (
        f"which was not found; install it: python3.11 -m venv {place} && {place}/bin/pip install {_MODULE}, "
        f"or name one that you have: export {VARIABLE}=/path/to/blender"
    )


def command(program: str, script: Path, *arguments: str) -> list[str]:
    """Command line that runs a script by `program`, which is a Blender or a Python with bpy."""
    if Path(program).name.lower().startswith("blender"):
        options = ["--background", "--factory-startup", "--disable-autoexec", "--python-exit-code", "1", "--python"]
        return [program, *options, str(script), "--", *arguments]
    return [program, "-I", str(script), *arguments]


def environment(folder: Path) -> dict[str, str]:
    """Environment of that process: only the variables that a program needs; its settings and files go into `folder`."""
    kept = {key: os.environ[key] for key in ("PATH", "LANG", "LD_LIBRARY_PATH") if key in os.environ}
    return {**kept, "HOME": str(folder), "TMPDIR": str(folder), "BLENDER_USER_RESOURCES": str(folder / "user")}
