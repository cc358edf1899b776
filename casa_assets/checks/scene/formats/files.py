"""The files of a written scene in their other forms: USD, and MJCF of light weight; each read once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from pxr import Tf, Usd

from casa_assets.checks.package.usd import Complaints
from casa_assets.checks.readers.mujoco_load import Loaded, load_asset_file
from casa_assets.checks.readers.quiet import quiet
from casa_assets.checks.readers.usd_facts import imported
from casa_assets.checks.scene.subject import SceneSubject

USD_FILE, LIGHT_FILE = "scene.usda", "scene_light.xml"


@dataclass(frozen=True, eq=False)
class SceneFiles:
    """Files beside `scene.xml`, each read once; a subject is equal to itself alone.

    Attributes:
        kitchen: the scene and its `scene.xml`, which the others are held against.
    """

    kitchen: SceneSubject

    @property
    def usd(self) -> Path:
        """The root layer."""
        return self.kitchen.root / USD_FILE

    @property
    def light(self) -> Path:
        """The scene of primitive shapes, without pictures."""
        return self.kitchen.root / LIGHT_FILE

    @cached_property
    def composed(self) -> tuple[Usd.Stage | None, tuple[str, ...]]:
        """The stage, or None where there is none, and what USD complains of while it composes."""
        with quiet():
            delegate = Complaints()
            try:
                stage = Usd.Stage.Open(str(self.usd)) if self.usd.is_file() else None
            except Tf.ErrorException as error:
                return None, (" ".join(str(error).split()),)
            return stage, tuple(delegate.take())

    @cached_property
    def imported(self) -> Loaded:
        """The stage as MuJoCo's own reader has it."""
        with quiet():
            return imported(self.usd)

    @cached_property
    def lightened(self) -> Loaded:
        """The scene of light weight, and what MuJoCo says of it."""
        return load_asset_file(self.light)
