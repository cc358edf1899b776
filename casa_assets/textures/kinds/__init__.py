"""Every kind of surface by name."""

from __future__ import annotations

from casa_assets.textures.kind import Kind
from casa_assets.textures.kinds import cabinets, counters, floors, walls

KINDS: dict[str, Kind] = {k.name: k for group in (walls, floors, counters, cabinets) for k in group.KINDS}
