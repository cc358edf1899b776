"""Kinds of floor texture."""

from __future__ import annotations

from casa_assets.textures.kind import TextureKind
from casa_assets.textures.kinds.floors.encaustic import ENCAUSTIC
from casa_assets.textures.kinds.floors.resilient import RESILIENT
from casa_assets.textures.kinds.floors.stone import CHIPS, GRANITE, LAYERED, MARBLE
from casa_assets.textures.kinds.floors.timber import END_GRAIN, TIMBER

KINDS: tuple[TextureKind, ...] = (TIMBER, END_GRAIN, MARBLE, LAYERED, GRANITE, CHIPS, ENCAUSTIC, RESILIENT)
