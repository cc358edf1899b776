"""The files of a scene beside its `scene.xml`: USD, and the light form; each read once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from pxr import Tf, Usd

from casa_assets.checks.package.usd import Diagnostics
from casa_assets.checks.readers.mujoco_load import Loaded, load_asset_file
from casa_assets.checks.readers.quiet import quiet
from casa_assets.checks.readers.usd_facts import imported
from casa_assets.checks.scene.subject import SceneSubject

USD_FILE, LIGHT_FILE = "scene.usda", "scene_light.xml"


@dataclass(frozen=True, eq=False)
class SceneFiles:
    """Files beside `scene.xml`, each read once; a subject is equal to itself alone.

    Attributes:
        scene_subject: the scene and its `scene.xml`, which the others are held against.
    """

    scene_subject: SceneSubject

    @property
    def usd(self) -> Path:
        """The root layer."""
        return self.scene_subject.root / USD_FILE

    @property
    def light(self) -> Path:
        """The light form: primitive shapes, without pictures."""
        return self.scene_subject.root / LIGHT_FILE

    @cached_property
    def composed(self) -> tuple[Usd.Stage | None, tuple[str, ...]]:
        """The stage, or None where there is none, and the errors and warnings of USD while it composes."""
        with quiet():
            diagnostics = Diagnostics()
            try:
                stage = Usd.Stage.Open(str(self.usd)) if self.usd.is_file() else None
            except Tf.ErrorException as error:
                return None, (" ".join(str(error).split()),)
            return stage, tuple(diagnostics.take())

    @cached_property
    def imported(self) -> Loaded:
        """The stage as MuJoCo's own reader has it."""
        with quiet():
            return imported(self.usd)

    @cached_property
    def light_form(self) -> Loaded:
        """The light form compiled, with MuJoCo's warnings."""
        return load_asset_file(self.light)
