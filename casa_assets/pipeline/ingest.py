"""Sources into a library: find, survey, leave out twins, work on what is missing, keep the books."""

from __future__ import annotations

import hashlib
import os
from collections import Counter
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from casa_assets import registry
from casa_assets.errors import Rejected
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.model.issue import Issue
from casa_assets.model.source import Source, SourceKind
from casa_assets.pipeline import attribution, index, pool, worker
from casa_assets.pipeline import library as disk
from casa_assets.pipeline.stage import recipe
from casa_assets.pipeline.store import Store

# What the pool's own verdicts are called in registry/rejections.yaml.
DEATH_CODES = {"timeout": "RUN001", "memory": "RUN002", "signal": "RUN003", "error": "RUN004"}
TWIN = "RUN006"


@dataclass(frozen=True)
class Options:
    """How to run.

    Attributes:
        library: output folder. category: id for all inputs, or empty.
        jobs: children at once; 0 for one per core.
        seconds: wall time for one input. memory_bytes: address space of one input.
    """

    library: Path
    category: str = ""
    jobs: int = 0
    seconds: float = 300.0
    memory_bytes: int = 8_000_000_000


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
class _Plan:
    """Inputs that need work."""

    todo: list[worker.Job] = field(default_factory=list)


def ingest(roots: Sequence[Path], options: Options) -> Iterator[Event]:
    """Bring every mesh under `roots` into the library, or record why not.

    Yields an Event for each input, as it is done with. Killed at any moment and run again, it does what is missing.

    Raises:
        UnknownId: the ordered category does not exist.
        OutputError: the library cannot be written to, or another run holds it.
    """
    known = registry.load()
    if options.category:
        known.category(options.category)
    library = disk.Library(options.library)
    with library.locked():
        library.sweep()
        Store(library.cache).sweep()
        found = list(discover(roots))
        plan = yield from _survey(found, library, options)
        yield from _work(plan, len(found), library, options)
        books(library)


def books(library: disk.Library) -> None:
    """Rewrite what is derived from the entries: the index and the attribution file."""
    index.rebuild(library)
    attribution.write(library)


def _survey(found: Sequence[Found | Refused], library: disk.Library, options: Options) -> Generator[Event, None, _Plan]:
    """Digest every input, decide twins, and yield an event for all that need no work."""
    known = registry.load()
    mark = recipe(known.limits, known.digest)
    total = len(found)
    inputs = [f for f in found if isinstance(f, Found)]
    surveys: dict[int, worker.Survey | Rejected | pool.Died] = {}
    limits = pool.Limits(options.seconds, options.memory_bytes)
    for number, answer in pool.run(worker.survey, [(f, options.category) for f in inputs], _jobs(options), limits):
        surveys[number] = answer
    plan = _Plan()
    seen: dict[str, str] = {}
    for row in (f for f in found if isinstance(f, Refused)):
        source = Source(kind=SourceKind.MANIFEST, path=row.path)
        yield _refuse(library, source, row.code, row.says, total, mark)
    for number, one in enumerate(inputs):
        answer = surveys[number]
        if isinstance(answer, pool.Died):
            answer = Rejected(DEATH_CODES[answer.reason], answer.says)
        if isinstance(answer, Rejected):
            yield _refuse(library, one.source, answer.code, answer.says, total, mark)
            continue
        twin = seen.setdefault(answer.sha256, one.source.path)
        if twin != one.source.path:
            yield _refuse(library, one.source, TWIN, f"same bytes as {twin}; remove one of them", total, mark)
            continue
        job = worker.Job(one, answer, f"{answer.category}_{answer.sha256[:10]}", options.library)
        done = _done(library, job, mark)
        if done is None:
            plan.todo.append(job)
        else:
            yield Event("kept", total, one.source.path, job.asset_id, done[0], done[1], was_rejected=bool(done[0]))
    return plan


def _done(library: disk.Library, job: worker.Job, mark: str) -> tuple[str, str] | None:
    """(code, says) of an earlier rejection, two empty strings where it was accepted, None where it is due."""
    folder = library.folder(job.survey.category, job.asset_id)
    if (folder / disk.CERTIFICATE).exists():
        return ("", "") if disk.read_certificate(folder).recipe == mark else None
    refused = library.refusal_folder(job.asset_id)
    if (refused / disk.REFUSAL).exists():
        refusal = disk.read_refusal(refused)
        return (refusal.code, refusal.says) if refusal.recipe == mark else None
    return None


def _work(plan: _Plan, total: int, library: disk.Library, options: Options) -> Iterator[Event]:
    limits = pool.Limits(options.seconds, options.memory_bytes)
    for number, answer in pool.run(worker.work, plan.todo, _jobs(options), limits):
        job = plan.todo[number]
        path = job.found.source.path
        if isinstance(answer, pool.Died):
            code = DEATH_CODES[answer.reason]
            worker.refuse(library, job, Rejected(code, answer.says), None, None)
            says = f"{answer.says}\n{answer.trace}" if answer.trace else answer.says
            yield Event("rejected", total, path, job.asset_id, code, says)
        elif answer.accepted:
            yield Event("accepted", total, path, job.asset_id, warnings=answer.warnings)
        else:
            yield Event("rejected", total, path, job.asset_id, answer.code, answer.says)


def _refuse(library: disk.Library, source: Source, code: str, says: str, total: int, mark: str) -> Event:
    """Remember an input that never became a bundle; its id comes from where it stands."""
    name = hashlib.sha256(f"{source.kind.value}:{source.path}".encode("utf-8", "surrogateescape")).hexdigest()
    asset_id = f"unread_{name[:10]}"
    refusal = disk.Refusal(
        id=asset_id, code=code, says=says, category="object", recipe=mark, sha256=name, source=source
    )
    target = library.refusal_folder(asset_id)
    if (target / disk.REFUSAL).exists() and disk.read_refusal(target) == refusal:
        return Event("kept", total, source.path, asset_id, code, says, was_rejected=True)
    staged = library.stage(asset_id)
    disk.write_refusal(staged, refusal)
    library.publish(staged, target)
    return Event("rejected", total, source.path, asset_id, code, says)


def _jobs(options: Options) -> int:
    return options.jobs or len(os.sched_getaffinity(0))


def tally(events: Sequence[Event]) -> Counter[str]:
    """How many were accepted, rejected and kept; `refused` counts rejections new and old."""
    counts = Counter(e.kind for e in events)
    counts["refused"] = sum(e.kind == "rejected" or e.was_rejected for e in events)
    return counts
