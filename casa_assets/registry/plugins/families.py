"""Families and forms of objects that plug-ins add."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from casa_assets.families.catalog import MODELS
from casa_assets.families.family import Family
from casa_assets.families.kit.assemble import ParametricModel
from casa_assets.families.objects import FORMS
from casa_assets.projects import read_once
from casa_assets.registry.plugins.guard import guarded
from casa_assets.registry.plugins.load import LoadedPlugin, added


@read_once
def plugin_families() -> Mapping[str, tuple[LoadedPlugin, Family[Any]]]:
    """Families of plug-ins by name, each with its plug-in. Raises CasaError where a name is taken."""
    found: dict[str, tuple[LoadedPlugin, Family[Any]]] = {}
    for one, family in added("family", lambda plugin: plugin.families, lambda thing: thing.name, MODELS):
        what = f"family {family.name}"
        build, sample = guarded(one, what, family.build), guarded(one, what, family.sample)
        found[family.name] = one, replace(family, build=build, sample=sample)
    return MappingProxyType(found)


@read_once
def plugin_forms() -> Mapping[str, tuple[LoadedPlugin, ParametricModel[Any]]]:
    """Forms of objects of plug-ins by name, each with its plug-in. Raises CasaError where a name is taken."""
    found: dict[str, tuple[LoadedPlugin, ParametricModel[Any]]] = {}
    for one, form in added("form", lambda plugin: plugin.forms, lambda thing: thing.name, FORMS):
        found[form.name] = one, replace(form, add_parts=guarded(one, f"form {form.name}", form.add_parts))
    return MappingProxyType(found)


@read_once
def forms() -> Mapping[str, ParametricModel[Any]]:
    """Forms of objects by name, those of the package first."""
    return MappingProxyType({**FORMS, **{name: form for name, (_, form) in plugin_forms().items()}})
