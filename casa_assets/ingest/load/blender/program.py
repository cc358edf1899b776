"""Find the Blender that is installed."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes

# Names the program `blender`, or a Python that has the module bpy.
VARIABLE = "CASA_BLENDER"
_CHECKOUT = Path(__file__).parents[4] / ".venv-blender" / "bin" / "python"
INSTALL = (
    "python3.11 -m venv blender-env && blender-env/bin/pip install bpy && "
    f"export {VARIABLE}=$PWD/blender-env/bin/python"
)


def blender_program(name: str) -> str:
    """Path of a Blender, or of a Python with bpy: as CASA_BLENDER says, of the checkout, or `blender` on the PATH.

    Raises:
        Rejected: NEEDS_BLENDER where there is none.
    """
    named = os.environ.get(VARIABLE, "")
    for path in (named, str(_CHECKOUT), shutil.which("blender") or ""):
        if path and os.access(path, os.X_OK):
            return path
    raise Rejected(codes.NEEDS_BLENDER, f"{name}: a Blender file, which Blender reads; install it: {INSTALL}")
