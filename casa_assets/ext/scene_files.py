"""Names of files in the folder of a kitchen."""

from __future__ import annotations

from casa_assets.layouts.run.scene_files import BATCH_FILE, BATCH_JSON, ROBOTS_JSON, SCENE_JSON

__all__ = [
    "BATCH_FILE",
    "BATCH_JSON",
    "ROBOTS_JSON",
    "SCENE_JSON",
]
