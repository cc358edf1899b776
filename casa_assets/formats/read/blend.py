"""A .blend -> RawModel: Blender, where it is installed, turns it into a GLB, which our own reader reads."""

from __future__ import annotations

import json
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path

from casa_assets.core import system
from casa_assets.errors import Rejected
from casa_assets.formats.read import gltf
from casa_assets.formats.read.formats import Format, Reference
from casa_assets.formats.read.text import Notes, printable
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import Bundle, RawModel, Up


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
        # No limit by the clock: a busy machine would change the outcome. The worker pool ends what hangs.
        script = Path(__file__).with_name("blend_convert.py")
        command, around = system.command(program, script, str(folder)), system.environment(folder)
        done = subprocess.run(command, cwd=folder, env=around, capture_output=True, check=False)
        glb, facts_file = folder / "out.glb", folder / "out.json"
        if done.returncode or not facts_file.is_file() or not glb.is_file():
            words = done.stderr.decode("utf-8", "replace").strip().splitlines()[-1:]
            why = printable(words[0], 120) if words else f"it ended with {done.returncode}"
            why = why if done.returncode else "it wrote nothing"
            message = f"{name}: Blender cannot read it ({why}); open it there, export it as GLB"
            raise Rejected(codes.BLENDER_FAILED, message)
        if glb.stat().st_size > limits["input_bytes"]:
            raise Rejected(codes.TOO_LARGE, f"{name}: becomes a GLB of {glb.stat().st_size} bytes; simplify it first")
        data, facts = glb.read_bytes(), json.loads(facts_file.read_text(encoding="utf-8"))
    for pointer, message in facts["notes"]:
        notes.add(codes.FEATURE_IGNORED, pointer, message)
    model = gltf.load(Bundle(main=bundle.main, files={bundle.main: data}), limits, notes)
    return model.replace(metres_per_unit=facts["metres"], up=Up.Z, format=Format.BLEND.value)


def _program(name: str) -> str:
    """Path of a Blender, or of a Python with bpy: see `core.system.find_blender`. Raises Rejected NEEDS_BLENDER."""
    program = system.find_blender()
    if not program:
        message = f"{name}: a Blender file is read by Blender, {system.how_to_install()}"
        raise Rejected(codes.NEEDS_BLENDER, message)
    return program
