"""For exports of assets: entries of a library, credits, output folders; pages that results are joined to."""

from __future__ import annotations

from casa_assets import export
from casa_assets.layouts.run.scene_page import join_robots
from casa_assets.library import attribution
from casa_assets.library.entry import entries
from casa_assets.library.entry_files import write_files
from casa_assets.library.library import Library as LibraryFolder
from casa_assets.registry.families import object_names
from casa_assets.runs.outcome import writing

__all__ = [
    "attribution",
    "entries",
    "export",
    "join_robots",
    "LibraryFolder",
    "object_names",
    "write_files",
    "writing",
]
