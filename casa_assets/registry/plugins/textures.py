"""Kinds of textures: those of this package, and those that plug-ins add."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from casa_assets.kitchenware.textures.kinds import KINDS
from casa_assets.projects import read_once
from casa_assets.registry.plugins.load import LoadedPlugin, added, guarded
from casa_assets.textures.canvas import TextureKind

__all__ = ["KINDS", "plugin_kinds", "texture_kinds"]


@read_once
def plugin_kinds() -> Mapping[str, tuple[LoadedPlugin, TextureKind]]:
    """Kinds of plug-ins by name, each with its plug-in. Raises CasaError where a name is taken."""
    found: dict[str, tuple[LoadedPlugin, TextureKind]] = {}
    for one, kind in added("texture kind", lambda plugin: plugin.texture_kinds, lambda thing: thing.name, KINDS):
        found[kind.name] = one, replace(kind, paint=guarded(one, f"texture kind {kind.name}", kind.paint))
    return MappingProxyType(found)


@read_once
def texture_kinds() -> Mapping[str, TextureKind]:
    """Kinds by name, those of the package first."""
    return MappingProxyType({**KINDS, **{name: kind for name, (_, kind) in plugin_kinds().items()}})
