"""Plug-ins: code of others that adds families, forms of objects, checks, kinds of textures, sources and exporters.

The content of this package, `casa_assets.kitchenware`, comes in by the same doors: no module outside this folder
imports it, and its records and functions are those that `casa_assets.ext` gives to every plug-in.
"""

from casa_assets.ext.plugins import Exporter, Plugin, Source
from casa_assets.registry.plugins.load import LoadedPlugin, ignored_files, load_plugins, or_of_ignored

# The package that the content of this program is below.
CONTENT = "casa_assets.kitchenware"

__all__ = ["CONTENT", "Exporter", "LoadedPlugin", "Plugin", "Source", "ignored_files", "load_plugins", "or_of_ignored"]
