"""Ingest sources into a library: discover, survey, leave out copies, work on what is missing, write the reports."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence, Set
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory

from casa_assets import registry
from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.cache.store import Store
from casa_assets.errors import Rejected
from casa_assets.ingest.run.deduplicator import NEAR_DUPLICATE_CODE as COPY
from casa_assets.ingest.run.deduplicator import Deduplicator
from casa_assets.ingest.run.inputs import MeshInput, UnreadableInputs, discover_inputs, stage_meshes, write_if_changed
from casa_assets.ingest.run.job import (
    FAILURE_CODES,
    Answers,
    Job,
    Result,
    SurveyTable,
    WorkerAnswers,
    limits_in_key,
    stage_refusal,
    with_overrides,
)
from casa_assets.ingest.run.resume import (
    RETRIED_CODES,
    AcceptedAsset,
    NewResult,
    cached_outcome,
    find_accepted,
    reason_to_keep,
    remember,
    remembered,
)
from casa_assets.ingest.run.shards import Recorder, Shard, ShardHeader, check_is_no_shard, made_by
from casa_assets.ingest.run.survey import Survey, taken_apart
from casa_assets.ingest.run.survey import warm as warm_survey
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.ingest.sources.places import StoreRoot
from casa_assets.library import clip, review
from casa_assets.library import library as disk
from casa_assets.library.entry import Entry, RefusedRows, is_below, remainder_message, row_id
from casa_assets.library.entry_files import picture_of
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.library import Identity, Producer
from casa_assets.library.library_report import write_reports
from casa_assets.model.issue import Decision, Report, subjects_to_decide
from casa_assets.model.source import NO_OVERRIDE, UserOverride
from casa_assets.runs.limits import Limits, WorkerFailure
from casa_assets.runs.outcome import Event, Outcome, writing
from casa_assets.runs.pool import Workers, open_engine

REJECTED = Decision.REJECTED
DUPLICATE_CODE = "RUN006"


@dataclass(frozen=True)
class Options:
    """Options of an ingest run.

    Attributes:
        library: output folder. category: id for all inputs, or empty.
        jobs: processes at once (0: one per core), or a Ray cluster.
        seconds: processor time for one input, with all that is started for it; 0: the value of registry/limits.yaml.
        memory_bytes: memory of one input; 0: the same.
        guards: limits on inputs that this run sets in place of those in registry/limits.yaml, by their names there.
        weights: of CLIP, see library.clip; empty: pictures are not checked.
        keep_duplicates: keep assets with the form, size and colours of another asset, too.
        split: a file that holds several objects becomes one asset for each.
        again: codes of rejections, and subjects of review such as `scale`: entries of the library that have one of them
            are worked on again; all others are kept. only: the same, and all other inputs are left out.
        force: work on all inputs again, and replace accepted assets also by results that are in review or rejected.
        dry_run: say what would become of each input, and write nothing.
        shard: work on the inputs of this part of the run alone, for `shards.merge`; None: on all. Copies stay: which
            of two is the first is known once all inputs are there.
        refused: inputs that are rejected without being looked for, in addition to those under the roots.
    """

    library: Path
    category: str = ""
    jobs: Workers = 0
    seconds: float = 0.0
    memory_bytes: int = 0
    guards: Mapping[str, float] = field(default_factory=dict)
    weights: str = ""
    keep_duplicates: bool = False
    split: bool = False
    again: frozenset[str] = frozenset()
    only: frozenset[str] = frozenset()
    dry_run: bool = False
    shard: Shard | None = None
    refused: tuple[Refused, ...] = ()
    force: bool = False

    @property
    def replaces_accepted(self) -> bool:
        """True if a worse result replaces an accepted asset; in a shard, as a merge needs the newest results."""
        return self.force or self.shard is not None

    @property
    def keeps_copies(self) -> bool:
        """True if this run does not look for copies."""
        return self.keep_duplicates or self.shard is not None

    @property
    def limits(self) -> dict[str, float]:
        """Limits of the registry with what this run changes of them, by their names."""
        return {**registry.load().limits, **self.guards}

    @property
    def redone(self) -> frozenset[str]:
        """Codes and subjects whose inputs are worked on again."""
        return self.again | self.only


@dataclass
class _Run:
    """State of one run: its inputs, the work to be done, and the refusals that have no bytes.

    Attributes:
        library: written to. before: the library with the results of earlier runs; they differ in a dry run only.
        table: the entries of `before` as the run begins. left_out: numbers of inputs that this run leaves as they are
            and does not report. steps: inputs that could be read, in their order: a job to do, or an accepted asset
            that exists already. older: folders of the entries of `before`, see `by_input`.
    """

    library: disk.Library
    before: disk.Library
    table: EntryTable
    cache_key: str
    limits: Mapping[str, float]
    found: Sequence[Found]
    total: int = 0
    left_out: set[int] = field(default_factory=set)
    steps: list[Job | Result] = field(default_factory=list)
    unreadable: UnreadableInputs = field(default_factory=UnreadableInputs)
    overrides: dict[str, UserOverride] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.older = self.before.by_input()
        self.known = {self.before.root / entry.path: entry for entry in self.table.entries}

    def leave_out_all_but(self, codes: Set[str]) -> None:
        """Leave out what was not rejected for one of some codes and is not in review for one of some subjects.

        Of a file that is taken apart now and was not before, all things are worked on.
        """
        places = {entry.source_path for entry in self.table.entries if _is_redone(entry, codes)}
        names = [(one.source.place, one.source.path) for one in self.found]
        self.left_out = {number for number, name in enumerate(names) if places.isdisjoint(name)}

    def override(self, survey: Survey) -> UserOverride:
        """The override that a person gave for an input."""
        return self.overrides.get(survey.sha256, NO_OVERRIDE)

    def decided(self, survey: Survey) -> Survey:
        """A survey without the files that it looked at, with the category that a person decided, where one did."""
        survey = replace(survey, looked_at=())
        if not (name := self.override(survey).category):
            return survey
        return replace(survey, category=name, confidence=1.0, reason=f"a person decided, in {review.NAME}")

    def refuse(self, one: Found, code: str, message: str) -> Event:
        """Remember an input that never became a bundle."""
        refusal = self.unreadable.refusal(one, code, message, self.cache_key)
        is_new = write_if_changed(self.library, refusal, self.before)
        kind = "rejected" if is_new else "kept"
        folder = self.library.refusal_folder(refusal.id) if self.library is self.before else None
        return Event(kind, self.total, refusal.source.place, refusal.id, code, message, REJECTED, folder=folder)


def ingest(
    roots: Sequence[Path | StoreRoot],
    options: Options,
    meshes: Sequence[MeshInput] = (),
    others: Counter[str] | None = None,
    show_work: Callable[[str], None] | None = None,
) -> Generator[Event, None, None]:
    """Bring every mesh under `roots`, and meshes that the caller has in memory, into the library, or record why not.

    Yields an Event for each input, as it is done with. Killed at any moment and run again, it does what is missing.
    Where there is no input, nothing is written. `others` counts the files that are no meshes, by what they are.
    `show_work` is called with the path of each input that is begun to be worked on.

    Raises:
        UnknownId: the ordered category does not exist.
        OutputError: the library cannot be written to, or another run holds it.
        CasaError: this machine cannot make assets: no worker starts, or none can draw; or it lacks the weights of CLIP.
    """
    known = registry.load()
    if options.weights:
        clip.require_weights(options.weights)
    for category in {options.category, *(mesh.category for mesh in meshes)} - {""}:
        known.category(category)
    discovered = discover_inputs(roots, options.library, others)
    inputs: Iterator[Found | Refused] = chain(options.refused, discovered)
    first = next(inputs, None)
    if first is None and not meshes:
        return
    with ExitStack() as stack:
        before = library = disk.Library(options.library)
        if options.dry_run:
            library = disk.Library(Path(stack.enter_context(TemporaryDirectory(prefix="casa-assets-"))))
        open_library(library, stack)
        every: Iterable[Found | Refused]
        every = chain([] if first is None else [first], inputs, stage_meshes(meshes, library.staging))
        table = EntryTable(before, skip_damaged=True, read_only=options.dry_run)
        places: list[Path | StoreRoot] = [*roots, *(Path(mesh.name) for mesh in meshes)]
        recorder = _recorder(before, table, places, options)
        if recorder is not None and not options.dry_run:
            recorder.begin()
        seconds = options.seconds or known.limits["input_seconds"]
        bounds = Limits(seconds, options.memory_bytes or int(known.limits["input_memory_bytes"]))
        with open_engine(options.jobs, bounds, warm_survey, library.private) as pool:
            if any(isinstance(root, StoreRoot) for root in roots):
                pool.prepare("casa_assets.ingest.sources.stores:warm")
            surveys = SurveyTable(before.cache, options.category, options.limits, options.dry_run)
            answers: Answers = WorkerAnswers(pool, surveys, options.limits, show_work)
            if recorder is not None:
                every, answers = recorder.own(every), recorder.noting(answers)
            yield from ingest_inputs(library, table, every, answers, options, partial(is_below, places))
        if options.dry_run:
            return
        write_reports(library, options.weights, table)
        if recorder is not None:
            recorder.end()


def open_library(library: disk.Library, stack: ExitStack) -> None:
    """Hold a library for writing until the stack is left, and remove what a killed run left half-written."""
    stack.enter_context(library.locked())
    stack.enter_context(writing(library.root))
    stack.callback(library.sweep)
    library.sweep()
    Store(library.cache).sweep()


def _recorder(
    library: disk.Library, table: EntryTable, roots: Sequence[Path | StoreRoot], options: Options
) -> Recorder | None:
    """Return the recorder that limits the run to its shard, or None for a run on all inputs. Raises OutputError."""
    if options.shard is None:
        check_is_no_shard(library)
        return None
    header = ShardHeader(
        index=options.shard.index,
        count=options.shard.count,
        is_complete=False,
        category=options.category,
        split=options.split,
        keep_duplicates=options.keep_duplicates,
        limits=dict(sorted(options.limits.items())),
        cache_key=cache_key(options.limits, options.category),
        made_by=made_by(),
        roots=tuple(str(root.absolute() if isinstance(root, Path) else root) for root in roots),
    )
    return Recorder(table, header)


def ingest_inputs(
    library: disk.Library,
    table: EntryTable,
    inputs: Iterable[Found | Refused],
    answers: Answers,
    options: Options,
    is_looked_at: Callable[[str], bool],
) -> Generator[Event, None, None]:
    """Work on all inputs; yields an Event for each when it is done.

    `table`: entries of the library with the results of earlier runs, a different one in a dry run. `is_looked_at`: True
    for a file, as its source calls it, that the inputs were searched in.
    """
    before = library if table.root == library.root else disk.Library(table.root)
    overrides = review.read_overrides(before)
    refused = RefusedRows(before)
    found, early = inputs_with_mesh(inputs, refused)
    if options.split:
        found, digests = taken_apart(found, answers.things(found))
        # What an earlier run made of the whole files is taken away.
        for folder in (f for sha256 in digests for f in library.entries_of(Identity(Producer.INGEST, sha256))):
            library.forget(folder)
    key = cache_key(options.limits, options.category)
    run = _Run(library, before, table, key, options.limits, found, overrides=overrides)
    if options.only:
        run.leave_out_all_but(options.only)
        early = [(event, one) for event, one in early if event.code in options.only]
    run.total = total = len(found) - len(run.left_out) + sum(event.count for event, _ in early)
    for event, one in early:
        yield replace(event, total=total)
        run.unreadable.note_refused(one)
    yield from _survey(run, answers, options)
    results, publish = _results(run, answers, options.replaces_accepted), partial(_publish_outcome, run)
    if not options.keeps_copies:
        own = frozenset((step if isinstance(step, Job) else step.job).survey.sha256 for step in run.steps)
        yield from Deduplicator(library, registry.load().limits["alike_form"], own, table).publish(results, publish)
    else:
        yield from map(publish, results)
    if options.dry_run:
        return
    run.unreadable.prune(library)
    if not options.only:
        refused.write(is_looked_at)


def _is_redone(entry: Entry | None, codes: Set[str]) -> bool:
    return entry is not None and not codes.isdisjoint((entry.code, *entry.to_decide))


def inputs_with_mesh(
    inputs: Iterable[Found | Refused], refused: RefusedRows
) -> tuple[list[Found], list[tuple[Event, Refused]]]:
    """The inputs that have a mesh, and events of all others: one each for the first of a file, one for the rest."""
    found: list[Found] = []
    events: list[tuple[Event, Refused]] = []
    for one in inputs:
        if isinstance(one, Found):
            found.append(one)
        elif name := refused.add(one):
            kind = "kept" if refused.was_known(one) else "rejected"
            events.append((Event(kind, 0, one.path, name, one.code, one.message, REJECTED), one))
    for path, code, count in refused.rest():
        message = remainder_message(count)
        kind = "kept" if refused.was_counted(path, code, count) else "rejected"
        event = Event(kind, 0, path, row_id(path, code), code, message, REJECTED, count=count)
        events.append((event, Refused(path, code, message)))
    return found, events


def _survey(run: _Run, answers: Answers, options: Options) -> Generator[Event, None, None]:
    """Digest every input, detect inputs with the same bytes, and yield an event for all rejected before any work."""
    inputs = run.found
    surveys = {
        number: run.decided(answer) if isinstance(answer, Survey) else answer
        for number, answer in answers.surveys(inputs)
    }
    first: dict[str, str] = {}
    for number, one in enumerate(inputs):
        answer = surveys[number]
        if isinstance(answer, Survey) and answer.sha256 not in first:
            first[answer.sha256] = one.source.place
            if number not in run.left_out:
                run.unreadable.note_readable(one)
                yield from _due(run, one, answer, options)
        elif number in run.left_out:
            continue
        elif isinstance(answer, Survey):
            yield run.refuse(one, DUPLICATE_CODE, f"same bytes as {first[answer.sha256]}; remove one of them")
        elif isinstance(answer, WorkerFailure):
            yield run.refuse(one, FAILURE_CODES[answer.reason], answer.text)
        else:
            yield run.refuse(one, answer.code, answer.message)


def _due(run: _Run, one: Found, survey: Survey, options: Options) -> Iterator[Event]:
    """An event where an earlier run rejected these bytes; else one more step."""
    identity = Identity(Producer.INGEST, survey.sha256)
    asset_id = identity.asset_id(survey.category)
    entries = run.older.get(identity.suffix, ())
    override = run.override(survey)
    key = with_overrides(run.cache_key, override)
    found = cached_outcome(entries, asset_id, key, run.known)
    job = Job(one, survey, asset_id, run.library.root, run.limits, key, override)
    is_redone = any(_is_redone(run.known.get(folder), options.redone) for folder in entries)
    if found is None and not options.replaces_accepted and (kept := _kept_before(run, job, entries)) is not None:
        run.steps.append(replace(kept, number=len(run.steps)))
        return
    if found is None or is_redone or options.force or (options.keeps_copies and found[1].code == COPY):
        run.steps.append(job)
        return
    current, known = found
    for folder in entries if run.library is run.before else ():
        if folder != current:  # a run was killed after it had put the current one in place
            run.library.forget(folder)
    if known.accepted:
        run.steps.append(Result(len(run.steps), job, known, current, is_kept=True))
    else:
        yield _event(run, Result(0, job, known, is_kept=True))


def cache_key(limits: Mapping[str, float], category: str = "") -> str:
    """The key of what ingest makes of an input, besides the input and what a person decided about it."""
    return digest_of("ingest", key_of("casa_assets.ingest.run.steps:work"), limits_in_key(limits), category)


def _results(run: _Run, answers: Answers, replaces_accepted: bool) -> Iterator[Result]:
    """Yield the result of every step: those of earlier runs first, then the others as they are done."""
    yield from (step for step in run.steps if isinstance(step, Result))
    due = {number: step for number, step in enumerate(run.steps) if isinstance(step, Job)}
    if not due:
        return
    numbers, jobs = list(due), list(due.values())
    for place, outcome in answers.outcomes(jobs):
        result = Result(numbers[place], jobs[place], outcome, outcome.staged if outcome.accepted else None)
        yield result if replaces_accepted else _or_accepted(run, result)


def _kept_before(run: _Run, job: Job, entries: Sequence[Path]) -> Result | None:
    """Return the accepted asset that an earlier run kept in place of its result under this key, or None."""
    accepted = find_accepted(entries, job.cache_key)
    if accepted is None:
        return None
    reason = remembered(run.before, Identity(Producer.INGEST, job.survey.sha256), job.cache_key, accepted)
    return _kept_result(run, Result(0, job, Outcome(True)), accepted, reason) if reason else None


def _or_accepted(run: _Run, result: Result) -> Result:
    """The accepted asset of the same input where that is better than a new result, else the result."""
    job, outcome = result.job, result.outcome
    identity = Identity(Producer.INGEST, job.survey.sha256)
    accepted = find_accepted(run.older.get(identity.suffix, ()), job.cache_key)
    new = NewResult(outcome.decision, outcome.code, subjects_to_decide(outcome.warnings))
    reason = "" if accepted is None else reason_to_keep(accepted, new)
    if accepted is None or not reason:
        return result
    if run.library is run.before and outcome.code not in RETRIED_CODES:
        remember(run.library, identity, job.cache_key, accepted, reason)
    if outcome.staged is not None:
        shutil.rmtree(outcome.staged.parent)
    return _kept_result(run, result, accepted, reason)


def _kept_result(run: _Run, result: Result, accepted: AcceptedAsset, reason: str) -> Result:
    """The result of an input whose accepted asset is kept."""
    entry = run.known.get(accepted.folder)
    warnings = () if entry is None else entry.warnings
    outcome = Outcome(True, message=reason, warnings=warnings)
    return replace(result, outcome=outcome, folder=accepted.folder, is_kept=True)


def _publish_outcome(run: _Run, result: Result) -> Event:
    """Publish the decision on an input, and return its event."""
    job, outcome, library = result.job, result.outcome, run.library
    identity = Identity(Producer.INGEST, job.survey.sha256)
    # Entries that a dry run knows of stand in another library, and nothing is taken away there.
    older = run.older.get(identity.suffix, ()) if run.library is run.before else ()
    if outcome.accepted and outcome.staged is not None:
        library.publish(outcome.staged, library.folder(job.survey.category, job.asset_id), older, identity)
    elif not outcome.accepted:
        staged = outcome.staged or _stage_refusal(library, result)
        library.publish(staged, library.refusal_folder(job.asset_id), older, identity)
    return _event(run, result)


def _stage_refusal(library: disk.Library, result: Result) -> Path:
    """The staged entry of an input that its worker did not refuse: the worker died, or the asset is a copy."""
    outcome, folder = result.outcome, result.folder
    report: Report | None = None
    picture: bytes | None = None
    if folder is not None:
        report = disk.read_certificate(folder).report
        picture = picture_of(folder) or None
        if folder.is_relative_to(library.staging):
            shutil.rmtree(folder.parent)
    return stage_refusal(library, result.job, Rejected(outcome.code, outcome.message), report, picture, result.twin)


def _event(run: _Run, result: Result) -> Event:
    job, outcome = result.job, result.outcome
    kind = "kept" if result.is_kept else outcome.decision.value
    path, refused = job.found.source.place, not outcome.accepted
    message = f"{outcome.message}\n{outcome.trace}" if outcome.trace else outcome.message
    library = run.before
    folder = library.refusal_folder(job.asset_id) if refused else library.folder(job.survey.category, job.asset_id)
    if result.is_kept and not refused and result.folder is not None:
        folder = result.folder  # under another category where it is better than a new result
    is_there = result.is_kept or run.library is run.before
    return Event(
        kind,
        run.total,
        path,
        folder.name,
        outcome.code,
        message,
        outcome.decision,
        outcome.warnings,
        folder=folder if is_there else None,
        summary=_summary(run, result),
    )


def _summary(run: _Run, result: Result) -> disk.Summary | None:
    """Numbers of an asset that is in its place: of a kept one as the table of entries has them."""
    if not result.outcome.accepted:
        return None
    if result.is_kept and result.folder is not None:
        entry = run.known.get(result.folder)
        return None if entry is None else entry.summary
    if (manifest := result.outcome.manifest) is not None:
        return manifest.certificate.summary
    folder = run.library.folder(result.job.survey.category, result.job.asset_id)
    return disk.read_certificate(folder).summary


def tally(events: Sequence[Event]) -> Counter[str]:
    """Count inputs by decision, new and old; `kept` counts what was there already, `all` everything."""
    counts: Counter[str] = Counter()
    for event in events:
        counts[event.decision.value] += event.count
        counts["kept"] += event.count * (event.kind == "kept")
        counts["all"] += event.count
    return counts
