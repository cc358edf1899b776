"""Articulate all meshes under folders and files into a library, many at once; what is done is not done again.

Inputs are found, digested and refused as `ingest` does it (`ingest/run`). A run that is killed at any moment and
started again does what is missing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from pathlib import Path
from types import MappingProxyType

from casa_assets import registry
from casa_assets.articulate.decisions import Decisions
from casa_assets.articulate.run import steps as run
from casa_assets.articulate.run.build import ArticulateRequest, with_override
from casa_assets.articulate.run.steps import ArticulateOutcome, EntryKey, entry_key, kept_outcome, publish_refusal
from casa_assets.cache.store import Store
from casa_assets.errors import CasaError, Rejected
from casa_assets.ingest.run.inputs import UnreadableInputs, discover_inputs, write_if_changed
from casa_assets.ingest.run.job import FAILURE_CODES, SurveyTable, warm_workers
from casa_assets.ingest.run.run import DUPLICATE_CODE, inputs_with_mesh
from casa_assets.ingest.run.survey import Survey
from casa_assets.ingest.run.survey import warm as warm_survey
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.library import decisions as review_file
from casa_assets.library import library as disk
from casa_assets.library import review
from casa_assets.library.entry import RefusedRows, is_below
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.library import Producer
from casa_assets.model.source import NO_OVERRIDE
from casa_assets.runs.limits import Limits, WorkerFailure
from casa_assets.runs.outcome import RunAborted, writing
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
        roots: files, folders, archives, manifests. out: the library.
        jobs: processes at once (0: one per core), or a Ray cluster.
        others: counts the files that are no meshes, by what they are.
        working: is called with the names of the meshes that are being worked on whenever another one is begun.
        decisions: by the sha256 of meshes; they are kept in the library, and this and later runs obey them.
    Raises:
        CasaError: what is asked for does not exist, or this machine cannot start a worker or draw.
        OutputError: the library cannot be written to, or another run holds it.
    """
    inputs = discover_inputs(roots, out, others)
    first = next(inputs, None)
    if first is None:
        return
    library = disk.Library(out)
    with library.locked(), writing(library.root):
        library.sweep()
        Store(library.cache).sweep()
        review_file.keep(library, decisions)
        try:
            yield from _run(library, roots, chain([first], inputs), request_for, jobs, working or (lambda _: None))
        finally:
            library.sweep()


def _run(
    library: disk.Library,
    roots: Sequence[Path],
    inputs: Iterable[Found | Refused],
    request_for: RequestMaker,
    jobs: Workers,
    working: Callable[[Sequence[str]], None],
) -> Iterator[ArticulateOutcome]:
    """Yield the outcomes of all inputs: those that have no mesh, those that are known, then the others as they end."""
    limits = dict(registry.load().limits)
    refused, unreadable = RefusedRows(library), UnreadableInputs(Producer.ARTICULATE)
    found, early = inputs_with_mesh(inputs, refused)
    total = len(found) + sum(event.count for event, _ in early)
    for event, one in early:
        unreadable.note_refused(one)
        yield ArticulateOutcome(
            Path(event.path),
            code=event.code,
            message=event.message,
            kept=event.kind == "kept",
            total=total,
            count=event.count,
        )
    due: list[_Job] = []
    bounds = Limits(limits["input_seconds"], int(limits["input_memory_bytes"]))
    with open_engine(jobs, bounds, warm_survey, library.private) as pool:
        answers = dict(SurveyTable(library.cache, "", limits).survey(found, pool))
        for step in _known_or_due(library, found, answers, unreadable, request_for):
            if isinstance(step, _Job):
                due.append(step)
            else:
                yield replace(step, total=total)
        if due:
            pool.prepare(warm_workers)
            for outcome in _worked_on(due, pool, working):
                yield replace(outcome, total=total)
    unreadable.prune(library)
    refused.write(partial(is_below, roots))
    review.write(library, EntryTable(library, skip_damaged=True).entries)


def _known_or_due(
    library: disk.Library,
    found: Sequence[Found],
    answers: Mapping[int, Survey | Rejected | WorkerFailure],
    unreadable: UnreadableInputs,
    request_for: RequestMaker,
) -> Iterator[_Job | ArticulateOutcome]:
    """Yield for each input what earlier runs made of it, why it cannot be read, or what is to be done."""
    known = {library.root / entry.path: entry for entry in EntryTable(library, skip_damaged=True).entries}
    older, decided = library.by_input(), review_file.decided(library)
    overrides = review.read_overrides(library)
    first: dict[str, str] = {}
    for number, one in enumerate(found):
        answer = answers[number]
        if isinstance(answer, Survey) and answer.sha256 not in first:
            first[answer.sha256] = one.source.place
            unreadable.note_readable(one)
            request = _with_review(request_for(one), decided.get(answer.sha256, Decisions()))
            request = with_override(request, overrides.get(answer.sha256, NO_OVERRIDE))
            key = entry_key(request, answer.sha256, one.source)
            entries = older.get(key.identity.suffix, ())
            kept = None if request.anew else kept_outcome(request, key, entries, known)
            is_due = kept is None or (request.preview and run.is_missing(kept))
            yield _Job(one, request, key) if kept is None or is_due else kept
            continue
        if isinstance(answer, Survey):
            code, message = DUPLICATE_CODE, f"same bytes as {first[answer.sha256]}; remove one of them"
        elif isinstance(answer, WorkerFailure):
            code, message = FAILURE_CODES[answer.reason], answer.text
        else:
            code, message = answer.code, answer.message
        refusal = unreadable.refusal(one, code, message, "")
        is_new = write_if_changed(library, refusal)
        folder = library.refusal_folder(refusal.id)
        yield ArticulateOutcome(Path(one.source.place), folder, code=code, message=message, kept=not is_new)


def _with_review(request: ArticulateRequest, said: Decisions) -> ArticulateRequest:
    """Return a request with what a person decided about its mesh, which goes before the options of all meshes.

    A decisions.yaml that is given for the mesh in this run goes before both.
    """
    if request.decisions != Decisions():
        return request
    return replace(
        request,
        decisions=said,
        category=request.category if said.category is None else "",
        up=request.up if said.up is None else None,
        front=request.front if said.front is None else None,
        size_m=request.size_m if said.size_m is None else 0.0,
    )


def _worked_on(
    due: Sequence[_Job], pool: Engine, working: Callable[[Sequence[str]], None]
) -> Iterator[ArticulateOutcome]:
    """Yield the outcome of each mesh as a worker is done with it. Raises CasaError where the run has to end."""
    busy: dict[int, str] = {}

    def begin(number: int) -> None:
        busy[number] = due[number].found.source.place
        working(tuple(busy.values()))

    requests = [job.request for job in due]
    for number, answer in pool.run(run.articulate_one, requests, begin):
        busy.pop(number, None)
        job = due[number]
        if isinstance(answer, RunAborted):
            raise CasaError(answer.message)
        if isinstance(answer, WorkerFailure):
            error = Rejected(FAILURE_CODES[answer.reason], answer.text)
            yield publish_refusal(job.request, job.key, job.found.source, error)
        else:
            assert isinstance(answer, ArticulateOutcome)
            yield answer
