"""Pages of kitchens, to which an addon joins its results."""

from __future__ import annotations

from casa_assets.layouts.run.scene_page import join_robots

__all__ = [
    "join_robots",
]
