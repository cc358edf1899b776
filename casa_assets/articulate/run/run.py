"""Articulate all meshes under folders and files into a library, many at once; what is done is not done again.

`runs/engine.py` has what all runs over inputs share; the work on one mesh is in `steps.py`. A run that is killed at any
moment and started again does what is missing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from pathlib import Path
from types import MappingProxyType

from casa_assets import registry
from casa_assets.articulate.decisions import Decisions
from casa_assets.articulate.run.build import ArticulateRequest, with_override
from casa_assets.articulate.run.steps import (
    ArticulateOutcome,
    EntryKey,
    articulate_one,
    entry_key,
    is_missing,
    kept_outcome,
    publish_refusal,
)
from casa_assets.errors import CasaError, Rejected
from casa_assets.ingest.run.inputs import WARM, Survey, SurveyTable, discover_inputs, warm_survey
from casa_assets.ingest.sources.places import Found
from casa_assets.library import review
from casa_assets.library.entry import is_below
from casa_assets.library.entry_files import Producer
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.library import Library
from casa_assets.library.mesh_decisions import keep_mesh_decisions, mesh_decisions
from casa_assets.model.source import NO_OVERRIDE
from casa_assets.runs.engine import (
    InputRun,
    open_library,
)
from casa_assets.runs.limits import Limits, WorkerFailure
from casa_assets.runs.outcome import FAILURE_CODES, Event, RunAborted
from casa_assets.runs.pool import Engine, Workers, open_engine

# Makes the request for an input.
RequestMaker = Callable[[Found], ArticulateRequest]
NO_DECISIONS: Mapping[str, Decisions] = MappingProxyType({})


@dataclass(frozen=True)
class _Job:
    """A mesh that has to be worked on."""

    found: Found
    request: ArticulateRequest
    key: EntryKey


def articulate(
    roots: Sequence[Path],
    out: Path,
    request_for: RequestMaker,
    jobs: Workers = 0,
    others: Counter[str] | None = None,
    working: Callable[[Sequence[str]], None] | None = None,
    decisions: Mapping[str, Decisions] = NO_DECISIONS,
) -> Generator[ArticulateOutcome, None, None]:
    """Articulate every mesh under `roots`, each in a child process with limits; yield an outcome for each as it ends.

    Where there is no input, nothing is written.

    Args:
        jobs: processes at once (0: one per core), or a Ray cluster.
        others: counts the files that are no meshes, by what they are.
        working: is called with the names of the meshes that are being worked on whenever another one is begun.
        decisions: by the sha256 of meshes; they are kept in the library, and this and later runs obey them.
    """
    inputs = discover_inputs(roots, out, others)
    first = next(inputs, None)
    if first is None:
        return
    library = Library(out)
    with ExitStack() as stack:
        open_library(library, stack)
        keep_mesh_decisions(library, decisions)
        table = EntryTable(library, skip_damaged=True)
        run = InputRun[Survey](library, table, Producer.ARTICULATE, chain([first], inputs))
        for outcome in _outcomes(run, request_for, jobs, working or (lambda _: None)):
            one = outcome if isinstance(outcome, ArticulateOutcome) else _outcome_of(outcome)
            yield replace(one, total=run.total)
        run.prune()
        run.refused_rows.write(partial(is_below, roots))
        review.write(library, EntryTable(library, skip_damaged=True).entries)


def _outcome_of(event: Event) -> ArticulateOutcome:
    kept = event.kind == "kept"
    return ArticulateOutcome(
        Path(event.path), event.folder, code=event.code, message=event.message, kept=kept, count=event.count
    )


def _outcomes(
    run: InputRun[Survey], request_for: RequestMaker, jobs: Workers, working: Callable[[Sequence[str]], None]
) -> Iterator[Event | ArticulateOutcome]:
    """Yield the outcomes of all inputs: those that have no mesh, those that are known, then the others as they end."""
    yield from run.refused_early()
    limits = dict(registry.load().limits)
    bounds = Limits(limits["input_seconds"], int(limits["input_memory_bytes"]))
    decided = mesh_decisions(run.library)
    due: list[_Job] = []

    def known_or_due(one: Found, survey: Survey) -> Iterator[ArticulateOutcome]:
        request = _with_review(request_for(one), decided.get(survey.sha256, Decisions()))
        request = with_override(request, run.overrides.get(survey.sha256, NO_OVERRIDE))
        key = entry_key(request, survey.sha256, one.source)
        entries = run.older.get(key.identity.suffix, ())
        kept = None if request.force else kept_outcome(request, key, entries, run.known)
        if kept is None or (request.preview and is_missing(kept)):
            due.append(_Job(one, request, key))
        else:
            yield kept

    with open_engine(jobs, bounds, warm_survey, run.library.private) as pool:
        yield from run.over(SurveyTable(run.library.cache, "", limits).survey(run.found, pool), known_or_due)
        if due:
            pool.prepare(WARM)
            yield from _worked_on(due, pool, working)


def _with_review(request: ArticulateRequest, given: Decisions) -> ArticulateRequest:
    """Return a request with what a person decided about its mesh, which goes before the options of all meshes.

    A decisions.yaml that is given for the mesh in this run goes before both.
    """
    if request.decisions != Decisions():
        return request
    return replace(
        request,
        decisions=given,
        category=request.category if given.category is None else "",
        up=request.up if given.up is None else None,
        front=request.front if given.front is None else None,
        size_m=request.size_m if given.size_m is None else 0.0,
    )


def _worked_on(
    due: Sequence[_Job], pool: Engine, working: Callable[[Sequence[str]], None]
) -> Iterator[ArticulateOutcome]:
    """Yield the outcome of each mesh as a worker is done with it. Raises CasaError where the run has to end."""
    busy: dict[int, str] = {}

    def begin(number: int) -> None:
        busy[number] = due[number].found.source.place
        working(tuple(busy.values()))

    for number, answer in pool.run(articulate_one, [job.request for job in due], begin):
        busy.pop(number, None)
        if isinstance(answer, RunAborted):
            raise CasaError(answer.message)
        if isinstance(answer, WorkerFailure):
            job, error = due[number], Rejected(FAILURE_CODES[answer.reason], answer.text)
            yield publish_refusal(job.request, job.key, job.found.source, error)
        else:
            assert isinstance(answer, ArticulateOutcome)
            yield answer
