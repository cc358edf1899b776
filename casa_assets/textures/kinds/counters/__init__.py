"""Kinds of worktop texture."""

from __future__ import annotations

from casa_assets.textures.kind import TextureKind
from casa_assets.textures.kinds.counters.butcher import END_GRAIN, STAVES
from casa_assets.textures.kinds.counters.flow import BANDED
from casa_assets.textures.kinds.counters.granite import GRANITE
from casa_assets.textures.kinds.counters.laid import GLAZED, PRINTED, TILED
from casa_assets.textures.kinds.counters.metal import METAL
from casa_assets.textures.kinds.counters.speckled import MADE
from casa_assets.textures.kinds.counters.veined import VEINED

KINDS: tuple[TextureKind, ...] = (GRANITE, VEINED, BANDED, MADE, STAVES, END_GRAIN, METAL, TILED, GLAZED, PRINTED)
