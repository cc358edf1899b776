"""Kinds of wall texture."""

from __future__ import annotations

from casa_assets.textures.kind import TextureKind
from casa_assets.textures.kinds.walls.boards import BOARDS
from casa_assets.textures.kinds.walls.cast import CONCRETE, TIN
from casa_assets.textures.kinds.walls.ceramic import CERAMIC
from casa_assets.textures.kinds.walls.clay import CLAY
from casa_assets.textures.kinds.walls.paper import FOLIAGE, PRINTED, WOVEN
from casa_assets.textures.kinds.walls.plaster import PLASTER
from casa_assets.textures.kinds.walls.stonework import STONEWORK

KINDS: tuple[TextureKind, ...] = (PLASTER, PRINTED, FOLIAGE, WOVEN, CERAMIC, CLAY, BOARDS, STONEWORK, CONCRETE, TIN)
