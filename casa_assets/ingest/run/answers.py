"""Ask worker processes about the inputs of a run, and remember what earlier runs found out about them."""

from __future__ import annotations

import hashlib
import json
import sqlite3
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from casa_assets.cache.cache_key import key_of
from casa_assets.errors import CasaError, Rejected
from casa_assets.ingest.run.job import Job
from casa_assets.ingest.run.split import HeldThings, things_held
from casa_assets.ingest.run.survey import Survey, state_of, survey
from casa_assets.ingest.sources.found import Found
from casa_assets.runs.limits import WorkerFailure
from casa_assets.runs.outcome import Outcome, RunAborted
from casa_assets.runs.pool import Engine

# Survey table ---------------------------------------------------------------------------------------------------------
# What earlier runs found out about inputs whose files have not changed since, so that they are not read again.
#
# It lies in the cache of the library, and deleting it costs time and nothing else.

NAME = "surveys.sqlite"
_SCHEMA = """
CREATE TABLE IF NOT EXISTS surveys (input TEXT PRIMARY KEY, made_by TEXT, survey TEXT);
"""
# A file that is younger than this when it is read may change again without a trace in its times, which come in steps.
MIN_AGE_NS = 50_000_000


class SurveyTable:
    """Surveys by input, in the cache folder; `requested`: category for all inputs, or empty.

    Of the limits of the run those on the bytes of an input count.
    """

    def __init__(self, cache: Path, requested: str, limits: Mapping[str, float], read_only: bool = False) -> None:
        self._path, self._read_only = (cache / NAME).absolute(), read_only
        self._made_by = key_of(survey)
        self._requested, self._limits = requested, limits
        self._said = f"{requested}\0{limits['input_bytes']}"
        self._kept: dict[str, str] = {}
        with suppress(sqlite3.Error, OSError), closing(self._open()) as database:
            rows = database.execute("SELECT input, survey FROM surveys WHERE made_by = ?", (self._made_by,))
            self._kept = dict(rows.fetchall())

    def survey(self, inputs: Sequence[Found], pool: Engine) -> Iterator[tuple[int, Survey | Rejected | WorkerFailure]]:
        """Yield number and survey of every input, the known ones first; what is new is kept at the end.

        The workers of the pool read what is new. Those surveys alone have `looked_at`.
        """
        new: list[int] = []
        for number, one in enumerate(inputs):
            if (known := self.find(one)) is not None:
                yield number, known
            else:
                new.append(number)
        fresh: list[tuple[Found, Survey]] = []
        jobs = [(inputs[number], self._requested, self._limits) for number in new]
        for place, answer in pool.run(survey, jobs):
            if isinstance(answer, Survey):
                fresh.append((inputs[new[place]], answer))
            yield new[place], answer
        self.keep(fresh)

    def find(self, found: Found) -> Survey | None:
        """Return the survey of an earlier run if no file has changed since, or None otherwise."""
        text = self._kept.get(self._key(found))
        if text is None or found.is_model:
            return None
        try:
            sha256, category, confidence, reason, looked_at = json.loads(text)
            if all(state_of(path) == state for path, state in looked_at):
                return Survey(sha256, category, confidence, reason)
        except (ValueError, TypeError):
            pass  # not what was written there: it is read again
        return None

    def keep(self, surveys: Iterable[tuple[Found, Survey]]) -> None:
        """Keep what was found out now, but for files that are so young that they may still change unseen."""
        newest = time.time_ns() - MIN_AGE_NS
        rows = [
            (self._key(found), self._made_by, json.dumps((s.sha256, s.category, s.confidence, s.reason, s.looked_at)))
            for found, s in surveys
            if not found.is_model and all(_is_settled(state, newest) for _, state in s.looked_at)
        ]
        if not rows or self._read_only:
            return
        with suppress(sqlite3.Error, OSError), closing(self._open()) as database, database:
            database.execute("DELETE FROM surveys WHERE made_by != ?", (self._made_by,))
            database.executemany("INSERT OR REPLACE INTO surveys VALUES (?, ?, ?)", rows)

    def _key(self, found: Found) -> str:
        """Key of an input: its place, and what its source says of it."""
        notes = [note.to_json() for note in found.notes]
        said = f"{self._said}\0{found.root}\0{found.archive}\0{found.main}\0{found.source.to_json()}\0{notes}"
        return hashlib.sha256(said.encode("utf-8", "surrogateescape")).hexdigest()

    def _open(self) -> sqlite3.Connection:
        if self._read_only:
            return sqlite3.connect(f"{self._path.as_uri()}?mode=ro", uri=True)
        self._path.parent.mkdir(parents=True, exist_ok=True)
        database = sqlite3.connect(self._path)
        try:
            database.executescript(_SCHEMA)
        except sqlite3.DatabaseError:  # no table: what a disk fault has left there
            database.close()
            self._path.unlink(missing_ok=True)
            database = sqlite3.connect(self._path)
            database.executescript(_SCHEMA)
        return database


def _is_settled(state: str, newest_ns: int) -> bool:
    """Return whether any later change would change a state: a file's last one was before a time, ns since 1970.

    A store gives each object a tag or a time, or nothing that would change with it (`?`).
    """
    return not state or state.startswith("store ") or (state != "?" and int(state.split()[1]) < newest_ns)


# Answers --------------------------------------------------------------------------------------------------------------
# Ask about the inputs of a run: what they hold, what they are, what becomes of them. Worker processes answer.

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

    `show_work` is called with the path of each input that is begun to be worked on.
    """

    pool: Engine
    table: SurveyTable
    limits: Mapping[str, float]
    show_work: Callable[[str], None] | None = None

    def things(self, found: Sequence[Found]) -> dict[int, HeldThings]:
        """See Answers. A file that cannot be read holds none; its survey reports the error."""
        jobs = [(one, self.limits) for one in found]
        answers = self.pool.run(things_held, jobs)
        return {number: answer for number, answer in answers if isinstance(answer, HeldThings)}

    def surveys(self, found: Sequence[Found]) -> Iterator[tuple[int, SurveyAnswer]]:
        """See Answers."""
        return self.table.survey(found, self.pool)

    def outcomes(self, jobs: Sequence[Job]) -> Iterator[tuple[int, Outcome]]:
        """See Answers. Raises CasaError where this machine cannot draw."""
        self.pool.prepare(warm_workers)
        for _, answer in self.pool.run(check_renderer, [None]):
            _outcome(answer)

        def started(place: int) -> None:
            if self.show_work is not None:
                self.show_work(jobs[place].found.source.place)

        for place, answer in self.pool.run(work_on, jobs, started):
            yield place, _outcome(answer)


# What workers call. The module behind it loads renderer and validator, half a second and 100 MB that only they need.


def warm_workers() -> None:
    """See `worker.warm`."""
    from casa_assets.ingest.run import worker

    worker.warm()


def check_renderer(_: None) -> RunAborted | None:
    """See `worker.check_renderer`."""
    from casa_assets.ingest.run import worker

    return worker.check_renderer(None)


def work_on(job: Job) -> Outcome | RunAborted:
    """See `worker.work`."""
    from casa_assets.ingest.run import worker

    return worker.work(job)


def _outcome(answer: object) -> Outcome:
    """The outcome that a worker gives or leaves behind. Raises CasaError where the machine is at fault."""
    if isinstance(answer, RunAborted):
        raise CasaError(answer.message)
    if isinstance(answer, WorkerFailure):
        return Outcome(False, FAILURE_CODES[answer.reason], answer.message, trace=answer.trace)
    if not isinstance(answer, Outcome):
        return Outcome(False, FAILURE_CODES["error"], f"a worker answered with {type(answer).__name__}")
    return answer
