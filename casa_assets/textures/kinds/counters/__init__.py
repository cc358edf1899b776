"""Kinds of worktop texture."""

from __future__ import annotations

from casa_assets.textures.canvas import TextureKind
from casa_assets.textures.kinds.counters.laid import END_GRAIN, GLAZED, METAL, PRINTED, STAVES, TILED
from casa_assets.textures.kinds.counters.stone import BANDED, GRANITE, MADE, VEINED

KINDS: tuple[TextureKind, ...] = (GRANITE, VEINED, BANDED, MADE, STAVES, END_GRAIN, METAL, TILED, GLAZED, PRINTED)
