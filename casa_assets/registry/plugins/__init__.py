"""Plug-ins: code of others that adds families, forms of objects, checks, kinds of textures, sources and exporters."""

from casa_assets.ext.plugins import Exporter, Plugin, Source
from casa_assets.registry.plugins.load import LoadedPlugin, ignored_files, load_plugins, or_of_ignored

__all__ = ["Exporter", "LoadedPlugin", "Plugin", "Source", "ignored_files", "load_plugins", "or_of_ignored"]
