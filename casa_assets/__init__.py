"""Raw meshes, appliance models and declarative kitchens into simulation-ready MJCF and USD.

import casa_assets
model = casa_assets.load_scene("l_small__coastal", textures={"wall": "brick_red_running"})
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"
__all__ = ["__version__", "load_scene"]

if TYPE_CHECKING:
    from casa_assets.pipeline.scene_loader import load_scene


def __getattr__(name: str) -> Any:
    """What the package offers is imported when it is asked for: the command line starts without numpy."""
    if name == "load_scene":
        from casa_assets.pipeline.scene_loader import load_scene

        return load_scene
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
