"""One input on its way through a worker: what goes in, what comes out, and how it gets its place in the library."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from casa_assets.cache.cache_key import digest_of
from casa_assets.errors import Rejected
from casa_assets.ingest.run.survey import Survey
from casa_assets.ingest.sources.found import Found
from casa_assets.library import library as disk
from casa_assets.library.identity import Producer
from casa_assets.model.issue import Report
from casa_assets.model.source import NO_OVERRIDE, UserOverride
from casa_assets.runs.outcome import Outcome

# Limits that turn inputs away and change nothing about those that pass: raising one remakes nothing.
ADMISSION_LIMITS = frozenset({"input_bytes", "input_faces", "input_seconds", "input_memory_bytes"})


@dataclass(frozen=True)
class Job:
    """One input to be worked on, once its id is known; with the limits and the cache key of this run for it."""

    found: Found
    survey: Survey
    asset_id: str
    library: Path
    limits: Mapping[str, float]
    cache_key: str
    override: UserOverride = NO_OVERRIDE


@dataclass(frozen=True)
class Result:
    """State of one input before its entry is published.

    Attributes:
        number: its place among the inputs of the run that could be read.
        job: the input. outcome: the verdict of a worker, or of an earlier run.
        folder: of an accepted asset: in the staging folder, or, if it was kept, in the library.
        is_kept: the library holds this outcome already.
        twin: folder, relative to the library, of the asset that it is a copy of; empty if it is no copy.
    """

    number: int
    job: Job
    outcome: Outcome
    folder: Path | None = None
    is_kept: bool = False
    twin: str = ""


def stage_refusal(
    library: disk.Library,
    job: Job,
    error: Rejected,
    report: Report | None = None,
    picture: bytes | None = None,
    twin: str = "",
) -> Path:
    """The finished entry of a rejected input, in the staging folder, with the report of the checks that ran.

    `picture`: PNG of the input. `twin`: folder, relative to the library, of the asset that it is a copy of.
    """
    refusal = disk.Refusal(
        id=job.asset_id,
        code=error.code,
        message=error.message,
        category=job.survey.category,
        producer=Producer.INGEST,
        cache_key=job.cache_key,
        sha256=job.survey.sha256,
        source=job.found.source,
        report=report,
        twin=twin,
    )
    return library.stage_refusal(refusal, picture or b"")


def limits_in_key(limits: Mapping[str, float]) -> dict[str, float]:
    """Limits that change what comes out, sorted."""
    return {name: value for name, value in sorted(limits.items()) if name not in ADMISSION_LIMITS}


def with_overrides(key: str, override: UserOverride) -> str:
    """Return the cache key of an input with a person's decisions: a changed decision makes the result again."""
    return key if override.is_empty else digest_of(key, override.digest)
