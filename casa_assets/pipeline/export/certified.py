"""Read an asset of a library for an export: every file as it was when it was checked."""

from __future__ import annotations

from pathlib import Path

from casa_assets.errors import OutputError
from casa_assets.model.asset.asset import Asset
from casa_assets.pipeline.library import library as disk

# What a person does with an asset that an export leaves out.
DECIDE = "accept or correct it in review.csv of the library and run ingest again, or give --with-review"


def why_left_out(folder: Path, with_review: bool) -> str:
    """Why an export leaves out the asset of a folder: what a person has to decide about it; empty where it goes out."""
    subjects = () if with_review else disk.read_certificate(folder).report.to_decide
    return f"is in review for {', '.join(subjects)}; {DECIDE}" if subjects else ""


def certified_asset(folder: Path) -> Asset:
    """The asset of a folder, every file as it was certified. Raises OutputError."""
    certified = disk.read_certificate(folder).files
    try:
        digests = disk.file_digests(folder)
    except OSError as error:
        raise OutputError(str(folder), f"cannot be read: {error.strerror}") from error
    for path in sorted(certified):
        if path not in digests:
            raise OutputError(str(folder / path), "is missing; remove the asset's folder and run ingest again")
        if digests[path] != certified[path]:
            raise OutputError(str(folder / path), "was changed since it was checked; run ingest again without it")
    asset = disk.read_asset(folder)
    if asset.id != folder.name:
        raise OutputError(str(folder / disk.CERTIFICATE), f"holds the asset {asset.id!r}; move it to such a folder")
    return asset
