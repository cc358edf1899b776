"""Find the digest and the category of an input before any work; light, for it runs on every input."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass

from casa_assets import registry
from casa_assets.errors import Rejected
from casa_assets.ingest.sources.bundle import collect
from casa_assets.ingest.sources.found import Found
from casa_assets.ingest.sources.places import is_url
from casa_assets.ingest.sources.stores import state_at
from casa_assets.model.registry.category import Category

# Confidence in a category that the source itself states; of 98 such in data for developing none was wrong.
SAID_CONFIDENCE = 0.98
# Largest confidence in a category from a name if the source states another one, so that a person looks at it.
CONTRADICTED_CONFIDENCE = 0.4


@dataclass(frozen=True)
class Survey:
    """Digest of an input and its category, with the confidence, 0..1, and the reason.

    `looked_at`: files and folders that decided it, with their `state_of`.
    """

    sha256: str
    category: str
    confidence: float
    reason: str
    looked_at: tuple[tuple[str, str], ...] = ()


def state_of(path: str) -> str:
    """State of a file, folder or object on a store, which changes whenever it is written; empty if there is none."""
    if is_url(path):
        return state_at(path)
    try:
        found = os.stat(path)  # noqa: PTH116  Path would take longer than the system does
    except (OSError, ValueError):
        return ""
    return f"{found.st_mtime_ns} {found.st_ctime_ns} {found.st_size} {found.st_ino}"


def warm() -> None:
    """Load what every survey needs, once for all workers."""
    registry.load()


def survey(job: tuple[Found, str, Mapping[str, float]]) -> Survey | Rejected:
    """Survey of an input. The job is the input, the category that the user requested or nothing, and the limits."""
    found, requested, limits = job
    looked_at: set[str] = set()
    try:
        bundle = collect(found, limits, looked_at)
    except Rejected as error:
        return error
    category, confidence, reason = find_category(found, requested)
    states = tuple((path, state_of(path)) for path in sorted(looked_at))
    return Survey(bundle.sha256, category.id, confidence, reason, states)


def find_category(found: Found, requested: str) -> tuple[Category, float, str]:
    """Category of an input, confidence and reason: by the user, else by the source, else by names and titles."""
    known = registry.load()
    if requested:
        return known.category(requested), 1.0, "given on the command line"
    source = found.source
    if source.node:  # The name and title of the file speak of all things in it together.
        named = known.find_category([source.node])
        if named is not None:
            return named
        return known.category(registry.FALLBACK), 0.1, f"{source.node!r} names no category that the registry knows"
    if source.category:
        match = known.find_category([source.category])
        if match is not None:
            return match[0], max(SAID_CONFIDENCE, match[1]), f"the source says {source.category!r}"
    match = known.find_category([*source.hints, source.title, source.prompt])
    if match is not None and source.category:
        reason = f"{match[2]}; the source says {source.category!r}, which the registry does not know"
        return match[0], min(CONTRADICTED_CONFIDENCE, match[1]), reason
    if match is not None:
        return match[0], match[1], match[2]
    return known.category(registry.FALLBACK), 0.1, "nothing names a category that the registry knows"
