"""Checks of the written files, and their subject: an asset together with the folder that it was written to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from casa_assets.model.asset.asset import Asset
from casa_assets.model.registry.category import Category
from casa_assets.model.registry.contract import Contract


@dataclass(frozen=True)
class Package:
    """A written asset.

    Attributes:
        asset: what the writers were given.
        category: its category in the registry.
        root: its folder, with `model.xml`, `scene.xml`, the USD file at `usd/<id>.usda`, and `usd/nested/<id>.usda`
            if there are several links.
        contract: what runtimes expect of it, None if the registry has no contract of the name that the asset gives.
    """

    asset: Asset
    category: Category
    root: Path
    contract: Contract | None = None

    @property
    def mjcf(self) -> Path:
        """The model file: one body `object`, no floor, no free joint."""
        return self.root / "model.xml"

    @property
    def scene(self) -> Path:
        """The model on a floor under a light, free to move where its base is free."""
        return self.root / "scene.xml"

    @property
    def usd(self) -> Path:
        """The USD package's root layer."""
        return self.root / "usd" / f"{self.asset.id}.usda"

    @property
    def usd_files(self) -> tuple[Path, ...]:
        """The root layer, and where there are several links the layer that nests their bodies."""
        nested = self.usd.parent / "nested" / self.usd.name
        return (self.usd, nested) if len(self.asset.links) > 1 else (self.usd,)
