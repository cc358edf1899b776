"""Sources of meshes, and exporters of assets, that plug-ins add."""

from __future__ import annotations

from collections.abc import Mapping

from casa_assets.projects import read_once
from casa_assets.registry.plugins.load import LoadedPlugin, load_plugins
from casa_assets.registry.plugins.plugin import Exporter, Source


@read_once
def sources() -> Mapping[str, tuple[LoadedPlugin, Source]]:
    """Sources of meshes by the scheme of their addresses, each with its plug-in."""
    return {source.scheme: (one, source) for one in load_plugins() for source in one.plugin.sources}


@read_once
def exporters() -> Mapping[str, tuple[LoadedPlugin, Exporter]]:
    """Exporters by name, each with its plug-in."""
    return {exporter.name: (one, exporter) for one in load_plugins() for exporter in one.plugin.exporters}
