"""Find the Blender that is installed."""

from __future__ import annotations

from casa_assets.core import blender
from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes


def blender_program(name: str) -> str:
    """Path of a Blender, or of a Python with bpy: see `core.blender`.

    Raises:
        Rejected: NEEDS_BLENDER where there is none; `name` is that of the file.
    """
    program = blender.find_blender()
    if not program:
        said = f"{name}: a Blender file is read by Blender, {blender.how_to_install()}"
        raise Rejected(codes.NEEDS_BLENDER, said)
    return program
