"""Kinds of texture for cabinet fronts and carcasses."""

from __future__ import annotations

from casa_assets.textures.kind import TextureKind
from casa_assets.textures.kinds.cabinets.board import PRESSED
from casa_assets.textures.kinds.cabinets.painted import PAINTED
from casa_assets.textures.kinds.cabinets.veneer import VENEER

KINDS: tuple[TextureKind, ...] = (VENEER, PAINTED, PRESSED)
