"""Sources and exporters that plug-ins add, and the guard that reports errors in the code of a plug-in as its own."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping
from typing import ParamSpec, TypeVar

from casa_assets.errors import CasaError, PluginFailure
from casa_assets.ext.plugins import Exporter, Source
from casa_assets.projects import read_once
from casa_assets.registry.plugins.load import LoadedPlugin, load_plugins

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


@read_once
def sources() -> Mapping[str, tuple[LoadedPlugin, Source]]:
    """Sources of meshes by the scheme of their addresses, each with its plug-in."""
    return {source.scheme: (one, source) for one in load_plugins() for source in one.plugin.sources}


@read_once
def exporters() -> Mapping[str, tuple[LoadedPlugin, Exporter]]:
    """Exporters by name, each with its plug-in."""
    return {exporter.name: (one, exporter) for one in load_plugins() for exporter in one.plugin.exporters}
