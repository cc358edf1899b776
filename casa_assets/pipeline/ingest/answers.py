"""Ask about the inputs of a run: what they hold, what they are, what becomes of them. Worker processes answer."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from casa_assets.errors import CasaError, Rejected
from casa_assets.ingest.sources.found import Found
from casa_assets.pipeline.ingest.job import Job, Outcome, RunAborted
from casa_assets.pipeline.ingest.split import HeldThings
from casa_assets.pipeline.ingest.survey import Survey
from casa_assets.pipeline.ingest.survey_table import SurveyTable
from casa_assets.pipeline.workers.limits import WorkerFailure
from casa_assets.pipeline.workers.pool import Engine

# What the pool's own verdicts are called in registry/rejections.yaml.
CRASH_CODE = "RUN004"  # of the program, not of the input
FAILURE_CODES = {
    "timeout": "RUN001",
    "memory": "RUN002",
    "signal": "RUN003",
    "killed": "RUN003",
    "error": CRASH_CODE,
    "stuck": "RUN008",
}

SurveyAnswer = Survey | Rejected | WorkerFailure


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

    Attributes:
        pool: the workers. table: surveys of earlier runs. limits: of the run, by their names in registry/limits.yaml.
        show_work: is called with the path of each input that is begun to be worked on.
    """

    pool: Engine
    table: SurveyTable
    limits: Mapping[str, float]
    show_work: Callable[[str], None] | None = None

    def things(self, found: Sequence[Found]) -> dict[int, HeldThings]:
        """See Answers. A file that cannot be read holds none, which its survey tells."""
        jobs = [(one, self.limits) for one in found]
        answers = self.pool.run("casa_assets.pipeline.ingest.split:things_held", jobs)
        return {number: answer for number, answer in answers if isinstance(answer, HeldThings)}

    def surveys(self, found: Sequence[Found]) -> Iterator[tuple[int, SurveyAnswer]]:
        """See Answers."""
        return self.table.survey(found, self.pool)

    def outcomes(self, jobs: Sequence[Job]) -> Iterator[tuple[int, Outcome]]:
        """See Answers. Raises CasaError where this machine cannot draw."""
        self.pool.prepare("casa_assets.pipeline.ingest.worker:warm")
        for _, answer in self.pool.run("casa_assets.pipeline.ingest.worker:check_renderer", [None]):
            _outcome(answer)

        def started(place: int) -> None:
            if self.show_work is not None:
                self.show_work(jobs[place].found.source.place)

        for place, answer in self.pool.run("casa_assets.pipeline.ingest.worker:work", jobs, started):
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
