"""Kinds of procedural texture, by name."""

from __future__ import annotations

from casa_assets.textures.canvas import TextureKind
from casa_assets.textures.kinds import cabinets, counters, floors, objects, walls

KINDS: dict[str, TextureKind] = {
    k.name: k for group in (walls, floors, counters, cabinets, objects) for k in group.KINDS
}
