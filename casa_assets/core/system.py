"""The machine: processes, files, the cache folder, optional packages, an installed Blender."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import json
import math
import os
import re
import resource
import shlex
import shutil
import sys
import tomllib
from contextlib import suppress
from pathlib import Path
from typing import Any

import platformdirs

from casa_assets.errors import CasaError
from casa_assets.projects import user_environment

# Environment variable that the fork server of workers sets for them.
WORKER = "CASA_ASSETS_WORKER"
CACHE_VARIABLE = "CASA_ASSETS_CACHE"
SIZE_VARIABLE = "CASA_ASSETS_CACHE_GB"
# Room for each of the 400 textures (1.2 MB) in four versions, and for 25,000 built assets (40 kB).
DEFAULT_GB = 4.0
# A cache on a disk with less free space is not used. The picture of one texture takes about 1 MB.
MIN_FREE_BYTES = 100_000_000
# Names the program `blender`, or a Python that has the module bpy.
BLENDER_VARIABLE = "CASA_BLENDER"
# Blender as a module conflicts with this package's numpy and is there for one version of Python: it lives by itself.
_MODULE = "bpy==5.0.1"
DISTRIBUTION = "casa-assets"
FOR_DEVELOPERS = "dev"
_SOURCE = Path(__file__).parents[2]
_CHECKOUT = _SOURCE / ".venv-blender" / "bin" / "python"
_EXTRA = re.compile(r""";.*\bextra\s*==\s*["']([\w.-]+)["']""")  # as metadata name the extra of a requirement


def lower_limit(kind: int, soft: int, hard: int) -> None:
    """Lower a resource limit of this process, such as `resource.RLIMIT_AS` (bytes); a lower one is kept."""
    now = resource.getrlimit(kind)[1]
    ceiling = hard if now == resource.RLIM_INFINITY else min(hard, now)
    resource.setrlimit(kind, (min(soft, ceiling), ceiling))


def cache_dir() -> Path:
    """The folder in which built assets and painted textures are kept between runs.

    Python and the command line share it, so that what one has built the other does not build again. It is the
    environment variable CASA_ASSETS_CACHE if that is set, else the user's cache folder of this platform, such as
    `~/.cache/casa-assets` (`$XDG_CACHE_HOME/casa-assets` if that is set). It is made when something is first kept in
    it, and removing it costs time and nothing else. When it grows over 4 GB, or over the number of the environment
    variable CASA_ASSETS_CACHE_GB, what was used longest ago is removed. If it cannot be written to, the command line
    keeps the same files in `.casa/cache` of its output folder and says so; functions called from Python keep nothing.

    Returns:
        Absolute path; the folder need not exist yet.
    """
    stated = os.environ.get(CACHE_VARIABLE)
    if stated:
        return Path(stated).expanduser().absolute()
    return platformdirs.user_cache_path("casa-assets", appauthor=False)


def cache_for(out: Path) -> Path:
    """The cache of a run that writes to the folder `out`.

    It is cache_dir(), or `.casa/cache` in `out` if cache_dir() cannot be written to or its disk is full.
    """
    return out / ".casa" / "cache" if unusable(cache_dir()) else cache_dir()


def unusable(cache: Path) -> str:
    """Why nothing can be kept in a cache folder, such as "is on a full disk"; empty if something can.

    The folder need not exist: then its nearest parent folder decides.
    """
    place = cache
    while not os.path.lexists(place) and place != place.parent:
        place = place.parent
    try:
        if not place.is_dir() or not os.access(place, os.W_OK | os.X_OK):
            return "cannot be written to"
        return "is on a full disk" if shutil.disk_usage(place).free < MIN_FREE_BYTES else ""
    except OSError as error:
        return f"cannot be used: {error.strerror}"


def max_cache_bytes() -> int:
    """Bytes that painted textures and built assets of one cache may take together.

    Raises CasaError: the environment variable CASA_ASSETS_CACHE_GB is no number of gigabytes.
    """
    stated = os.environ.get(SIZE_VARIABLE) or str(DEFAULT_GB)
    try:
        gigabytes = float(stated)
    except ValueError:
        gigabytes = math.nan
    if not 0 <= gigabytes < math.inf:
        raise CasaError(f"{SIZE_VARIABLE}={stated}: give gigabytes, such as 4 or 0.5; 0 keeps nothing")
    return int(gigabytes * 1e9)


def kept_json(path: Path) -> Any:
    """Return the value that `keep_json` wrote to a file, or None if the file is missing or damaged."""
    try:
        return json.loads(path.read_bytes())
    except (OSError, ValueError):
        return None


def keep_json(path: Path, value: Any) -> None:
    """Write a value to a file atomically; write nothing if the cache is not writable or the value is not JSON."""
    with suppress(OSError, TypeError):
        replace_file(path, json.dumps(value).encode())


def find_blender() -> str:
    """Path of a Blender, or of a Python with bpy; empty if neither is found.

    If CASA_BLENDER is set, only that one. Otherwise the one of the checkout (`.venv-blender`), of the user (see
    `how_to_install`), or `blender` on the PATH.
    """
    named = os.environ.get(BLENDER_VARIABLE, "")
    if named:
        return named if os.access(named, os.X_OK) else ""
    users = str(user_environment("blender") / "bin" / "python")
    for path in (str(_CHECKOUT), users, shutil.which("blender") or ""):
        if path and os.access(path, os.X_OK):
            return path
    return ""


def how_to_install() -> str:
    """Advice to the user if `find_blender` finds no Blender: a clause that follows "Blender, "."""
    named = os.environ.get(BLENDER_VARIABLE, "")
    if named:
        return f"{BLENDER_VARIABLE} names {named!r}, which is no program: correct it, or unset it"
    place = shlex.quote(str(user_environment("blender")))
    return (
        f"which was not found; install it: python3.11 -m venv {place} && {place}/bin/pip install {_MODULE}, "
        f"or name one that you have: export {BLENDER_VARIABLE}=/path/to/blender"
    )


def command(program: str, script: Path, *arguments: str) -> list[str]:
    """Command line that runs a script by `program`, which is a Blender or a Python with bpy."""
    if Path(program).name.lower().startswith("blender"):
        options = ["--background", "--factory-startup", "--disable-autoexec", "--python-exit-code", "1", "--python"]
        return [program, *options, str(script), "--", *arguments]
    return [program, "-I", str(script), *arguments]


def environment(folder: Path) -> dict[str, str]:
    """Environment of that process: only the variables that a program needs; its settings and files go into `folder`."""
    kept = {key: os.environ[key] for key in ("PATH", "LANG", "LD_LIBRARY_PATH") if key in os.environ}
    return {**kept, "HOME": str(folder), "TMPDIR": str(folder), "BLENDER_USER_RESOURCES": str(folder / "user")}


def process_name() -> str:
    """Name of the machine and number of the process: machines of a cluster may have processes of the same number."""
    return f"{os.uname().nodename.replace('/', '_')}.{os.getpid()}"


def replace_file(path: Path, data: bytes) -> Path:
    """Write a file by one rename, in a folder that is made where it is missing: a reader sees all of it or none."""
    path.parent.mkdir(parents=True, exist_ok=True)
    fresh = path.with_name(f".{path.name}.{process_name()}")
    try:
        fresh.write_bytes(data)
        return fresh.replace(path)
    finally:
        with suppress(OSError):
            fresh.unlink(missing_ok=True)


def is_worker() -> bool:
    """Return True in a worker of `runs`, while others work on the other cores."""
    return WORKER in os.environ


def requirements() -> tuple[str, ...]:
    """Requirements of this package without extras, such as "numpy>=2.1"."""
    project = _project()
    if project is not None:
        return tuple(project["dependencies"])
    return tuple(line for line in importlib.metadata.requires(DISTRIBUTION) or [] if not _EXTRA.search(line))


def extras() -> dict[str, tuple[str, ...]]:
    """Name of each extra for users -> what it requires, such as {"parquet": ("pyarrow>=17",)}; sorted."""
    project = _project()
    found: dict[str, tuple[str, ...]] = {}
    if project is not None:
        found = {name: tuple(lines) for name, lines in project["optional-dependencies"].items()}
    for line in (importlib.metadata.requires(DISTRIBUTION) or []) if project is None else []:
        if named := _EXTRA.search(line):
            found[named[1]] = (*found.get(named[1], ()), line.partition(";")[0].strip())
    return {name: found[name] for name in sorted(found) if name != FOR_DEVELOPERS}


def install_command(extra: str) -> str:
    """Command that installs an extra into this environment.

    The package is on no index. In a checkout the checkout is installed with the extra and the pinned versions;
    elsewhere the packages that the extra requires are installed by their own names.
    """
    pip = f"{shlex.quote(sys.executable)} -m pip install"
    if _project() is None:
        return f"{pip} {shlex.join(extras()[extra])}"
    return f"{pip} -c {shlex.quote(str(_SOURCE / 'constraints.txt'))} -e {shlex.quote(f'{_SOURCE}[{extra}]')}"


def require(module: str, extra: str, purpose: str) -> None:
    """Check that an optional module is installed, without importing it.

    `module`: name of a module on the top level. `extra`: the extra that brings it. `purpose`: what needs it, as the
    beginning of a sentence. Raises CasaError: it is not installed; names the extra and the command.
    """
    if importlib.util.find_spec(module) is None:
        message = f"{purpose} needs {module}, which is not installed; the extra '{extra}' brings it"
        raise CasaError(f"{message}: {install_command(extra)}")


def _project() -> dict[str, Any] | None:
    """The table `project` of pyproject.toml; None away from a checkout."""
    path = _SOURCE / "pyproject.toml"
    if not path.is_file():
        return None
    project: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8")).get("project", {})
    return project if project.get("name") == DISTRIBUTION else None
