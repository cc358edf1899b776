"""The project in use, and the folders of registry files: the package's, and the project's merged over it.

A project is a folder with a file `casa.yaml`. Its plans, styles, categories and so on are merged over those of the
package (`registry/layered.py`). It is set by an environment variable, so that all processes of a run use the same one.
This module is imported at the start of every command and by shell completion, so it imports nothing large.
"""

from __future__ import annotations

import os
import shlex
import time
from collections.abc import Callable
from enum import StrEnum
from functools import update_wrapper
from pathlib import Path
from typing import Any, Generic, ParamSpec, TypeVar

from casa_assets.errors import CasaError

SETTINGS = "casa.yaml"
VARIABLE = "CASA_ASSETS_PROJECT"
PLUGINS = "CASA_ASSETS_PLUGINS"  # environment variable, with a value of PluginUse
NO_PROJECT = "none"  # value of the variable, and of --project, that keeps one from being looked for
P = ParamSpec("P")
R = TypeVar("R")


class PluginUse(StrEnum):
    """The plug-ins that run.

    INSTALLED: those of installed packages and of trusted projects. ALL: those of the project in use, too. NONE: no
    plug-ins.
    """

    INSTALLED = "installed"
    ALL = "all"
    NONE = "none"


# When this process started, or the one that it was forked from; of time.time_ns().
STARTED_NS = time.time_ns()
# How often a project was chosen in this process: what was read before may not be what its files hold now.
_chosen = [0]


def data_root() -> Path:
    """Folder of the package's registry.

    `registry_data` inside an installed package, `registry` next to the package in a checkout.
    """
    package = Path(__file__).parent
    inside = package / "registry_data"
    return inside if inside.is_dir() else package.parent / "registry"


def project_folder() -> Path | None:
    """Absolute path of the folder of the project in use, or None without a project."""
    named = os.environ.get(VARIABLE, "")
    return Path(named) if named and named != NO_PROJECT else None


def find_project(below: Path) -> Path | None:
    """Return the nearest folder with a `casa.yaml`, this one or above it, or None if there is no such folder."""
    at = below.absolute()
    return next((folder for folder in (at, *at.parents) if (folder / SETTINGS).is_file()), None)


def use_project(folder: str | Path | None, *, plugins: bool = False) -> None:
    """Make this process, and those that it starts, use a project, or no project. Its files are read again.

    Args:
        folder: folder with a `casa.yaml`; None: no project.
        plugins: run the code in its `plugins/`, which can do whatever you can.
    Raises:
        CasaError: the folder has no `casa.yaml`.
    """
    place = None if folder is None else Path(folder).absolute()
    if place is not None and not (place / SETTINGS).is_file():
        write = f"casa-assets init {shlex.quote(str(folder))}"
        raise CasaError(f"{folder}: is no project, it has no {SETTINGS}; write one with `{write}`")
    os.environ[VARIABLE] = NO_PROJECT if place is None else str(place)
    if plugins:
        choose_plugins(PluginUse.ALL)
    _chosen[0] += 1


def plugin_use() -> PluginUse:
    """Return which plug-ins run."""
    named = os.environ.get(PLUGINS, "")
    return PluginUse(named) if named in set(PluginUse) else PluginUse.INSTALLED


def choose_plugins(use: PluginUse) -> None:
    """Make this process, and those that it starts, run these plug-ins."""
    os.environ[PLUGINS] = use.value
    _chosen[0] += 1


def user_settings() -> Path:
    """Path of the user's configuration, which need not exist: `casa-assets/config.yaml` in XDG_CONFIG_HOME."""
    # As platformdirs does where HOME is not set and the system does not know the user: `~` stays as it is.
    folder = os.environ.get("XDG_CONFIG_HOME", "") or os.path.expanduser("~/.config")  # noqa: PTH111
    return Path(folder) / "casa-assets" / "config.yaml"


def user_environment(program: str) -> Path:
    """Folder in which the user keeps a Python environment for another program, such as `blender`; it need not exist."""
    folder = os.environ.get("XDG_DATA_HOME", "") or os.path.expanduser("~/.local/share")  # noqa: PTH111  never raises
    return Path(folder) / "casa-assets" / program


def layers() -> tuple[Path, ...]:
    """Folders of registry files, the lowest layer first."""
    project = project_folder()
    return (data_root(),) if project is None else (data_root(), project)


class read_once(Generic[P, R]):  # noqa: N801  a decorator
    """Decorator that caches the result of reading registry files until another project is used."""

    def __init__(self, function: Callable[P, R]) -> None:
        update_wrapper(self, function)
        self._function = function
        self._kept: dict[Any, R] = {}
        self._of: tuple[Path | None, int] | None = None

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """Return the cached result for these arguments, calling the function the first time."""
        now = (project_folder(), _chosen[0])
        if now != self._of:
            self._kept, self._of = {}, now
        key = (args, tuple(sorted(kwargs.items())))
        if key not in self._kept:
            self._kept[key] = self._function(*args, **kwargs)
        return self._kept[key]

    def cache_clear(self) -> None:
        """Clear the cache."""
        self._kept.clear()
