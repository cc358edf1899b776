"""Discover inputs under folders and files that the user names, in the same order on every machine."""

from __future__ import annotations

import hashlib
import os
import posixpath
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import SUFFIXES, suffix_of
from casa_assets.formats.read.text import printable
from casa_assets.ingest.sources import objaverse
from casa_assets.ingest.sources.archive import archived
from casa_assets.ingest.sources.places import (
    HIDDEN,
    Found,
    Package,
    Refused,
    StoreRoot,
    archive_suffix,
    folder_of,
    is_table,
    kind_of_other,
    unique_hints,
    unread,
    utf8_escaped,
    words_of_path,
)
from casa_assets.ingest.sources.rows import read_lines, read_list
from casa_assets.ingest.sources.stores import DEEPEST_FOLDER, list_all
from casa_assets.ingest.sources.table import tabled
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import Source, SourceKind


def discover(roots: Sequence[Path | StoreRoot], others: Counter[str] | None = None) -> Iterator[Found | Refused]:
    """All inputs under the roots; an input that several roots reach is yielded once.

    `roots`: folders or files, as the user named them, on the disk or on stores. `others`: counts the files that are no
    inputs, by what they are: pictures, materials, texts ... Yields Found or Refused, sorted by path within a root;
    packages before the loose files of the same folder. Raises CasaError: there is nothing at an address, or its store
    cannot be reached.
    """
    found_keys: set[tuple[str, str]] = set()
    refused_digests: set[bytes] = set()
    real_folders: dict[str, str] = {}
    for root in roots:
        for one in _discover(root, Counter() if others is None else others):
            if isinstance(one, Refused):
                # A digest of the place and the reason, which names the line: there may be very many.
                place = f"{root}/{one.path}"
                if isinstance(root, Path):
                    place = os.path.realpath((root if root.is_dir() else root.parent) / one.path)
                place += f"\0{one.code}\0{one.message}"
                digest = hashlib.sha256(place.encode("utf-8", "surrogateescape")).digest()[:16]
                if digest in refused_digests:
                    continue
                refused_digests.add(digest)
            else:
                # the same for an input by whatever path it is found
                if isinstance(one.root, Path):
                    path = _real_path(os.path.join(one.root, one.archive, one.main), real_folders)  # noqa: PTH118
                else:
                    path = str(one.root / one.archive / one.main)
                if (key := (path, one.source.uid)) in found_keys:
                    continue
                found_keys.add(key)
            yield one


def _real_path(path: str, real_folders: dict[str, str]) -> str:
    """As `os.path.realpath`, which looks at every folder above; `real_folders`: what is known of folders."""
    folder, name = os.path.split(path)
    if os.path.islink(path):  # noqa: PTH114
        return os.path.realpath(path)
    if folder not in real_folders:
        real_folders[folder] = os.path.realpath(folder)
    return os.path.join(real_folders[folder], name)  # noqa: PTH118


def _discover(root: Path | StoreRoot, others: Counter[str]) -> Iterator[Found | Refused]:
    if isinstance(root, Path):
        place: Path | StoreRoot = root.absolute()
        is_folder = root.is_dir()
    else:
        place = root
        faults = list_all(root)
        is_folder = faults is not None
        for path, code, why in faults or ():
            yield Refused(printable(path, 400), code, f"{printable(path, 200)}: {why}")
    around = Package(place.parent, "")
    if is_folder:
        inputs = 0
        for one in _folder(Package(place, ""), set(), 0, others):
            inputs += 1
            yield one
        if not inputs and suffix_of(place.name) in SUFFIXES:
            message = f"{utf8_escaped(place.name)}: a folder, not a regular file; put the file itself there"
            yield Refused(utf8_escaped(place.name), codes.NOT_A_FILE, message)
    elif posixpath.splitext(place.name.lower())[1] == ".jsonl":
        yield from read_lines(around, place.name, is_named=True)
    elif posixpath.splitext(place.name.lower())[1] == ".json":
        listed = objaverse.read_xl(around, place.name)
        yield from listed if listed is not None else read_list(around, place.name, is_named=True)
    elif archive_suffix(place.name):
        yield from archived(around, place.name, others)
    elif is_table(place.name):
        yield from tabled(around, place.name, others, is_named=True)
    else:
        # The Gazebo and ROS layout, whose textures lie beside the folder: ../materials/textures
        is_in_layout = place.parent.name.lower() in ("mesh", "meshes")
        package = Package(place.parent.parent, "") if is_in_layout else around
        main = f"{place.parent.name}/{place.name}" if is_in_layout else place.name
        one = _loose(package, main)
        if isinstance(one, Found):
            one = Found(one.root, one.main, one.source.replace(path=place.name))
        yield one


def _folder(package: Package, claimed: set[str], depth: int, others: Counter[str]) -> Iterator[Found | Refused]:
    """Packages here, then loose meshes, then folders; `claimed` holds the real paths of packaged files."""
    try:
        entries = package.files.scan("")
    except OSError as error:
        folder = utf8_escaped(package.prefix)
        message = f"{folder or '.'}: the folder cannot be read ({error.strerror}); change its permissions"
        yield Refused(folder.rstrip("/"), codes.UNREADABLE, message)
        return
    others[HIDDEN] += sum(e.name.startswith(".") and e.is_file for e in entries)
    entries = [e for e in entries if not e.name.startswith(".") and e.name != "__MACOSX"]
    names = frozenset(e.name.lower() for e in entries)
    for one in _packaged(package, [e.name for e in entries]):
        if isinstance(one, Found):
            claimed.add(folder_of(one.root).identity(one.main))
        yield one
    is_objaverse = objaverse.is_package([e.name for e in entries])
    folders = []
    for entry in entries:
        if entry.is_folder and suffix_of(entry.name) not in SUFFIXES:
            if not (is_objaverse and entry.name in ("glbs", "metadata")):
                folders.append(entry.name)
        elif claimed and package.files.identity(entry.name) in claimed:
            continue
        elif is_table(entry.name):
            yield from tabled(package, entry.name, others)
        elif kind := kind_of_other(entry.name, names):
            others[kind] += 1
        elif archive_suffix(entry.name):
            yield from archived(package, entry.name, others)
        elif suffix_of(entry.name) in SUFFIXES:
            yield _loose(package, entry.name)
        elif (refused := unread(utf8_escaped(package.prefix + entry.name))) is not None:
            yield refused
    for name in folders:
        if depth >= DEEPEST_FOLDER:
            message = f"{utf8_escaped(name)}: folders nested too deep; move it"
            yield Refused(utf8_escaped(package.prefix + name), codes.UNREADABLE, message)
        else:
            yield from _inner(package, name, claimed, depth, others)


def _inner(
    package: Package, name: str, claimed: set[str], depth: int, others: Counter[str]
) -> Iterator[Found | Refused]:
    """A folder inside; its loose files keep the outer root, so that ../textures is still theirs."""
    inner = Package(package.root / name, f"{package.prefix}{name}/")
    for one in _folder(inner, claimed, depth + 1, others):
        if isinstance(one, Found) and one.source.kind is SourceKind.FOLDER:
            if one.archive:
                one = replace(one, root=package.root, archive=f"{name}/{one.archive}")
            else:
                one = replace(one, root=package.root, main=f"{name}/{one.main}")
        yield one


def _packaged(package: Package, names: Sequence[str]) -> Iterator[Found | Refused]:
    if objaverse.is_package(names):
        yield from objaverse.read_package(package)
    for name in names:
        lower = name.lower()
        if lower.endswith(".jsonl"):
            yield from read_lines(package, name, is_named=False)
        elif lower == "annotations.json":
            yield from objaverse.read_xl(package, name) or ()
        elif lower.endswith(".json") and lower not in objaverse.INDEX_FILES:
            yield from read_list(package, name, is_named=False)


def _loose(package: Package, main: str) -> Found | Refused:
    """A mesh file that no package describes: its name and folders are all that is known."""
    path = package.prefix + main
    try:
        package.check_utf8(main)
        package.files.check(main)
    except Rejected as error:
        return package.refuse(main, error)
    hints = unique_hints(words_of_path(path), [package.root.name])
    source = Source(kind=SourceKind.FOLDER, path=path, hints=hints)
    return Found(package.root, main, source)
