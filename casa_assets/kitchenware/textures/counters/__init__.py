"""Kinds of worktop texture."""

from __future__ import annotations

from casa_assets.ext.textures import TextureKind
from casa_assets.kitchenware.textures.counters.laid import END_GRAIN, GLAZED, METAL, PRINTED, STAVES, TILED
from casa_assets.kitchenware.textures.counters.stone import BANDED, GRANITE, MADE, VEINED

KINDS: tuple[TextureKind, ...] = (GRANITE, VEINED, BANDED, MADE, STAVES, END_GRAIN, METAL, TILED, GLAZED, PRINTED)
