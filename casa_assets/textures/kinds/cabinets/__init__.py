"""Kinds of texture for cabinet fronts and carcasses."""

from __future__ import annotations

from casa_assets.textures.canvas import TextureKind
from casa_assets.textures.kinds.cabinets.fronts import PAINTED, PRESSED, VENEER

KINDS: tuple[TextureKind, ...] = (VENEER, PAINTED, PRESSED)
