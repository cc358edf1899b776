"""Ingest sources into a library: discover, survey, leave out copies, work on what is missing, write the reports.

`runs/engine.py` has what all runs over inputs share; the work on one input is in `steps.py`.
"""

from __future__ import annotations

import os
import shutil
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence, Set
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

from casa_assets import registry
from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.cache.store import Store
from casa_assets.checks.library import SAME_SIZE, ShapePair
from casa_assets.errors import OutputError, Rejected
from casa_assets.ingest.run import shards
from casa_assets.ingest.run.inputs import (
    WORK,
    Answers,
    HeldThings,
    Job,
    MeshInput,
    Result,
    Survey,
    SurveyTable,
    WorkerAnswers,
    discover_inputs,
    limits_in_key,
    stage_meshes,
    stage_refusal,
    taken_apart,
    warm_survey,
    with_overrides,
)
from casa_assets.ingest.sources.places import Found, Refused, StoreRoot
from casa_assets.library import clip, review
from casa_assets.library.entry import Entry, is_below
from casa_assets.library.entry_files import Identity, Producer, Summary, picture_of, read_certificate, read_manifest
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.library import Library
from casa_assets.library.library_report import write_reports
from casa_assets.library.pairs import AssetRow, ShapeIndex, measure_pair, row_of
from casa_assets.model.issue import Report, subjects_to_decide
from casa_assets.model.source import NO_OVERRIDE, UserOverride
from casa_assets.runs import engine
from casa_assets.runs.limits import Limits
from casa_assets.runs.outcome import Event, Outcome
from casa_assets.runs.pool import Workers, open_engine

Published = TypeVar("Published")


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
        shard: work on the inputs of this part of the run alone, for `library merge`; None: on all. Copies stay: which
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
    shard: shards.Shard | None = None
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
        before = library = Library(options.library)
        if options.dry_run:
            library = Library(Path(stack.enter_context(TemporaryDirectory(prefix="casa-assets-"))))
        engine.open_library(library, stack)
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
            answers = WorkerAnswers(pool, surveys, options.limits, show_work)
            if recorder is not None:
                every = recorder.own(every)
            is_looked_at = partial(is_below, places)
            yield from ingest_inputs(library, table, every, answers, options, is_looked_at, recorder)
        if options.dry_run:
            return
        write_reports(library, options.weights, table)
        if recorder is not None:
            recorder.end()


def _recorder(
    library: Library, table: EntryTable, roots: Sequence[Path | StoreRoot], options: Options
) -> shards.Recorder | None:
    """Return the recorder that limits the run to its shard, or None for a run on all inputs. Raises OutputError."""
    if options.shard is None:
        if os.path.lexists(library.root / shards.SHARD_FILE):
            shards.check_is_no_shard(library)
        return None
    header = shards.ShardHeader(
        index=options.shard.index,
        count=options.shard.count,
        is_complete=False,
        category=options.category,
        split=options.split,
        keep_duplicates=options.keep_duplicates,
        limits=dict(sorted(options.limits.items())),
        cache_key=cache_key(options.limits, options.category),
        made_by=shards.made_by(),
        roots=tuple(str(root.absolute() if isinstance(root, Path) else root) for root in roots),
    )
    shards.check_shard(table, header)
    return shards.Recorder(Library(table.root), header)


def cache_key(limits: Mapping[str, float], category: str = "") -> str:
    """The key of what ingest makes of an input, besides the input and what a person decided about it."""
    return digest_of("ingest", key_of(WORK), limits_in_key(limits), category)


def ingest_inputs(
    library: Library,
    table: EntryTable,
    inputs: Iterable[Found | Refused],
    answers: Answers,
    options: Options,
    is_looked_at: Callable[[str], bool],
    recorder: shards.Recorder | None = None,
) -> Generator[Event, None, None]:
    """Work on all inputs; yields an Event for each when it is done.

    `table`: entries of the library with the results of earlier runs, a different one in a dry run. `is_looked_at`: True
    for a file, as its source calls it, that the inputs were searched in.
    """
    run = _IngestRun(library, table, inputs, answers, options)
    yield from run.refused_early()
    yield from run.over(answers.surveys(run.found), run.due)
    if recorder is not None:
        recorder.held, recorder.surveys = run.held, run.surveys
    results = run.results()
    if options.keeps_copies:
        yield from map(run.publish, results)
    else:
        own = frozenset((step if isinstance(step, Job) else step.job).survey.sha256 for step in run.steps)
        copies = Deduplicator(library, registry.load().limits["alike_form"], own, table)
        yield from copies.publish(results, run.publish)
    if options.dry_run:
        return
    run.prune()
    if not options.only:
        run.refused_rows.write(is_looked_at)


class _IngestRun(engine.InputRun[Survey]):
    """A run of ingest.

    `held`: things in files that are taken apart, by the number of the file. `steps`: inputs that could be read, in
    their order: a job to do, or an accepted asset that exists already.
    """

    def __init__(
        self,
        library: Library,
        table: EntryTable,
        inputs: Iterable[Found | Refused],
        answers: Answers,
        options: Options,
    ) -> None:
        super().__init__(library, table, Producer.INGEST, inputs, cache_key(options.limits, options.category))
        self.answers, self.options, self.limits = answers, options, options.limits
        self.steps: list[Job | Result] = []
        self.held: Mapping[int, HeldThings] = {}
        if options.split:
            self.held = answers.things(self.found)
            self.found, digests = taken_apart(self.found, self.held)
            # What an earlier run made of the whole files is taken away.
            for sha256 in digests:
                for folder in library.entries_of(Identity(Producer.INGEST, sha256)):
                    library.forget(folder)
        if options.only:
            # What was not rejected for one of these codes and is not in review for one of these subjects is left out.
            # Of a file that is taken apart now and was not before, all things are worked on.
            places = {entry.source_path for entry in table.entries if _is_redone(entry, options.only)}
            names = [(one.source.place, one.source.path) for one in self.found]
            self.left_out = {number for number, name in enumerate(names) if places.isdisjoint(name)}
            self.early = [(event, one) for event, one in self.early if event.code in options.only]

    def due(self, one: Found, survey: Survey) -> Iterator[Event]:
        """An event where an earlier run rejected these bytes; else one more step."""
        identity = Identity(Producer.INGEST, survey.sha256)
        override = self.overrides.get(survey.sha256, NO_OVERRIDE)
        survey = _decided(survey, override)
        asset_id = identity.asset_id(survey.category)
        entries = self.older.get(identity.suffix, ())
        key = with_overrides(self.cache_key, override)
        found = engine.cached_outcome(entries, asset_id, key, self.known)
        job = Job(one, survey, asset_id, self.library.root, self.limits, key, override)
        if found is None and not self.options.replaces_accepted:
            kept = engine.kept_before(self.before, identity, key, entries)
            if kept is not None:
                self.steps.append(self._kept_result(Result(len(self.steps), job, Outcome(True)), kept))
                return
        is_redone = any(
            _is_redone(self.known.get(folder), self.options.again | self.options.only) for folder in entries
        )
        is_wanted_copy = self.options.keeps_copies and found is not None and found[1].code == engine.NEAR_DUPLICATE_CODE
        if found is None or is_redone or self.options.force or is_wanted_copy:
            self.steps.append(job)
            return
        current, known = found
        for folder in entries if self.library is self.before else ():
            if folder != current:  # a run was killed after it had put the current one in place
                self.library.forget(folder)
        if known.accepted:
            self.steps.append(Result(len(self.steps), job, known, current, is_kept=True))
        else:
            yield self._event(Result(0, job, known, is_kept=True))

    def results(self) -> Iterator[Result]:
        """Yield the result of every step: those of earlier runs first, then the others as they are done."""
        yield from (step for step in self.steps if isinstance(step, Result))
        due = [(number, step) for number, step in enumerate(self.steps) if isinstance(step, Job)]
        if not due:
            return
        for place, outcome in self.answers.outcomes([job for _, job in due]):
            number, job = due[place]
            result = Result(number, job, outcome, outcome.staged if outcome.accepted else None)
            yield result if self.options.replaces_accepted else self._or_accepted(result)

    def _or_accepted(self, result: Result) -> Result:
        """The accepted asset of the same input where that is better than a new result, else the result."""
        job, outcome = result.job, result.outcome
        identity = Identity(Producer.INGEST, job.survey.sha256)
        kept = engine.kept_instead(
            self.library,
            identity,
            job.cache_key,
            self.older.get(identity.suffix, ()),
            engine.NewResult(outcome.decision, outcome.code, subjects_to_decide(outcome.warnings)),
            engine.RETRIED_CODES if self.library is self.before else None,
        )
        if kept is None:
            return result
        if outcome.staged is not None:
            shutil.rmtree(outcome.staged.parent)
        return self._kept_result(result, kept)

    def _kept_result(self, result: Result, kept: engine.KeptAsset) -> Result:
        entry = self.known.get(kept.folder)
        outcome = Outcome(True, message=kept.reason, warnings=() if entry is None else entry.warnings)
        return replace(result, outcome=outcome, folder=kept.folder, is_kept=True)

    def publish(self, result: Result) -> Event:
        """Publish the decision on an input, and return its event."""
        job, outcome, library = result.job, result.outcome, self.library
        identity = Identity(Producer.INGEST, job.survey.sha256)
        # Entries that a dry run knows of stand in another library, and nothing is taken away there.
        older = self.older.get(identity.suffix, ()) if self.library is self.before else ()
        if outcome.accepted and outcome.staged is not None:
            library.publish(outcome.staged, library.folder(job.survey.category, job.asset_id), older, identity)
        elif not outcome.accepted:
            staged = outcome.staged or self._stage_refusal(result)
            library.publish(staged, library.refusal_folder(job.asset_id), older, identity)
        return self._event(result)

    def _stage_refusal(self, result: Result) -> Path:
        """The staged entry of an input that its worker did not refuse: the worker died, or the asset is a copy."""
        outcome, folder = result.outcome, result.folder
        report: Report | None = None
        picture: bytes | None = None
        if folder is not None:
            report = read_certificate(folder).report
            picture = picture_of(folder) or None
            if folder.is_relative_to(self.library.staging):
                shutil.rmtree(folder.parent)
        error = Rejected(outcome.code, outcome.message)
        return stage_refusal(self.library, result.job, error, report, picture, result.twin)

    def _event(self, result: Result) -> Event:
        job, outcome, library = result.job, result.outcome, self.before
        folder = library.folder(job.survey.category, job.asset_id)
        if not outcome.accepted:
            folder = library.refusal_folder(job.asset_id)
        elif result.is_kept and result.folder is not None:
            folder = result.folder  # under another category where it is better than a new result
        is_there = result.is_kept or self.library is self.before
        return Event(
            "kept" if result.is_kept else outcome.decision.value,
            self.total,
            job.found.source.place,
            folder.name,
            outcome.code,
            f"{outcome.message}\n{outcome.trace}" if outcome.trace else outcome.message,
            outcome.decision,
            outcome.warnings,
            folder=folder if is_there else None,
            summary=self._summary(result),
        )

    def _summary(self, result: Result) -> Summary | None:
        """Numbers of an asset that is in its place: of a kept one as the table of entries has them."""
        if not result.outcome.accepted:
            return None
        if result.is_kept and result.folder is not None:
            entry = self.known.get(result.folder)
            return None if entry is None else entry.summary
        if (manifest := result.outcome.manifest) is not None:
            return manifest.certificate.summary
        folder = self.library.folder(result.job.survey.category, result.job.asset_id)
        return read_certificate(folder).summary


def _is_redone(entry: Entry | None, codes: frozenset[str]) -> bool:
    return entry is not None and not codes.isdisjoint((entry.code, *entry.to_decide))


def _decided(survey: Survey, override: UserOverride) -> Survey:
    """A survey without the files that it looked at, with the category that a person decided, where one did."""
    survey = replace(survey, looked_at=())
    if not override.category:
        return survey
    return replace(survey, category=override.category, confidence=1.0, reason=f"a person decided, in {review.NAME}")


def tally(events: Sequence[Event]) -> Counter[str]:
    """Count inputs by decision, new and old; `kept` counts what was there already, `all` everything."""
    counts: Counter[str] = Counter()
    for event in events:
        counts[event.decision.value] += event.count
        counts["kept"] += event.count * (event.kind == "kept")
        counts["all"] += event.count
    return counts


# Copies ---------------------------------------------------------------------------------------------------------------


class Deduplicator:
    """Finds copies among the inputs of a run and in its library.

    `limit`: largest distance between the surfaces of copies, as a share of their radius. `own`: sha256 of the inputs of
    this run; their entries in the library are judged in the order of the inputs. `table`: the entries of the library
    from before the run; None: they are read.
    """

    def __init__(
        self, library: Library, limit: float, own: Set[str] = frozenset(), table: EntryTable | None = None
    ) -> None:
        self._library, self._limit, self._own = library, limit, own
        self._entries = table or EntryTable(library, skip_damaged=True)
        self._store = Store(library.cache)
        self._known: list[AssetRow] = []
        self._forms: ShapeIndex | None = None
        # Kept assets that are not among these yet.
        self._deferred: list[Result] = []
        # Of these, what this run made.
        self._fresh: list[AssetRow] = []
        self._fresh_forms = ShapeIndex()

    def publish(self, results: Iterable[Result], publish: Callable[[Result], Published]) -> Iterator[Published]:
        """Publish results, copies as rejections: rejections at once, accepted ones in the order of their inputs.

        `results`: numbered from 0 without gaps, in any order. Results after a missing number are judged at the end.
        `publish`: puts a result in its place, where later ones are compared with it; its answers are yielded.
        """
        finished: dict[int, Result | None] = {}
        next_number = 0
        for result in results:
            if result.outcome.accepted:
                finished[result.number] = result
            else:
                finished[result.number] = None
                yield publish(result)
            while next_number in finished:
                if (ready := finished.pop(next_number)) is not None:
                    yield publish(self._judged(ready))
                next_number += 1
        for number in sorted(finished):
            if (ready := finished[number]) is not None:
                yield publish(self._judged(ready))

    def _judged(self, result: Result) -> Result:
        """The result, or a rejection if it is a copy of an earlier asset."""
        if result.folder is None:
            return result
        job = result.job
        # An earlier run compared it with all others, and it is no copy of one of them. An asset with the form, size and
        # colours of another one was kept on purpose, and is judged again.
        is_settled = result.is_kept and self._digests.get(result.folder, "") in self._compared
        if is_settled and not self._fresh:
            self._deferred.append(result)  # there is nothing new that it could be a copy of
            return result
        row = self._rows.get(result.folder) if is_settled else None
        if row is None:
            row = row_of(result.outcome.manifest or read_manifest(result.folder))
        row = replace(row, category=job.survey.category, path=job.found.source.place)
        if (signature := row.signature) is None:
            return result
        # What was compared by an earlier run and is no copy of anything can be one of what is new alone.
        others = (self._fresh_forms, self._fresh) if is_settled else (self._all_forms(), self._known)
        original_and_pair = self._original(row, *others)
        if original_and_pair is None:
            folder = row.folder if result.is_kept else self._library.folder(row.category, row.id)
            row = replace(row, folder=folder)
            self._all_forms()
            self._take([row])
            if not result.is_kept:
                self._fresh_forms.add(signature.shape)
                self._fresh.append(row)
            return result
        original, pair = original_and_pair
        size = "" if abs(pair.size - 1) <= SAME_SIZE else f", {pair.size:.2f} times as large"
        near = f"95 % of the surface within {100 * pair.p95:.1f} % of its radius"
        message = f"duplicate of {original.path} ({original.id}){size}: {near}, and the same colours; keep one of them"
        outcome = Outcome(False, engine.NEAR_DUPLICATE_CODE, message)
        twin = f"{original.folder.parent.name}/{original.folder.name}"
        return replace(result, outcome=outcome, is_kept=False, twin=twin)

    def _original(
        self, row: AssetRow, forms: ShapeIndex, others: Sequence[AssetRow]
    ) -> tuple[AssetRow, ShapePair] | None:
        """The first asset that this one is a copy of, and how near they are."""
        assert row.signature is not None
        for index in forms.near(row.signature.shape):
            other = others[index]
            try:
                pair = measure_pair(other, row, self._store)
            except OutputError:
                continue  # damaged, or made again in the meantime: it is no copy of anything
            if pair.twins(self._limit):
                return other, pair
        return None

    def _all_forms(self) -> ShapeIndex:
        """Forms that an input may be a copy of, at first those of the library from inputs outside this run."""
        if self._forms is None:
            self._forms = ShapeIndex()
            self._take(row for row in self._entries.rows if row.sha256 not in self._own)
        deferred, self._deferred = self._deferred, []
        for result in deferred:
            assert result.folder is not None
            row = self._rows[result.folder]
            self._take([replace(row, category=result.job.survey.category, path=result.job.found.source.place)])
        return self._forms

    def _take(self, rows: Iterable[AssetRow]) -> None:
        assert self._forms is not None
        for row in rows:
            if row.signature is not None:
                self._known.append(row)
                self._forms.add(row.signature.shape)

    @cached_property
    def _compared(self) -> Set[str]:
        """Digests of the assets of the library that are no copies."""
        copies = self._entries.twins(lambda pair: pair.twins(self._limit))
        return frozenset() if copies is None else frozenset(self._digests.values()) - copies

    @cached_property
    def _digests(self) -> dict[Path, str]:
        root = self._entries.root
        return {root / entry.path: entry.digest for entry in self._entries.entries if entry.accepted}

    @cached_property
    def _rows(self) -> dict[Path, AssetRow]:
        return {row.folder: row for row in self._entries.rows}
