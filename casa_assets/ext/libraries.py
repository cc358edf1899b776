"""For exports of assets: entries of a library, its credits, and a folder that is written whole or not at all."""

from __future__ import annotations

from casa_assets import export
from casa_assets.library import attribution
from casa_assets.library.entry import entries
from casa_assets.library.entry_files import write_files
from casa_assets.library.library import Library as LibraryFolder
from casa_assets.runs.outcome import writing

__all__ = [
    "attribution",
    "entries",
    "export",
    "LibraryFolder",
    "write_files",
    "writing",
]
