"""Find the inputs under paths that the user names; libraries among them are left out, and names are made valid text."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Sequence, Set
from dataclasses import replace
from pathlib import Path
from typing import Any

from casa_assets.ingest.sources.bounded_reads import utf8_escaped
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.ingest.sources.places import StoreRoot, folder_of
from casa_assets.model.ingest.source import Source
from casa_assets.pipeline.optional_packages import require

# Names of pipeline/dedup/library_report.py and reports/attribution.py: every library has both. By value, as another
# report changes nothing about what is found.
LIBRARY_FILES = ("library.json", "ATTRIBUTION.md")


def discover_inputs(
    roots: Sequence[Path | StoreRoot],
    library: Path,
    others: Counter[str] | None = None,
) -> Iterator[Found | Refused]:
    """Inputs under the roots, in an order that no machine changes.

    Args:
        roots: files and folders, on the disk or on stores. others: counts what is no mesh, by what it is.
        library: what lies in it is output, not input; so is what lies in another library below a root.
    Raises:
        CasaError: there is nothing at an address, or its store cannot be reached, or no package reads it.
    """
    if any(isinstance(root, StoreRoot) for root in roots):
        require("fsspec", "stores", "Reading from a store")
    own_library = Path(os.path.realpath(library))
    real_roots = {Path(os.path.realpath(root)) for root in roots if isinstance(root, Path)}
    named_files = {root for root in real_roots if root.is_file()}
    # What a manifest lists stands beside it or below.
    real_roots |= {root.parent for root in named_files if root.suffix.lower() in (".json", ".jsonl")}
    is_output: dict[str, bool] = {}
    for found in discover(roots, others):
        if isinstance(found, Found):
            places = [found.root / (found.archive or found.main)]
        else:
            places = [root / found.path for root in roots]
        if not any(
            _is_output(place, real_roots, named_files, own_library, is_output)
            if isinstance(place, Path)
            else _is_in_library(place.parent, is_output)
            for place in places
        ):
            yield replace(found, source=_as_text(found.source)) if isinstance(found, Found) else found


def _as_text(source: Source) -> Source:
    """The source's words as text that every file can hold."""
    # That all of it is ASCII, as nearly always, is told at once.
    if "".join(["".join(value) for value in vars(source).values()]).isascii():
        return source
    texts: dict[str, Any] = {
        name: tuple(map(utf8_escaped, value)) if isinstance(value, tuple) else utf8_escaped(value)
        for name, value in source
        if isinstance(value, str | tuple) and name != "kind"
    }
    is_unchanged = all(getattr(source, name) == value for name, value in texts.items())
    return source if is_unchanged else source.replace(**texts)


def _is_output(
    place: Path, real_roots: Set[Path], named_files: Set[Path], own_library: Path, is_output: dict[str, bool]
) -> bool:
    """True if a file lies in our library, or in any library that lies below a root (a root may be one).

    Args:
        named_files: roots that are files.
        is_output: takes up what is known of folders, by their path.
    """
    # Path would take longer than all the rest, and the real path of a folder is looked for once, not for each file.
    file = str(place)
    if named_files and (named := Path(os.path.realpath(file))) in named_files:
        return own_library in named.parents  # the user asked for it, whatever stands above it
    folder = os.path.dirname(os.path.realpath(file) if os.path.islink(file) else file)  # noqa: PTH114, PTH120
    if folder not in is_output:
        is_output[folder] = _is_output_folder(Path(os.path.realpath(folder)), real_roots, own_library)
    return is_output[folder]


def _is_in_library(folder: StoreRoot, is_output: dict[str, bool]) -> bool:
    """True for a folder in a library on a store, below the folder that the user named.

    Args:
        is_output: takes up what is known of folders, by their address.
    """
    if not folder.path:
        return False  # the user asked for what is in there
    if (address := str(folder)) not in is_output:
        files = folder_of(folder)
        is_library = all(files.has(name) for name in LIBRARY_FILES)
        is_output[address] = is_library or _is_in_library(folder.parent, is_output)
    return is_output[address]


def _is_output_folder(place: Path, real_roots: Set[Path], own_library: Path) -> bool:
    for folder in (place, *place.parents):
        if folder == own_library:
            return True
        if folder in real_roots:
            # Above it only our own library counts: the user asked for what is in there.
            return own_library in folder.parents
        if (folder / ".casa" / "lock").is_file():
            return True
    return False
