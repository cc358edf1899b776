"""Kinds of wall texture."""

from __future__ import annotations

from casa_assets.ext.textures import TextureKind
from casa_assets.kitchenware.textures.walls.covering import FOLIAGE, PLASTER, PRINTED, WOVEN
from casa_assets.kitchenware.textures.walls.masonry import CERAMIC, CLAY, STONEWORK
from casa_assets.kitchenware.textures.walls.panels import BOARDS, CONCRETE, TIN

KINDS: tuple[TextureKind, ...] = (PLASTER, PRINTED, FOLIAGE, WOVEN, CERAMIC, CLAY, BOARDS, STONEWORK, CONCRETE, TIN)
