"""Refusals of meshes that could not be read: their ids come from their place, since there is no digest of the bytes."""

from __future__ import annotations

import hashlib
from collections import Counter

from casa_assets import registry
from casa_assets.errors import OutputError
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.model.ingest.source import Source
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.identity import Producer

PREFIX = "unread_"


class UnreadableInputs:
    """The unreadable inputs of one run; several at one place (rows that name one mesh) are numbered."""

    def __init__(self) -> None:
        self._times: Counter[str] = Counter()
        self._places: set[str] = set()
        self._ids: set[str] = set()

    def refusal(self, one: Found, code: str, message: str, cache_key: str) -> disk.Refusal:
        """The record to be kept of an input."""
        source = one.source
        place = _place(source)
        self._places.add(place)
        self._times[place] += 1
        digest = hashlib.sha256(f"{place}:{self._times[place]}".encode()).hexdigest()
        asset_id = f"{PREFIX}{digest[:10]}"
        self._ids.add(asset_id)
        return disk.Refusal(
            producer=Producer.INGEST,
            id=asset_id,
            code=code,
            message=message,
            category=registry.FALLBACK,
            cache_key=cache_key,
            sha256=digest,
            source=source,
        )

    def is_readable(self, one: Found) -> None:
        """Note that an input can be read now, so an older refusal of its place no longer holds."""
        self._places.add(_place(one.source))

    def is_refused(self, one: Refused) -> None:
        """Note that an input is kept among the refused rows, so an older refusal of its place no longer holds."""
        self._places.add(f"{one.path}:")

    def prune(self, library: disk.Library) -> None:
        """Remove refusals of places that this run looked at and did not refuse."""
        for folder in list(library.refused()):
            if folder.name.startswith(PREFIX) and folder.name not in self._ids:
                try:
                    is_over = _place(disk.read_refusal(folder).source) in self._places
                except OutputError:
                    is_over = True
                if is_over:
                    library.forget(folder)


def remember(library: disk.Library, refusal: disk.Refusal) -> bool:
    """Put a refusal into the library; False where it stands there already."""
    target = library.refusal_folder(refusal.id)
    try:
        if (target / disk.REFUSAL).exists() and disk.read_refusal(target) == refusal:
            return False
    except OutputError:
        pass  # damaged: written anew
    staged = library.stage(refusal.id)
    disk.write_refusal(staged, refusal)
    library.put(staged, target)
    return True


def _place(source: Source) -> str:
    """Key of the place where an input stands: the same for a file that was refused while looking or while reading."""
    return f"{source.path}:{source.uid}"
