"""Find the inputs of a run, also those of plug-ins, and those that cannot be read."""

from __future__ import annotations

import hashlib
import os
import shutil
from collections import Counter
from collections.abc import Iterator, Sequence, Set
from dataclasses import replace
from pathlib import Path
from typing import Any

from casa_assets import registry
from casa_assets.core.system import cache_for, process_name, require
from casa_assets.errors import OutputError, PluginFailure
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.ingest.sources.places import StoreRoot, folder_of, root_of, utf8_escaped
from casa_assets.library import library as disk
from casa_assets.library.identity import Identity, Producer
from casa_assets.library.library import Library
from casa_assets.model.source import Source
from casa_assets.registry.plugins.guard import guarded, sources
from casa_assets.runs.outcome import keep_trace

# Unreadable inputs ----------------------------------------------------------------------------------------------------
# Refusals of inputs that could not be read: their ids are made from their paths, as their bytes have no digest.

# Stands in ids for the category, which nobody can know.
SHELF = "unread"


class UnreadableInputs:
    """The unreadable inputs of one run; several at one place (rows that name one mesh) are numbered."""

    def __init__(self, producer: Producer = Producer.INGEST) -> None:
        self._producer = producer
        self._count_by_place: Counter[str] = Counter()
        self._places: set[str] = set()
        self._ids: set[str] = set()

    def refusal(self, found: Found, code: str, message: str, cache_key: str) -> disk.Refusal:
        """The record to be kept of an input."""
        source = found.source
        place = _place_key(source.path, source.uid)
        self._places.add(place)
        self._count_by_place[place] += 1
        # Stands in for the digest of the bytes, which could not be read.
        digest = hashlib.sha256(f"{place}:{self._count_by_place[place]}".encode()).hexdigest()
        asset_id = Identity(self._producer, digest).asset_id(SHELF)
        self._ids.add(asset_id)
        return disk.Refusal(
            producer=self._producer,
            id=asset_id,
            code=code,
            message=message,
            category=registry.FALLBACK,
            cache_key=cache_key,
            sha256=digest,
            source=source,
        )

    def note_readable(self, found: Found) -> None:
        """Note that an input can be read now, so an older refusal of its place no longer holds."""
        self._places.add(_place_key(found.source.path, found.source.uid))

    def note_refused(self, refused: Refused) -> None:
        """Note that an input is kept among the refused rows, so an older refusal of its place no longer holds."""
        self._places.add(_place_key(refused.path))

    def prune(self, library: disk.Library) -> None:
        """Remove refusals of places that this run looked at and did not refuse."""
        for folder in list(library.refused()):
            if folder.name.startswith(f"{SHELF}_") and folder.name not in self._ids:
                try:
                    refusal = disk.read_refusal(folder)
                    place = _place_key(refusal.source.path, refusal.source.uid)
                    is_obsolete = refusal.producer is self._producer and place in self._places
                except OutputError:
                    is_obsolete = True  # it is damaged
                if is_obsolete:
                    library.forget(folder)


def write_if_changed(library: disk.Library, refusal: disk.Refusal, before: disk.Library | None = None) -> bool:
    """Write a refusal to the library and return True; False if the library, or `before`, holds the same one already."""
    known = (before or library).refusal_folder(refusal.id)
    try:
        if (known / disk.REFUSAL).exists() and disk.read_refusal(known) == refusal:
            return False
    except OutputError:
        pass  # damaged: written anew
    library.put(library.stage_refusal(refusal), library.refusal_folder(refusal.id))
    return True


def _place_key(path: str, uid: str = "") -> str:
    """Key of an input: its path and its id in a manifest. It is the same whether a file is refused early or late."""
    return f"{path}:{uid}"


# Plugin sources -------------------------------------------------------------------------------------------------------
# Fetch what sources of plug-ins bring, each address once.

FETCHED = "fetched"  # folder in the cache
FAILED = "RUN009"


def roots_of(words: Sequence[str | Path], library: Path) -> tuple[list[Path | StoreRoot], tuple[Refused, ...]]:
    """Paths, addresses of stores, and folders of what plug-ins fetch; and the addresses at which a plug-in failed.

    The library keeps the traces of plug-ins that fail.
    """
    roots: list[Path | StoreRoot] = []
    refused: list[Refused] = []
    for word in words:
        one = word if isinstance(word, Path) else fetch(word, library) if is_of_plugin(word) else root_of(word)
        if isinstance(one, Refused):
            refused.append(one)
        else:
            roots.append(one)
    return roots, tuple(refused)


def is_of_plugin(address: str) -> bool:
    """Return whether an address has a scheme of a plug-in. An existing path is no such address."""
    scheme, colon, _ = address.partition(":")
    return bool(colon) and scheme in sources() and not Path(address).exists()


def fetch(address: str, library: Path) -> Path | Refused:
    """The folder with the files at a plug-in's address, kept from a run of the same code, or a rejected input."""
    plugin, source = sources()[address.partition(":")[0]]
    key = hashlib.sha256(f"{address}\0{plugin.digest}".encode()).hexdigest()[:16]
    folder = cache_for(library) / FETCHED / key  # not in the library: what lies there is output, not input
    if folder.is_dir():
        return folder
    draft = folder.with_name(f"{key}.{process_name()}.part")
    shutil.rmtree(draft, ignore_errors=True)
    draft.mkdir(parents=True)
    try:
        guarded(plugin, f"source {source.scheme}", source.fetch)(address, draft)
    except PluginFailure as error:
        shutil.rmtree(draft)
        return Refused(address, FAILED, f"{error}; the trace: {keep_trace(error, Library(library))}")
    try:
        draft.rename(folder)
    except OSError:
        # Another run has fetched the same meanwhile.
        if not folder.is_dir():
            raise
        shutil.rmtree(draft)
    return folder


# Discover inputs ------------------------------------------------------------------------------------------------------
# Find the inputs under paths that the user names; libraries among them are left out, and names are made valid text.

# Names of library/analysis/library_report.py and reports/attribution.py: every library has both. By value, as another
# report changes nothing about what is found.
LIBRARY_FILES = ("library.json", "ATTRIBUTION.md")


def discover_inputs(
    roots: Sequence[Path | StoreRoot],
    library: Path,
    others: Counter[str] | None = None,
) -> Iterator[Found | Refused]:
    """Inputs under the roots, files and folders, on the disk or on stores, in an order that no machine changes.

    `others`: counts what is no mesh, by what it is. What lies in a library, ours or another, is output, not input.
    Raises CasaError: there is nothing at an address, or its store cannot be reached, or no package reads it.
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
    """True if a file is in our library, or in any library below a root (a root may be one).

    `is_output`: takes up what is known of folders, by their path.
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
    """True for a folder in a library on a store, below the folder that the user named; `is_output`: by address."""
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
