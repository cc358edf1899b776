"""The accepted assets of a library as comparing needs them: read from their JSON alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from casa_assets.model.signature import Signature
from casa_assets.pipeline import library as disk


@dataclass(frozen=True)
class Row:
    """One accepted asset.

    Attributes:
        id, category: of the asset. folder: where it stands. path: of its source.
        digest: of the asset with its meshes and pictures. longest: side of the box around it, metres.
        signature: None where it has none.
    """

    id: str
    category: str
    folder: Path
    path: str
    digest: str
    longest: float
    signature: Signature | None


def rows(library: disk.Library) -> Iterator[Row]:
    """Every accepted asset, sorted by category and id. Raises OutputError where one is damaged."""
    for folder in library.accepted():
        yield row(folder)


def row(folder: Path) -> Row:
    """The asset that stands in a folder. Raises OutputError where it is damaged."""
    certificate = disk.read_certificate(folder)
    asset = disk.part(folder, "asset")
    path = str(asset.get("provenance", {}).get("path", ""))
    longest = max(certificate.summary.extents)
    return Row(folder.name, folder.parent.name, folder, path, certificate.asset_digest, longest, certificate.signature)
