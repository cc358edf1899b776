"""A subject in MuJoCo's own viewer."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from casa_assets.errors import CasaError
from casa_assets.export.mjcf import document
from casa_assets.export.mjcf.scene import kitchen as mjcf
from casa_assets.model.files import Files
from casa_assets.pipeline.kitchens.load_scene import model_of
from casa_assets.pipeline.kitchens.scene_files import SHARED
from casa_assets.pipeline.kitchens.scene_folders import is_current
from casa_assets.pipeline.library.entry_files import checked_model
from casa_assets.pipeline.view.model import Tell, asset_of, scene_of
from casa_assets.pipeline.view.subject import AssetFolder, Kitchen, ModelFile, Subject


def mujoco_model(subject: Subject, cache: Path, tell: Tell) -> Any:
    """A compiled model of what is to be shown; assets come on a floor.

    Args:
        cache: folder of the store of built assets. tell: is told how far it is.
    Raises:
        CasaError: it cannot be built or read.
    """
    source = _source(subject, cache, tell)
    tell("loading", 0, 0)
    try:
        return model_of(source)
    except ValueError as error:
        raise CasaError(f"{subject.id}: MuJoCo cannot read it: {error}".replace("\n", " ")) from error


def _source(subject: Subject, cache: Path, tell: Tell) -> Path | Files:
    """The file on the disk, or files in memory."""
    if isinstance(subject, ModelFile):
        return subject.path
    if isinstance(subject, AssetFolder):
        on_floor = subject.folder / mjcf.FILE
        return checked_model(on_floor if on_floor.is_file() else subject.folder / "model.xml")
    if isinstance(subject, Kitchen):
        file = subject.folder / mjcf.FILE
        if file.is_file() and (subject.is_named_by_path or is_current(subject.recipe, subject.place)):
            return file
        return mjcf.write(scene_of(subject, cache, tell)[1], shared=SHARED)
    return document.write(asset_of(subject, cache))
