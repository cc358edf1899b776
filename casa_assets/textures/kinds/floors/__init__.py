"""What floors are laid with."""

from __future__ import annotations

from casa_assets.textures.kind import Kind

KINDS: tuple[Kind, ...] = ()
