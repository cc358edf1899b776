"""Kinds of floor texture."""

from __future__ import annotations

from casa_assets.ext.textures import TextureKind
from casa_assets.kitchenware.textures.floors.soft import END_GRAIN, RESILIENT, TIMBER
from casa_assets.kitchenware.textures.floors.tiles import CHIPS, ENCAUSTIC, GRANITE, LAYERED, MARBLE

KINDS: tuple[TextureKind, ...] = (TIMBER, END_GRAIN, MARBLE, LAYERED, GRANITE, CHIPS, ENCAUSTIC, RESILIENT)
