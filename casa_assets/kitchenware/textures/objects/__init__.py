"""Kinds of texture of objects: one picture covers a whole surface, from its lower end to its upper one."""

from __future__ import annotations

from casa_assets.ext.textures import TextureKind
from casa_assets.kitchenware.textures.objects.food import SECTION, SKIN
from casa_assets.kitchenware.textures.objects.printed_lines import LABEL

KINDS: tuple[TextureKind, ...] = (SKIN, LABEL, SECTION)
