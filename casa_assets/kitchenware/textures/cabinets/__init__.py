"""Kinds of texture for cabinet fronts and carcasses."""

from __future__ import annotations

from casa_assets.kitchenware.textures.cabinets.fronts import PAINTED, PRESSED, VENEER
from casa_assets.textures.canvas import TextureKind

KINDS: tuple[TextureKind, ...] = (VENEER, PAINTED, PRESSED)
