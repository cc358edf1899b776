"""Kinds of procedural texture, by name."""

from __future__ import annotations

from casa_assets.ext.textures import TextureKind
from casa_assets.kitchenware.textures import cabinets, counters, floors, objects, walls

KINDS: dict[str, TextureKind] = {
    k.name: k for group in (walls, floors, counters, cabinets, objects) for k in group.KINDS
}
