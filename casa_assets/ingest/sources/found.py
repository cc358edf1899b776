"""Results of discovery: an input that was found, or one that was refused."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from casa_assets.ingest.sources.places import StoreRoot
from casa_assets.model.issue import Issue
from casa_assets.model.source import Source


@dataclass(frozen=True)
class Found:
    """One input.

    Attributes:
        root: folder that its references may not leave (the package, or the folder that the user named): absolute, or on
            a store.
        main: main file, POSIX, relative to `root`.
        source: what its source says about it; `source.path` is relative to the folder that the user named.
        notes: warnings about what was said of it.
        archive: the archive that holds `main` and all that it refers to, POSIX, relative to `root`; empty: the disk.
            `main` is a path within it then.
        at: where in the archive `main` begins, see containers.archive.Member; -1: to be searched. In a table: the row.
        is_model: `main` is no file of a stranger but the RawModel of a mesh that the caller has in memory, as JSON.
    """

    root: Path | StoreRoot
    main: str
    source: Source
    notes: tuple[Issue, ...] = ()
    is_model: bool = False
    archive: str = ""
    at: int = -1


@dataclass(frozen=True)
class Refused:
    """An entry that is in the place of an input and cannot be used.

    Attributes:
        path: POSIX, relative to the folder that the user named; of a manifest row, the manifest.
        code: of casa_assets.ingest.rejection_codes.
        message: file, line or place, reason, and what to do.
    """

    path: str
    code: str
    message: str
