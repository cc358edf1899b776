"""Fetch what sources of plug-ins bring, each address once."""

from __future__ import annotations

import hashlib
import shutil
from collections.abc import Sequence
from pathlib import Path

from casa_assets.core.cache_folder import cache_for
from casa_assets.errors import PluginFailure
from casa_assets.ingest.sources.found import Refused
from casa_assets.ingest.sources.places import StoreRoot, root_of
from casa_assets.pipeline.ingest.job import keep_trace
from casa_assets.pipeline.library.library import Library
from casa_assets.pipeline.process_name import process_name
from casa_assets.registry.plugins.exchange import sources
from casa_assets.registry.plugins.guard import guarded

FETCHED = "fetched"  # folder in the cache
FAILED = "RUN009"


def roots_of(words: Sequence[str | Path], library: Path) -> tuple[list[Path | StoreRoot], tuple[Refused, ...]]:
    """Paths, addresses of stores, and folders of what plug-ins fetch; and the addresses at which a plug-in failed.

    Args:
        library: keeps the traces of plug-ins that fail.
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
    """True for an address whose scheme a plug-in has; a path that is there is none."""
    scheme, colon, _ = address.partition(":")
    return bool(colon) and scheme in sources() and not Path(address).exists()


def fetch(address: str, library: Path) -> Path | Refused:
    """The folder with what is at an address of a plug-in; where that fails, the address as an input that was rejected.

    What an earlier run fetched with the same code is kept.
    """
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
