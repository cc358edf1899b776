"""The accepted assets of a library with what a comparison needs, read from their JSON alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from casa_assets.model.asset.signature import Signature
from casa_assets.model.record import Vec3
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.identity import Producer


@dataclass(frozen=True)
class AssetRow:
    """One accepted asset.

    Attributes:
        id, category: of the asset. folder: where it stands. path, sha256: of its source.
        digest: of the asset with its meshes and pictures. extents: of the box around it, metres.
        signature: None where it has none. from_numbers: a family built it.
    """

    id: str
    category: str
    folder: Path
    path: str
    sha256: str
    digest: str
    extents: Vec3
    signature: Signature | None
    from_numbers: bool = False

    @property
    def longest(self) -> float:
        """Longest side of the box around it, metres."""
        return max(self.extents)


def read_rows(library: disk.Library) -> Iterator[AssetRow]:
    """Every accepted asset, sorted by category and id. Raises OutputError where one is damaged."""
    for folder in library.accepted():
        yield read_row(folder)


def read_row(folder: Path) -> AssetRow:
    """The asset that stands in a folder. Raises OutputError where it is damaged."""
    return row_of(disk.read_manifest(folder))


def row_of(manifest: disk.Manifest) -> AssetRow:
    """The asset of a manifest that was read."""
    folder, certificate = manifest.folder, manifest.certificate
    origin = manifest.asset.get("provenance", {})
    return AssetRow(
        id=folder.name,
        category=folder.parent.name,
        folder=folder,
        path=str(origin.get("path", "")),
        sha256=str(origin.get("sha256", "")),
        digest=certificate.asset_digest,
        extents=certificate.summary.extents,
        signature=certificate.signature,
        from_numbers=certificate.producer is Producer.FAMILY,
    )
