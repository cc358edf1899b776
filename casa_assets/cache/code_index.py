"""Index of the source files of this package: digest, imports and the names of files in each, kept between runs.

Reading and searching all sources takes a second. The results for a file are kept in the cache folder with the stamp of
the file (times of change and size), and a file is read again only if its stamp differs.
"""

from __future__ import annotations

import hashlib
import os
import re
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.metadata import distributions
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from casa_assets.core.system import cache_dir, keep_json, kept_json

PACKAGE = __name__.partition(".")[0]
KEPT_IN = "code"  # folder of the cache
# Name of folders of templates.
TEMPLATES = "templates"
# The folder of a wheel that holds registry/.
REGISTRY_INSIDE = "registry_data"
Stamp = tuple[int, int, int]

_IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import[ \t]+(\([^)]*\)|[^(\n]+)|import[ \t]+([\w., \t]+))", re.MULTILINE
)
_TYPES_ONLY = re.compile(r"^([ \t]*)if TYPE_CHECKING:[^\n]*\n(?:(?:\1[ \t]+[^\n]*)?\n)*", re.MULTILINE)
# Texts over several lines, such as programs that are written for others: what those import is not imported here.
_LONG_TEXT = re.compile(r"'''.*?'''|\"\"\".*?\"\"\"", re.DOTALL)
_TEXT_NAME = re.compile(rf"""["']({PACKAGE}(?:\.\w+)+)(?::\w+)?["']""")
_TEXT = re.compile(r"""["']([\w./*-]+)["']""")
_READS_REGISTRY = re.compile(r"\b(?:data_root|read_table_file|read_topmost|names_in)\b")


@dataclass(frozen=True)
class Scan:
    """Facts read from the text of a module.

    Attributes:
        sha256: of the text. modules: of this package, that it imports or names in text. outside: other modules that it
            imports. words: its short texts, including names of files. reads_registry: it reads files of registry/,
            those that it names in text.
    """

    sha256: str
    modules: tuple[str, ...]
    outside: tuple[str, ...]
    words: tuple[str, ...]
    reads_registry: bool


@dataclass(frozen=True)
class Files:
    """Files in the folder of the package.

    Attributes:
        sources: by the name of their module. stamps: of sources by the name of their module, of other files by path.
        data: paths of other files by name, relative to the package. Templates are named by their path below the folder
            of templates, such as `library/page.html`.
    """

    sources: dict[str, Path]
    stamps: dict[str, Stamp]
    data: dict[str, list[str]]


def scan(module: str) -> Scan:
    """Return the scan of a module of this package. Raises LookupError if there is no such module."""
    try:
        return _scans()[module]
    except KeyError:
        raise LookupError(f"there is no module {module}") from None


def is_ours(name: str) -> bool:
    """True if a module is of this package, by its name."""
    return name.partition(".")[0] == PACKAGE


def names_in_text(text: str) -> set[str]:
    """Short texts in quotation marks, among which are names of files."""
    return set(_TEXT.findall(text))


def reads_registry(text: str) -> bool:
    """True if code calls a function that reads files of registry/."""
    return _READS_REGISTRY.search(text) is not None


@lru_cache(maxsize=1)
def package_root() -> Path:
    """Folder of this package."""
    found = find_spec(PACKAGE)
    assert found is not None
    assert found.origin is not None
    return Path(found.origin).parent


@lru_cache(maxsize=1)
def package_files() -> Files:
    """All files of this package."""
    sources: dict[str, Path] = {}
    stamps: dict[str, Stamp] = {}
    data: dict[str, list[str]] = {}
    waiting: list[tuple[str, tuple[str, ...]]] = [(str(package_root()), ())]
    while waiting:
        folder, place = waiting.pop()
        for entry in sorted(os.scandir(folder), key=lambda entry: entry.name):
            stem, _, suffix = entry.name.rpartition(".")
            if entry.is_dir():
                if entry.name not in ("__pycache__", REGISTRY_INSIDE):
                    waiting.append((entry.path, (*place, entry.name)))
            elif suffix == "py":
                module = ".".join((PACKAGE, *place, *([] if stem == "__init__" else [stem])))
                sources[module] = Path(entry.path)
                stamps[module] = stamp_of(entry.stat())
            elif suffix != "pyc":
                parts = (*place, entry.name)
                known = "/".join(parts[parts.index(TEMPLATES) + 1 :]) if TEMPLATES in parts else entry.name
                data.setdefault(known, []).append("/".join(parts))
                stamps["/".join(parts)] = stamp_of(entry.stat())
    return Files(sources, stamps, data)


@cache
def versions_of_package(package: str) -> dict[str, str]:
    """Versions of the distributions that provide a top-level package, by their names; empty if none does."""
    return _distributions().get(package, {})


@lru_cache(maxsize=1)
def installed() -> tuple[str, ...]:
    """Folders that describe the installed distributions; their names hold the versions."""
    return tuple(str(path) for folder in map(Path, sys.path) for path in sorted(folder.glob("*.*-info")))


def stamp_of(found: os.stat_result) -> Stamp:
    """Times of change and size of a file."""
    return found.st_mtime_ns, found.st_ctime_ns, found.st_size


@lru_cache(maxsize=1)
def _scans() -> dict[str, Scan]:
    """Of all modules by name. Files that changed since the index was kept are read, and it is kept again."""
    files = package_files()
    place = kept_at("sources", str(package_root()))
    kept = kept_json(place) or {}
    found: dict[str, Scan] = {}
    fresh: dict[str, Any] = {}
    # Where an import leads depends on which modules there are, and on the names that the package offers.
    package = kept.get(PACKAGE)
    is_same = kept.keys() == files.sources.keys() and package is not None and tuple(package[0]) == files.stamps[PACKAGE]
    for module, path in files.sources.items():
        row = kept.get(module)
        if is_same and row is not None and tuple(row[0]) == files.stamps[module]:
            found[module] = Scan(row[1], tuple(row[2]), tuple(row[3]), tuple(row[4]), row[5])
        else:
            one = found[module] = _scan_text(module, path.read_text(encoding="utf-8"))
            row = [files.stamps[module], one.sha256, one.modules, one.outside, one.words, one.reads_registry]
        fresh[module] = row
    if any(fresh[module] is not kept.get(module) for module in fresh):
        keep_json(place, fresh)
    return found


def _scan_text(module: str, text: str) -> Scan:
    """Find the imports of a module in its text line by line: parsing all of the package takes seconds."""
    code = _TYPES_ONLY.sub("", text)
    found: list[str] = []
    for origin, names, plain in _IMPORT.findall(_LONG_TEXT.sub("", code)):
        if plain:
            found += [part.split()[0] for part in plain.split(",") if part.split()]
        else:
            listed = re.sub(r"#[^\n]*", "", names).strip("() \t\n")
            found += [target(origin, part.split()[0]) for part in listed.split(",") if part.split()]
    found += [name for name in _TEXT_NAME.findall(code) if name in package_files().sources]
    return Scan(
        hashlib.sha256(text.encode()).hexdigest(),
        _sorted(name for name in found if is_ours(name) and name != module),
        _sorted(name for name in found if not is_ours(name)),
        _sorted(names_in_text(text)),
        reads_registry(text),
    )


def target(origin: str, name: str) -> str:
    """The module that `from origin import name` leads to: a submodule if there is one, else the origin.

    The names that `casa_assets` itself offers lead to the modules that it loads them from.
    """
    inner = f"{origin}.{name}"
    # Not by an import, which would put the version of the package into all keys.
    offered: dict[str, str] = vars(sys.modules[PACKAGE])["SOURCES"]
    if origin == PACKAGE and name in offered:
        return offered[name]
    return inner if is_ours(origin) and inner in package_files().sources else origin


def _sorted(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(sorted(set(names)))


@lru_cache(maxsize=1)
def _distributions() -> dict[str, dict[str, str]]:
    """Versions of the installed distributions by name, by the top-level packages that they bring.

    As importlib.metadata.packages_distributions, in a tenth of the time; kept as long as the same are installed.
    """
    place = kept_at("versions", *installed())
    kept: dict[str, dict[str, str]] = kept_json(place) or {}
    if kept:
        return kept
    found: dict[str, dict[str, str]] = {}
    for distribution in distributions():
        listed = distribution.read_text("top_level.txt")
        files = (
            listed.split()
            if listed
            else [line.partition(",")[0] for line in (distribution.read_text("RECORD") or "").split("\n")]
        )
        name, version = distribution.name, distribution.version
        for package in {path.partition("/")[0].partition(".")[0] for path in files}:
            if package.isidentifier():
                # The first on the path is the one that is imported.
                found.setdefault(package, {}).setdefault(name, version)
    found = {package: dict(sorted(rows.items())) for package, rows in sorted(found.items())}
    keep_json(place, found)
    return found


def kept_at(what: str, *of: str) -> Path:
    """File of the cache that holds an index; another one for each text of the modules here and each Python."""
    own = b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("code_*.py")))
    digest = hashlib.sha256(b"\0".join([own, sys.version.encode(), *(text.encode() for text in of)])).hexdigest()
    return cache_dir() / KEPT_IN / f"{what}_{digest[:24]}.json"
