"""Kinds of procedural texture, by name."""

from __future__ import annotations

from casa_assets.kitchenware.textures import cabinets, counters, floors, objects, walls
from casa_assets.textures.canvas import TextureKind

KINDS: dict[str, TextureKind] = {
    k.name: k for group in (walls, floors, counters, cabinets, objects) for k in group.KINDS
}
