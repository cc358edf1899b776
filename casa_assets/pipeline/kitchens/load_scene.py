"""Files of a scene, on disk or in memory, into MuJoCo."""

from __future__ import annotations

from pathlib import Path

import mujoco

from casa_assets.export.mjcf.scene.kitchen import FILE
from casa_assets.model.files import Files
from casa_assets.pipeline.kitchens.scene_files import BATCH_FILE, LIGHT_FILE

FILES = {"full": FILE, "light": LIGHT_FILE, "batch": BATCH_FILE}


def model_of(source: Path | Files, sleep: bool = False) -> mujoco.MjModel:
    """A compiled model of a scene file, or of the files of a scene in memory, in which `scene.xml` names the others.

    Args:
        sleep: let MuJoCo leave out what is at rest until something moves it, which is some times as fast. It is never
            in the files: MuJoCo 3.3 does not know it.
    """
    if isinstance(source, Path):
        model = mujoco.MjModel.from_xml_path(str(source))
    else:
        model = mujoco.MjModel.from_xml_string(*_in_memory(source))
    model.opt.enableflags |= _flags(sleep)
    return model


def spec_of(source: Path | Files, sleep: bool = False) -> mujoco.MjSpec:
    """An MjSpec of the scene that is not compiled yet, to add a robot and objects to."""
    if isinstance(source, Path):
        spec = mujoco.MjSpec.from_file(str(source))
    else:
        text, rest = _in_memory(source)
        spec = mujoco.MjSpec.from_string(text, assets=rest)
    spec.option.enableflags |= _flags(sleep)
    return spec


def _in_memory(files: Files) -> tuple[str, dict[str, bytes]]:
    return files.entries[FILE].decode(), {path: data for path, data in files.entries.items() if path != FILE}


def _flags(sleep: bool) -> int:
    return int(mujoco.mjtEnableBit.mjENBL_SLEEP) if sleep else 0
