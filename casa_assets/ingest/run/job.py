"""One input on its way through a worker: what is asked about it, what comes out, and how it gets into the library."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from casa_assets.cache.cache_key import digest_of
from casa_assets.errors import CasaError, Rejected
from casa_assets.ingest.run.survey import HeldThings, Survey, SurveyAnswer, SurveyTable, things_held
from casa_assets.ingest.sources.places import Found
from casa_assets.library import library as disk
from casa_assets.library.library import Producer
from casa_assets.model.issue import Report
from casa_assets.model.source import NO_OVERRIDE, UserOverride
from casa_assets.runs.limits import WorkerFailure
from casa_assets.runs.outcome import FAILURE_CODES, Outcome, RunAborted
from casa_assets.runs.pool import Engine

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


# Answers --------------------------------------------------------------------------------------------------------------
# What a run asks about its inputs: what they hold, what they are, what becomes of them.

# By name: the module loads renderer and validator, half a second and 100 MB that only workers need.
WARM, CHECK_RENDERER = "casa_assets.ingest.run.steps:warm", "casa_assets.ingest.run.steps:check_renderer"
WORK = "casa_assets.ingest.run.steps:work"


class Answers(Protocol):
    """Answers the questions of a run, each about all of its inputs at once, in this order."""

    def things(self, found: Sequence[Found]) -> Mapping[int, HeldThings]:
        """The things that files hold by the number of the input; asked only by a run that takes files apart."""

    def surveys(self, found: Sequence[Found]) -> Iterator[tuple[int, SurveyAnswer]]:
        """Yield the number of an input and what it is, in any order."""

    def outcomes(self, jobs: Sequence[Job]) -> Iterator[tuple[int, Outcome]]:
        """Yield the number of a job and what became of it, in any order."""


@dataclass(frozen=True)
class WorkerAnswers:
    """Answers of worker processes, which read the inputs and build the assets.

    `show_work` is called with the path of each input that is begun to be worked on.
    """

    pool: Engine
    table: SurveyTable
    limits: Mapping[str, float]
    show_work: Callable[[str], None] | None = None

    def things(self, found: Sequence[Found]) -> dict[int, HeldThings]:
        """See Answers. A file that cannot be read holds none; its survey reports the error."""
        answers = self.pool.run(things_held, [(one, self.limits) for one in found])
        return {number: answer for number, answer in answers if isinstance(answer, HeldThings)}

    def surveys(self, found: Sequence[Found]) -> Iterator[tuple[int, SurveyAnswer]]:
        """See Answers."""
        return self.table.survey(found, self.pool)

    def outcomes(self, jobs: Sequence[Job]) -> Iterator[tuple[int, Outcome]]:
        """See Answers. Raises CasaError where this machine cannot draw."""
        self.pool.prepare(WARM)
        for _, answer in self.pool.run(CHECK_RENDERER, [None]):
            _outcome(answer)

        def started(place: int) -> None:
            if self.show_work is not None:
                self.show_work(jobs[place].found.source.place)

        for place, answer in self.pool.run(WORK, jobs, started):
            yield place, _outcome(answer)


def _outcome(answer: object) -> Outcome:
    """The outcome that a worker gives or leaves behind. Raises CasaError where the machine is at fault."""
    if isinstance(answer, RunAborted):
        raise CasaError(answer.message)
    if isinstance(answer, WorkerFailure):
        return Outcome(False, FAILURE_CODES[answer.reason], answer.message, trace=answer.trace)
    if not isinstance(answer, Outcome):
        return Outcome(False, FAILURE_CODES["error"], f"a worker answered with {type(answer).__name__}")
    return answer
