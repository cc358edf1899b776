"""Find the digest and the category of an input before any work; light, for it runs on every input."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from casa_assets import registry
from casa_assets.errors import Rejected
from casa_assets.ingest.sources.bundle import collect
from casa_assets.ingest.sources.found import Found
from casa_assets.model.registry.category import Category

# How sure a name can make of a category where the source states another one: for a person to look at.
CONTRADICTED_CONFIDENCE = 0.4


@dataclass(frozen=True)
class Survey:
    """Digest of an input, its category, how sure that is, and why."""

    sha256: str
    category: str
    confidence: float
    reason: str


def warm() -> None:
    """Load what every survey needs, once for all workers."""
    registry.load()


def survey(job: tuple[Found, str, Mapping[str, float]]) -> Survey | Rejected:
    """Survey of an input; then come a category that the user ordered, or nothing, and the limits of the run."""
    found, ordered, limits = job
    try:
        bundle = collect(found, limits)
    except Rejected as error:
        return error
    category, confidence, reason = find_category(found, ordered)
    return Survey(bundle.sha256, category.id, confidence, reason)


def find_category(found: Found, ordered: str) -> tuple[Category, float, str]:
    """Category of an input, how sure, and why: the user's word, then the source's, then names and titles."""
    known = registry.load()
    if ordered:
        return known.category(ordered), 1.0, "given on the command line"
    source = found.source
    if source.category:
        match = known.find_category([source.category])
        if match is not None:
            return match[0], min(0.99, match[1]), f"the source says {source.category!r}"
    match = known.find_category([*source.hints, source.title, source.prompt])
    if match is not None and source.category:
        reason = f"{match[2]}; the source says {source.category!r}, which the registry does not know"
        return match[0], min(CONTRADICTED_CONFIDENCE, match[1] * 0.9), reason
    if match is not None:
        return match[0], match[1] * 0.9, match[2]
    return known.category(registry.FALLBACK), 0.1, "nothing names a category that the registry knows"
