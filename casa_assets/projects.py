"""The project in use, and the folders of registry files: the package's, and the project's merged over it.

A project is a folder with a file `casa.yaml`. Its plans, styles, categories and so on are merged over those of the
package (`registry/read.py`). Environment variables name that of a process, and worker processes are started with
them; `enter` sets another one for a block of code, so that a program can work with several.
This module is imported at the start of every command and by shell completion, so it imports nothing large.
"""

from __future__ import annotations

import os
import shlex
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
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


@dataclass(frozen=True)
class ProjectUse:
    """A project, or None, and the plug-ins that run with it."""

    folder: Path | None
    plugins: PluginUse


# When this process started, or the one that it was forked from; of time.time_ns().
STARTED_NS = time.time_ns()
# Entered and not left, the last is in use; none: what the environment variables say.
_entered: ContextVar[tuple[ProjectUse, ...]] = ContextVar("projects_in_use", default=())
# How often files were said to have changed in this process; see `read_again`.
_readings = [0]
# Projects whose files `read_once` keeps. A choice: programs switch between a few.
KEPT_PROJECTS = 4


def data_root() -> Path:
    """Folder of the package's registry.

    `registry_data` inside an installed package, `registry` next to the package in a checkout.
    """
    package = Path(__file__).parent
    inside = package / "registry_data"
    return inside if inside.is_dir() else package.parent / "registry"


def in_use() -> ProjectUse:
    """Return the project and the plug-ins in use: those of the innermost `using`, or else of the process."""
    if entered := _entered.get():
        return entered[-1]
    named, plugins = os.environ.get(VARIABLE, ""), os.environ.get(PLUGINS, "")
    return ProjectUse(
        Path(named) if named and named != NO_PROJECT else None,
        PluginUse(plugins) if plugins in set(PluginUse) else PluginUse.INSTALLED,
    )


def enter(use: ProjectUse) -> None:
    """Use a project from now on, until `leave`; threads that are started meanwhile have to enter it themselves."""
    _entered.set((*_entered.get(), use))


def leave() -> None:
    """Use what was used before the last `enter`."""
    _entered.set(_entered.get()[:-1])


@contextmanager
def using(use: ProjectUse) -> Iterator[None]:
    """Use a project in a block of code."""
    enter(use)
    try:
        yield
    finally:
        leave()


def environment() -> Mapping[str, str]:
    """Environment with which a child process uses the same project and plug-ins."""
    if not _entered.get():
        return os.environ
    use = in_use()
    return {**os.environ, VARIABLE: str(use.folder or NO_PROJECT), PLUGINS: use.plugins.value}


def project_folder() -> Path | None:
    """Absolute path of the folder of the project in use, or None without a project."""
    return in_use().folder


def plugin_use() -> PluginUse:
    """Return which plug-ins run."""
    return in_use().plugins


def find_project(below: Path) -> Path | None:
    """Return the nearest folder with a `casa.yaml`, this one or above it, or None if there is no such folder."""
    at = below.absolute()
    return next((folder for folder in (at, *at.parents) if (folder / SETTINGS).is_file()), None)


def folder_of_project(folder: str | Path) -> Path:
    """Absolute path of the folder of a project. Raises CasaError if it has no `casa.yaml`."""
    place = Path(folder).absolute()
    if not (place / SETTINGS).is_file():
        write = f"casa-assets init {shlex.quote(str(folder))}"
        raise CasaError(f"{folder}: is no project, it has no {SETTINGS}; write one with `{write}`")
    return place


def use_project(folder: str | Path | None) -> None:
    """Make this process, and those that it starts, use a project, or no project. Its files are read again.

    Raises CasaError: the folder has no `casa.yaml`.
    """
    os.environ[VARIABLE] = NO_PROJECT if folder is None else str(folder_of_project(folder))
    read_again()


def choose_plugins(use: PluginUse) -> None:
    """Make this process, and those that it starts, run these plug-ins."""
    os.environ[PLUGINS] = use.value
    read_again()


def read_again() -> None:
    """Have `read_once` read all files again: some of them may have changed."""
    _readings[0] += 1


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
    """Decorator that caches the results of reading registry files, by project."""

    def __init__(self, function: Callable[P, R]) -> None:
        update_wrapper(self, function)
        self._function = function
        self._kept: dict[tuple[ProjectUse, int], dict[Any, R]] = {}

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """Return the cached result for these arguments, calling the function the first time."""
        now = (in_use(), _readings[0])
        kept = self._kept.get(now)
        if kept is None:
            while len(self._kept) >= KEPT_PROJECTS:
                del self._kept[next(iter(self._kept))]
            kept = self._kept[now] = {}
        key = (args, tuple(sorted(kwargs.items())))
        if key not in kept:
            kept[key] = self._function(*args, **kwargs)
        return kept[key]

    def cache_clear(self) -> None:
        """Clear the cache."""
        self._kept.clear()
