"""Copy an entry of one library into the staging folder of another, by hard links where the file system has them."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from pathlib import Path

from casa_assets.errors import OutputError
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_files import PICTURE, file_inside, picture_of


def copy_accepted(folder: Path, certificate: disk.Certificate, library: disk.Library) -> Path:
    """The staged copy of an accepted asset: what its certificate names, and nothing else.

    A file that is copied byte by byte is compared with the digest in the certificate; one that is linked is not read.

    Raises:
        OutputError: a file is missing, damaged, or no regular file inside the entry.
    """
    staged = library.stage(folder.name)
    _copy(folder, staged, {disk.CERTIFICATE: "", **certificate.files})
    return staged


def copy_refused(folder: Path, library: disk.Library) -> Path:
    """The staged copy of a rejected input. Raises OutputError where a file of it is damaged or leads elsewhere."""
    staged = library.stage(folder.name)
    _copy(folder, staged, {disk.REFUSAL: "", **({PICTURE: ""} if picture_of(folder) else {})})
    return staged


def _copy(folder: Path, staged: Path, digests: Mapping[str, str]) -> None:
    """Link or copy files of an entry.

    Args:
        digests: sha256 of the files by their path in the entry; empty where it is not known.
    """
    for name, digest in digests.items():
        source = file_inside(folder, name, folder, "files")
        if source.is_symlink():  # within the entry: it becomes a file
            source = source.resolve()
        target = staged / name
        if "/" in name:
            target.parent.mkdir(parents=True, exist_ok=True)
        try:
            os.link(source, target)
        except OSError:  # another file system, one without hard links, or a file of somebody else
            data = source.read_bytes()
            if digest and hashlib.sha256(data).hexdigest() != digest:
                message = "is not what the certificate says; copy the shard again, or run it again"
                raise OutputError(str(folder / name), message) from None
            target.write_bytes(data)
