"""Kinds of texture for cabinet fronts and carcasses."""

from __future__ import annotations

from casa_assets.ext.textures import TextureKind
from casa_assets.kitchenware.textures.cabinets.fronts import PAINTED, PRESSED, VENEER

KINDS: tuple[TextureKind, ...] = (VENEER, PAINTED, PRESSED)
