"""Checks, sources, exporters, families and textures that plug-ins add; errors in them are reported as theirs."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, ParamSpec, TypeVar

from casa_assets.checks.check import Check
from casa_assets.checks.table.table import TABLE
from casa_assets.errors import CasaError, PluginFailure
from casa_assets.families.catalog import MODELS
from casa_assets.families.family import Family
from casa_assets.families.kit.assemble import ParametricModel
from casa_assets.families.objects import FORMS
from casa_assets.projects import read_once
from casa_assets.registry.plugins.load import LoadedPlugin, added, load_plugins
from casa_assets.registry.plugins.plugin import Exporter, Source
from casa_assets.textures.canvas import TextureKind
from casa_assets.textures.kinds import KINDS

# Guard ----------------------------------------------------------------------------------------------------------------
# Report errors in the code of a plug-in as errors of that plug-in.

P = ParamSpec("P")
R = TypeVar("R")


def guarded(one: LoadedPlugin, what: str, function: Callable[P, R]) -> Callable[P, R]:
    """The same function, but with its errors raised as PluginFailure; CasaError and MemoryError pass unchanged."""

    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return function(*args, **kwargs)
        except (CasaError, MemoryError):
            raise
        except Exception as error:
            message = f"{what}: {type(error).__name__}: {error}"
            raise PluginFailure(one.plugin.name, message, traceback.format_exc()) from error

    return call


# Checks ---------------------------------------------------------------------------------------------------------------
# Checks that plug-ins add: they are run in addition to those of the package, each on its kind of subject.


@read_once
def check_table() -> tuple[Check, ...]:
    """Every row of the table of checks, those of the package first. Raises CasaError where a code is taken."""
    codes = {row.code for row in TABLE}
    found = list(TABLE)
    for one, row in added("check", lambda plugin: plugin.checks, lambda thing: thing.code, codes):
        found.append(replace(row, function=guarded(one, f"check {row.code}", row.function)))
    return tuple(found)


def with_plugin_limits(limits: Mapping[str, float]) -> Mapping[str, float]:
    """Limits of the registry, and those of the checks of plug-ins that it does not state."""
    return {key: value for one in load_plugins() for key, value in one.plugin.limits.items()} | dict(limits)


def checks_versions() -> dict[str, str]:
    """`plugin:<name>` -> version of the plug-ins whose checks are run, for certificates."""
    return {f"plugin:{one.plugin.name}": one.version for one in load_plugins() if one.plugin.checks}


# Exchange -------------------------------------------------------------------------------------------------------------
# Sources of meshes, and exporters of assets, that plug-ins add.


@read_once
def sources() -> Mapping[str, tuple[LoadedPlugin, Source]]:
    """Sources of meshes by the scheme of their addresses, each with its plug-in."""
    return {source.scheme: (one, source) for one in load_plugins() for source in one.plugin.sources}


@read_once
def exporters() -> Mapping[str, tuple[LoadedPlugin, Exporter]]:
    """Exporters by name, each with its plug-in."""
    return {exporter.name: (one, exporter) for one in load_plugins() for exporter in one.plugin.exporters}


# Families -------------------------------------------------------------------------------------------------------------
# Families and forms of objects that plug-ins add.


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


# Textures -------------------------------------------------------------------------------------------------------------
# Kinds of textures that plug-ins add.


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
