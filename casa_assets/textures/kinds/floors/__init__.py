"""Kinds of floor texture."""

from __future__ import annotations

from casa_assets.textures.canvas import TextureKind
from casa_assets.textures.kinds.floors.soft import END_GRAIN, RESILIENT, TIMBER
from casa_assets.textures.kinds.floors.tiles import CHIPS, ENCAUSTIC, GRANITE, LAYERED, MARBLE

KINDS: tuple[TextureKind, ...] = (TIMBER, END_GRAIN, MARBLE, LAYERED, GRANITE, CHIPS, ENCAUSTIC, RESILIENT)
