"""Kinds of texture of objects: one picture covers a whole surface, from its lower end to its upper one."""

from __future__ import annotations

from casa_assets.textures.kind import TextureKind
from casa_assets.textures.kinds.objects.label import LABEL
from casa_assets.textures.kinds.objects.section import SECTION
from casa_assets.textures.kinds.objects.skin import SKIN

KINDS: tuple[TextureKind, ...] = (SKIN, LABEL, SECTION)
