"""Plug-ins: code of others that adds families, forms of objects, checks, kinds of textures, sources and exporters."""

from casa_assets.registry.plugins.load import LoadedPlugin, ignored_files, load_plugins, or_of_ignored
from casa_assets.registry.plugins.plugin import Exporter, Plugin, Source

__all__ = ["Exporter", "LoadedPlugin", "Plugin", "Source", "ignored_files", "load_plugins", "or_of_ignored"]
