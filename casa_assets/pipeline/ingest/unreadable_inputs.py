"""Refusals of inputs that could not be read: their ids are made from their paths, as their bytes have no digest."""

from __future__ import annotations

import hashlib
from collections import Counter

from casa_assets import registry
from casa_assets.errors import OutputError
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.identity import Identity, Producer

# Stands in ids for the category, which nobody can know.
SHELF = "unread"


class UnreadableInputs:
    """The unreadable inputs of one run; several at one place (rows that name one mesh) are numbered.

    Args:
        producer: that the run is of.
    """

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
    """Write a refusal to the library and return True; False if `before` holds the same one already.

    Args:
        before: library that holds what earlier runs made; None: it is the same one.
    """
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
