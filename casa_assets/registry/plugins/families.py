"""Families and forms of objects: those of this package, and those that plug-ins add."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from inspect import cleandoc
from types import MappingProxyType
from typing import Any

from casa_assets.asset.assemble import Family
from casa_assets.kitchenware.catalog import GROUPS, LOOKS, MODELS
from casa_assets.kitchenware.objects import FORMS
from casa_assets.projects import read_once
from casa_assets.registry.plugins.load import LoadedPlugin, added, guarded

__all__ = ["FORMS", "GROUPS", "LOOKS", "MODELS", "forms", "plugin_families", "plugin_forms"]


@read_once
def plugin_families() -> Mapping[str, tuple[LoadedPlugin, Family[Any]]]:
    """Families of plug-ins by name, each with its plug-in. Raises CasaError where a name is taken."""
    found: dict[str, tuple[LoadedPlugin, Family[Any]]] = {}
    for one, family in added("family", lambda plugin: plugin.families, lambda thing: thing.name, MODELS):
        what = f"family {family.name}"
        found[family.name] = (
            one,
            replace(
                family,
                sample=family.sample and guarded(one, what, family.sample),
                title=family.title or family.name.replace("_", " ").capitalize(),
                category=family.category or family.name,
                description=family.description or cleandoc(family.params.__doc__ or "").partition("\n\n")[0],
                presets=family.presets or {"default": guarded(one, what, family.params)()},
            ),
        )
    return MappingProxyType(found)


@read_once
def plugin_forms() -> Mapping[str, tuple[LoadedPlugin, Family[Any]]]:
    """Forms of objects of plug-ins by name, each with its plug-in. Raises CasaError where a name is taken."""
    named = added("form", lambda plugin: plugin.forms, lambda thing: thing.name, FORMS)
    return MappingProxyType({form.name: (one, form) for one, form in named})


@read_once
def forms() -> Mapping[str, Family[Any]]:
    """Forms of objects by name, those of the package first."""
    return MappingProxyType({**FORMS, **{name: form for name, (_, form) in plugin_forms().items()}})
