"""Kinds of procedural texture, by name."""

from __future__ import annotations

from casa_assets.ext.textures import TextureKind
from casa_assets.kitchenware.textures import covering, floors, food, fronts, label, laid, stone, wall_panels

_MODULES = (covering, wall_panels, floors, stone, laid, fronts, food, label)
KINDS: dict[str, TextureKind] = {
    kind.name: kind for module in _MODULES for kind in vars(module).values() if isinstance(kind, TextureKind)
}
