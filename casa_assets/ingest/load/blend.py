"""A .blend -> RawModel: Blender, where it is installed, turns it into a GLB, which our own reader reads."""

from __future__ import annotations

import json
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path

from casa_assets.core import system
from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load import gltf
from casa_assets.ingest.load.formats import Format, Reference
from casa_assets.ingest.load.text import Notes, printable
from casa_assets.model.source import Bundle, RawModel, Up

_SCRIPT = Path(__file__).with_name("blend_convert.py")


def references(data: bytes, name: str) -> list[Reference]:
    """No references: other files that a Blender file refers to are left out.

    Raises:
        Rejected: NEEDS_BLENDER if there is no Blender.
    """
    _program(name)
    return []


def load(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of a Blender file: its scene as it is shown, modifiers carried out, z up, in its unit of length.

    Blender starts with factory settings, runs no script of the file, and stays within the limits of this process.

    Raises:
        Rejected: NEEDS_BLENDER, BLENDER_FAILED, and what a GLB is refused for.
    """
    name = printable(bundle.main)
    program = _program(name)
    with tempfile.TemporaryDirectory(prefix="casa_blender_") as place:
        folder = Path(place)
        (folder / "in.blend").write_bytes(bundle.files[bundle.main])
        _run(program, folder, name)
        glb, told = folder / "out.glb", folder / "out.json"
        if not told.is_file() or not glb.is_file():
            raise _failed(name, "it wrote nothing")
        if glb.stat().st_size > limits["input_bytes"]:
            raise Rejected(codes.TOO_LARGE, f"{name}: becomes a GLB of {glb.stat().st_size} bytes; simplify it first")
        data, said = glb.read_bytes(), json.loads(told.read_text(encoding="utf-8"))
    for pointer, message in said["notes"]:
        notes.add(codes.FEATURE_IGNORED, pointer, message)
    model = gltf.load(Bundle(main=bundle.main, files={bundle.main: data}), limits, notes)
    return model.replace(metres_per_unit=said["metres"], up=Up.Z, format=Format.BLEND.value)


def _program(name: str) -> str:
    """Path of a Blender, or of a Python with bpy: see `core.blender`. Raises Rejected NEEDS_BLENDER."""
    program = system.find_blender()
    if not program:
        said = f"{name}: a Blender file is read by Blender, {system.how_to_install()}"
        raise Rejected(codes.NEEDS_BLENDER, said)
    return program


def _run(program: str, folder: Path, name: str) -> None:
    """Convert `in.blend` of a folder into `out.glb` and `out.json`. Raises Rejected BLENDER_FAILED."""
    # No limit by the clock: a busy machine would change the outcome. The worker pool ends what hangs.
    command, around = system.command(program, _SCRIPT, str(folder)), system.environment(folder)
    done = subprocess.run(command, cwd=folder, env=around, capture_output=True, check=False)
    if done.returncode:
        words = done.stderr.decode("utf-8", "replace").strip().splitlines()[-1:]
        raise _failed(name, printable(words[0], 120) if words else f"it ended with {done.returncode}")


def _failed(name: str, why: str) -> Rejected:
    return Rejected(codes.BLENDER_FAILED, f"{name}: Blender cannot read it ({why}); open it there, export it as GLB")
