"""Sources into a library: find, survey, leave out twins, work on what is missing, keep the books."""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path

from casa_assets import registry
from casa_assets.errors import CasaError, Rejected
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.model.issue import Issue
from casa_assets.model.ruling import NO_RULING, Ruling
from casa_assets.model.source import Source
from casa_assets.pipeline import library as disk
from casa_assets.pipeline import look, review, unread
from casa_assets.pipeline.alike import whole
from casa_assets.pipeline.alike.twins import CODE as COPY
from casa_assets.pipeline.alike.twins import Twins
from casa_assets.pipeline.books import attribution, index
from casa_assets.pipeline.find import find
from casa_assets.pipeline.isolation.limits import Limits, WorkerFailure
from casa_assets.pipeline.isolation.pool import Pool
from casa_assets.pipeline.job import Job, Outcome, RunAborted, refuse, writing
from casa_assets.pipeline.known import verdict
from casa_assets.pipeline.stage import recipe, ruled
from casa_assets.pipeline.store import Store
from casa_assets.pipeline.survey import Survey

# What the pool's own verdicts are called in registry/rejections.yaml.
FAULT = "RUN004"  # of the program, not of the input
FAILURE_CODES = {
    "timeout": "RUN001",
    "memory": "RUN002",
    "signal": "RUN003",
    "killed": "RUN003",
    "error": FAULT,
    "stuck": "RUN008",
}
TWIN = "RUN006"


@dataclass(frozen=True)
class Options:
    """How to run.

    Attributes:
        library: output folder. category: id for all inputs, or empty.
        jobs: children at once; 0 for one per core.
        seconds: processor time for one input, with all that is started for it; 0: what registry/limits.yaml says.
        memory_bytes: memory of one input; 0: the same.
        guards: limits on inputs that this run sets in place of those in registry/limits.yaml, by their names there.
        weights: of CLIP, see pipeline.look.eye; empty: nobody looks at the pictures.
        keep_duplicates: what has the form, size and colours of another asset stays too.
    """

    library: Path
    category: str = ""
    jobs: int = 0
    seconds: float = 0.0
    memory_bytes: int = 0
    guards: Mapping[str, float] = field(default_factory=dict)
    weights: str = ""
    keep_duplicates: bool = False


@dataclass(frozen=True)
class Event:
    """One input is done with.

    Attributes:
        kind: accepted, rejected, or kept (was there already). total: inputs of the run.
        path: of the input. asset_id: its name in the library.
        code, says: of a rejection. warnings: of an accepted one.
    """

    kind: str
    total: int
    path: str
    asset_id: str = ""
    code: str = ""
    says: str = ""
    was_rejected: bool = False
    warnings: tuple[Issue, ...] = ()


@dataclass
class _Run:
    """What one run knows: its inputs, what is to be done, and the refusals that have no bytes."""

    library: disk.Library
    mark: str
    limits: Mapping[str, float]
    found: Sequence[Found | Refused]
    todo: list[Job] = field(default_factory=list)
    unread: unread.Names = field(default_factory=unread.Names)
    order: dict[str, Source] = field(default_factory=dict)
    rulings: dict[str, Ruling] = field(default_factory=dict)

    def ruling(self, survey: Survey) -> Ruling:
        """What a person decided about an input."""
        return self.rulings.get(survey.sha256, NO_RULING)

    def heard(self, answer: Survey | Rejected | WorkerFailure) -> Survey | Rejected | WorkerFailure:
        """An answer with the category that a person decided, where one did."""
        if not isinstance(answer, Survey) or not (name := self.ruling(answer).category):
            return answer
        return replace(answer, category=name, confidence=1.0, because=f"a person decided, in {review.NAME}")

    def refuse(self, one: Found | Refused, code: str, says: str) -> Event:
        """Remember an input that never became a bundle."""
        refusal = self.unread.refusal(one, code, says, self.mark)
        is_new = unread.remember(self.library, refusal)
        kind = "rejected" if is_new else "kept"
        return Event(kind, len(self.found), refusal.source.path, refusal.id, code, says, was_rejected=True)


def ingest(roots: Sequence[Path], options: Options) -> Generator[Event, None, None]:
    """Bring every mesh under `roots` into the library, or record why not.

    Yields an Event for each input, as it is done with. Killed at any moment and run again, it does what is missing.
    Where there is no input, nothing is written.

    Raises:
        UnknownId: the ordered category does not exist.
        OutputError: the library cannot be written to, or another run holds it.
        CasaError: this machine cannot make assets: no worker starts, or none can draw; or it lacks the weights of CLIP.
    """
    known = registry.load()
    if options.weights:
        look.there(options.weights)
    if options.category:
        known.category(options.category)
    found = list(find(roots, options.library))
    if not found:
        return
    library = disk.Library(options.library)
    bounds = {**known.limits, **options.guards}
    seconds = options.seconds or known.limits["input_seconds"]
    limits = Limits(seconds, options.memory_bytes or int(known.limits["input_memory_bytes"]))
    with library.locked(), writing(options.library):
        library.sweep()
        Store(library.cache).sweep()
        rulings = review.rulings(library)
        try:
            with Pool(options.jobs, limits, "casa_assets.pipeline.survey:warm") as pool:
                run = _Run(library, recipe(bounds, known.digest), bounds, found, rulings=rulings)
                events = chain(_survey(run, pool, options), _work(run, pool))
                twins = Twins(library, run.mark, known.limits["alike_form"], run.order)
                yield from events if options.keep_duplicates else twins.apart(events)
            run.unread.tidy(library)
            books(library, options.weights)
        finally:
            library.sweep()


def books(library: disk.Library, weights: str = "") -> None:
    """Rewrite what is derived from the entries: the index, the attribution file, and what is said of them together."""
    index.rebuild(library)
    attribution.write(library)
    review.write(library)
    whole.look_over(library, look.eye(weights) if weights else None)


def _survey(run: _Run, pool: Pool, options: Options) -> Generator[Event, None, None]:
    """Digest every input, decide twins, and yield an event for all that need no work."""
    inputs = [f for f in run.found if isinstance(f, Found)]
    for row in (f for f in run.found if isinstance(f, Refused)):
        yield run.refuse(row, row.code, row.says)
    answers: dict[int, Survey | Rejected | WorkerFailure] = {}
    for number, answer in pool.run(
        "casa_assets.pipeline.survey:survey", [(f, options.category, run.limits) for f in inputs]
    ):
        answers[number] = run.heard(answer)
    first: dict[str, str] = {}
    older = run.library.by_input()
    for number, one in enumerate(inputs):
        if isinstance(answer := answers[number], Survey):
            run.order.setdefault(_name(answer), one.source)
    for number, one in enumerate(inputs):
        answer = answers[number]
        if isinstance(answer, WorkerFailure):
            answer = Rejected(FAILURE_CODES[answer.reason], answer.text)
        if isinstance(answer, Rejected):
            yield run.refuse(one, answer.code, answer.says)
        elif answer.sha256 in first:
            yield run.refuse(one, TWIN, f"same bytes as {first[answer.sha256]}; remove one of them")
        else:
            first[answer.sha256] = one.source.path
            run.unread.is_readable(one)
            yield from _due(run, one, answer, older, options)


def _due(
    run: _Run, one: Found, survey: Survey, older: dict[str, tuple[Path, ...]], options: Options
) -> Iterator[Event]:
    """An event where the verdict on these bytes is known; else one more job."""
    asset_id = _name(survey)
    entries = older.get(survey.sha256[:10], ())
    ruling = run.ruling(survey)
    known = verdict(entries, asset_id, ruled(run.mark, ruling))
    if known is None or (options.keep_duplicates and known.code == COPY):
        run.todo.append(Job(one, survey, asset_id, options.library, run.limits, entries, ruling))
    else:
        kept = Event("kept", len(run.found), one.source.path, asset_id, known.code, known.says)
        yield Event(**{**vars(kept), "was_rejected": not known.accepted, "warnings": known.warnings})


def _name(survey: Survey) -> str:
    return f"{survey.category}_{survey.sha256[:10]}"


def _work(run: _Run, pool: Pool) -> Iterator[Event]:
    if not run.todo:
        return
    pool.prepare("casa_assets.pipeline.worker:warm")
    for _, answer in pool.run("casa_assets.pipeline.worker:probe", [None]):
        _check_aborted(answer)
    total = len(run.found)
    for number, answer in pool.run("casa_assets.pipeline.worker:work", run.todo):
        _check_aborted(answer)
        job = run.todo[number]
        path = job.found.source.path
        if isinstance(answer, WorkerFailure):
            code = FAILURE_CODES[answer.reason]
            refuse(run.library, job, Rejected(code, answer.message))
            yield Event("rejected", total, path, job.asset_id, code, answer.text, was_rejected=True)
            continue
        assert isinstance(answer, Outcome)
        kind = "accepted" if answer.accepted else "rejected"
        refused = not answer.accepted
        yield Event(kind, total, path, job.asset_id, answer.code, answer.says, refused, answer.warnings)


def _check_aborted(answer: object) -> None:
    if isinstance(answer, RunAborted):
        raise CasaError(answer.message)


def tally(events: Sequence[Event]) -> Counter[str]:
    """How many were accepted, rejected and kept; `refused` counts rejections new and old."""
    counts = Counter(e.kind for e in events)
    counts["refused"] = sum(e.was_rejected for e in events)
    return counts
