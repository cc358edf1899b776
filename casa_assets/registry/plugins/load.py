"""Find, import and guard plug-ins: those of installed packages, and those of a project whose code may run.

A package is installed by the user, which says that its code may run. A project may be somebody else's folder: its
`plugins/*.py` run where the user asks for it (`--plugins`), or has listed the project in their own configuration.
"""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import re
import sys
import traceback
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any, ParamSpec, TypeVar

from casa_assets.errors import CasaError, PluginFailure
from casa_assets.ext.plugins import Exporter, Plugin, Source
from casa_assets.projects import PluginUse, plugin_use, project_folder, read_once, user_settings
from casa_assets.registry.project_files import CODE
from casa_assets.registry.read import read_document

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")

PACKAGE = "casa-assets"
GROUP = "casa_assets.plugins"  # of entry points
OBJECT = "PLUGIN"  # name of the Plugin in a module
TRUSTED = "trusted_projects"  # key of the user's own configuration
# Names of modules of projects in sys.modules begin so.
MODULES = "casa_assets_project_plugins"
STORES = frozenset({"s3", "gs", "gcs", "az", "abfs", "http", "https", "file", "memory", "ftp", "sftp"})
_NAME, _CODE, _SCHEME = (re.compile(text) for text in (r"[a-z][a-z0-9_]*", r"[A-Z]{2,6}\d{3}", r"[a-z][a-z0-9]+"))


@dataclass(frozen=True, eq=False)
class LoadedPlugin:
    """A plug-in that is in use.

    Attributes:
        where: file or distribution that it comes from.
        digest: sha256 of its code: a part of the key of whatever it makes.
    """

    plugin: Plugin
    where: str
    digest: str

    @property
    def version(self) -> str:
        """Its version and the first digits of its digest, as certificates state it."""
        return f"{self.plugin.version} {self.digest[:12]}"


@read_once
def load_plugins() -> tuple[LoadedPlugin, ...]:
    """All plug-ins in use, by name.

    Raises CasaError: one cannot be imported, offers what is no such thing, or a name that is taken.
    """
    if plugin_use() is PluginUse.NONE:
        return ()
    found = [*_installed(), *_of_project()]
    taken: dict[tuple[str, str], str] = {}
    for one in found:
        for kind, name in (("plug-in", one.plugin.name), *_names(one.plugin)):
            if (kind, name) in taken:
                raise _taken(one, kind, name, taken[kind, name])
            taken[kind, name] = one.where
    return tuple(sorted(found, key=lambda one: one.plugin.name))


def _taken(one: LoadedPlugin, kind: str, name: str, owner: str) -> CasaError:
    message = f"a {kind} of that name is there already, of {owner}; give it another name"
    return CasaError(f"{one.where}: {kind} {name!r}: {message}")


def added(
    kind: str, things: Callable[[Plugin], Iterable[T]], name_of: Callable[[T], str], known: Container[str]
) -> Iterator[tuple[LoadedPlugin, T]]:
    """Each thing of a kind that plug-ins add, with its plug-in. Raises CasaError where it has a name of the package."""
    for one in load_plugins():
        for thing in things(one.plugin):
            if name_of(thing) in known:
                raise _taken(one, kind, name_of(thing), PACKAGE)
            yield one, thing


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


def ignored_files() -> tuple[Path, ...]:
    """Modules in `plugins/` of the project in use that do not run, since nobody said that they may."""
    folder = project_folder()
    return () if folder is None or _may_run(folder) else _modules(folder)


def or_of_ignored() -> str:
    """Words behind the names that are known, where one is not: code of the project that does not run may add it."""
    names = ", ".join(path.name for path in ignored_files())
    return f", or what {names} adds, which does not run (--plugins, plugins=True)" if names else ""


def _installed() -> Iterator[LoadedPlugin]:
    for point in sorted(entry_points(group=GROUP), key=lambda point: point.name):
        where = f"{point.dist.name if point.dist else 'a package'}, entry point {point.name}"
        try:
            loaded = point.load()
        except Exception as error:
            raise CasaError(f"{where}: cannot be imported\n{traceback.format_exc(limit=-3)}") from error
        plugin = getattr(loaded, OBJECT, None) if isinstance(loaded, ModuleType) else loaded
        module = sys.modules[point.value.partition(":")[0]]
        yield LoadedPlugin(_checked(plugin, where), where, _digest(_package_files(module)))


def _package_files(module: ModuleType) -> list[Path]:
    """Python files of the package of a module: all below its own folder, or the file alone where it is no package."""
    source = Path(inspect.getfile(module))
    return sorted(source.parent.rglob("*.py")) if source.name == "__init__.py" or module.__package__ else [source]


def _of_project() -> Iterator[LoadedPlugin]:
    folder = project_folder()
    if folder is None or not _may_run(folder):
        return
    # A module may import those beside it; so all of them count.
    digest = _digest(sorted((folder / CODE).rglob("*.py")))
    for path in _modules(folder):
        module = _imported(path, digest)
        if hasattr(module, OBJECT):
            yield LoadedPlugin(_checked(getattr(module, OBJECT), str(path)), str(path), digest)


def _modules(project: Path) -> tuple[Path, ...]:
    return tuple(sorted((project / CODE).glob("*.py")))


def _may_run(project: Path) -> bool:
    """True where the user said so, or has listed the project. Raises RegistryError where the configuration is wrong."""
    path, all_run = user_settings(), plugin_use() is PluginUse.ALL
    if all_run or not path.is_file():
        return all_run
    document = read_document(path, str(path))
    listed = document.value.get(TRUSTED, []) if isinstance(document.value, dict) else None
    if not isinstance(listed, list) or not all(isinstance(one, str) for one in listed):
        raise document.fault((TRUSTED,), "a list of folders", repr(document.value))
    return project.resolve() in [Path(one).expanduser().resolve() for one in listed]


def _imported(path: Path, digest: str) -> ModuleType:
    """The module in a file, under a unique name; it can import modules in the same folder by their names."""
    name = f"{MODULES}_{digest[:12]}_{path.stem}"
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    sys.path.insert(0, str(path.parent))
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise CasaError(f"{path}: cannot be imported\n{traceback.format_exc(limit=-3)}") from error
    finally:
        sys.path.remove(str(path.parent))
    return module


def _digest(paths: Sequence[Path]) -> str:
    digest = hashlib.sha256()
    for path in paths:
        digest.update(path.name.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def _checked(plugin: Any, where: str) -> Plugin:
    """A plug-in whose parts are what they should be. Raises CasaError."""
    if not isinstance(plugin, Plugin):
        raise CasaError(f"{where}: {OBJECT} is no casa_assets.Plugin but {type(plugin).__name__}")
    for kind, things, expected in (("source", plugin.sources, Source), ("exporter", plugin.exporters, Exporter)):
        for thing in (one for one in things if not isinstance(one, expected)):
            raise CasaError(f"{where}: {kind} {thing!r} lacks what casa_assets.ext.plugins asks of it")
    for kind, name in (("plug-in", plugin.name), *_names(plugin)):
        pattern = {"check": _CODE, "source": _SCHEME}.get(kind, _NAME)
        if not pattern.fullmatch(str(name)) or (kind == "source" and name in STORES):
            raise CasaError(f"{where}: {kind} {name!r}: expected a name as {pattern.pattern}, and none of a store")
    return plugin


def _names(plugin: Plugin) -> list[tuple[str, str]]:
    found = [("family", one.name) for one in plugin.families]
    found += [("form", one.name) for one in plugin.forms]
    found += [("check", one.code) for one in plugin.checks]
    found += [("texture kind", one.name) for one in plugin.texture_kinds]
    found += [("source", one.scheme) for one in plugin.sources]
    return found + [("exporter", one.name) for one in plugin.exporters]
