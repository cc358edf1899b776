"""The files of a scene beside its `scene.xml`: USD, and the light form; each read once."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Protocol

from pxr import Tf, Usd

from casa_assets.checks.package.usd import Diagnostics
from casa_assets.checks.readers.mujoco_load import Loaded, load_asset_file
from casa_assets.checks.readers.quiet import quiet
from casa_assets.checks.readers.usd_facts import imported
from casa_assets.checks.scene.subject import SceneSubject

USD_FILE, NESTED_FILE, LIGHT_FILE = "scene.usda", "scene_nested.usda", "scene_light.xml"


class PassedLayers(Protocol):
    """Memory of layers of assets that passed SimReady's rules, by a digest of their content."""

    def has(self, digest: str) -> bool:
        """True if a layer of that digest passed."""

    def add(self, digests: Collection[str]) -> None:
        """Remember layers that passed."""


@dataclass(frozen=True, eq=False)
class SceneFiles:
    """Files beside `scene.xml`, each read once; a subject is equal to itself alone.

    Attributes:
        scene_subject: the scene and its `scene.xml`, which the others are held against.
        passed_layers: layers that need not be held against SimReady's rules again; None: each is.
    """

    scene_subject: SceneSubject
    passed_layers: PassedLayers | None = None

    @property
    def usd(self) -> Path:
        """The root layer."""
        return self.scene_subject.root / USD_FILE

    @property
    def nested(self) -> Path:
        """The layer that refers to the root layer and nests the bodies."""
        return self.scene_subject.root / NESTED_FILE

    @property
    def light(self) -> Path:
        """The light form: primitive shapes, without pictures."""
        return self.scene_subject.root / LIGHT_FILE

    @cached_property
    def composed(self) -> tuple[Usd.Stage | None, tuple[str, ...]]:
        """The stage, or None where there is none, and the errors and warnings of USD while it composes."""
        return _composed(self.usd)

    @cached_property
    def composed_nested(self) -> tuple[Usd.Stage | None, tuple[str, ...]]:
        """The same of the layer with nested bodies."""
        return _composed(self.nested)

    @cached_property
    def imported(self) -> Loaded:
        """The stage as MuJoCo's own reader has it."""
        with quiet():
            return imported(self.usd)

    @cached_property
    def imported_nested(self) -> Loaded:
        """The same with nested bodies."""
        with quiet():
            return imported(self.nested)

    @cached_property
    def light_form(self) -> Loaded:
        """The light form compiled, with MuJoCo's warnings."""
        return load_asset_file(self.light)


def _composed(path: Path) -> tuple[Usd.Stage | None, tuple[str, ...]]:
    """The stage of a file, None where there is none, and what USD says while it composes."""
    with quiet():
        diagnostics = Diagnostics()
        try:
            stage = Usd.Stage.Open(str(path)) if path.is_file() else None
        except Tf.ErrorException as error:
            return None, (" ".join(str(error).split()),)
        return stage, tuple(diagnostics.take())
