"""Kinds of procedural texture, by name."""

from __future__ import annotations

from casa_assets.textures.kind import TextureKind
from casa_assets.textures.kinds import cabinets, counters, floors, walls

KINDS: dict[str, TextureKind] = {k.name: k for group in (walls, floors, counters, cabinets) for k in group.KINDS}
