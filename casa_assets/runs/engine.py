"""The engine of runs: what goes in, what earlier runs made of it, what workers make now, and what is reported.

A run of any kind goes through the same steps:

    discover    inputs, in an order that no machine changes, or the members and kitchens that were asked for
    key         of each: the bytes or numbers that it is made from, and the code and options that make it
    resume      what an earlier run made under that key is kept; an accepted asset is not replaced by a worse result
    job         what is still to be done, each in a worker process with limits (`pool.py`)
    work        the functions of the subject in their order (`<subject>/run/steps.py`), then writing and checks
    publish     the staged entry gets its place by one rename, or a refusal that says why not
    event       says what became of each input, as it is done

`InputRun` leads runs over files of strangers, of which any may be unreadable: ingest and articulate. `run_batch` leads
those over data of the program (families, kitchens, textures, pages): an error is a fault of the program, of the machine
or of the user's request, and `attempt` tells which.
"""

from __future__ import annotations

import gc
import hashlib
import logging
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, Generic, Protocol, TypeVar

from casa_assets import registry
from casa_assets.cache.cache_key import digest_of
from casa_assets.cache.store import Store
from casa_assets.core.system import cache_dir, cache_for, unusable
from casa_assets.errors import CasaError, OutputError, PluginFailure, Rejected
from casa_assets.ingest.sources.places import Found, Refused
from casa_assets.library import review
from casa_assets.library.entry import Entry, RefusedRows, entry_at, remainder_message, row_id
from casa_assets.library.entry_files import (
    CERTIFICATE,
    REFUSAL,
    Certificate,
    Identity,
    Producer,
    Refusal,
    file_inside,
    is_whole,
    read_manifest,
    read_refusal,
)
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.library import REJECTED, Library
from casa_assets.model import rejection_codes
from casa_assets.model.issue import Decision
from casa_assets.runs.limits import Limits, WorkerFailure
from casa_assets.runs.outcome import FAILURE_CODES, Event, Outcome, RunAborted, keep_trace, writing
from casa_assets.runs.pool import Step, Workers, open_engine
from casa_assets.show.stills.opengl import NoRenderer

LOG = logging.getLogger(__name__)
J = TypeVar("J")
T = TypeVar("T")

# Batches --------------------------------------------------------------------------------------------------------------

# Processor seconds after which a job does not end by itself; the slowest known takes three minutes.
CPU_S = 7200.0
# Errors of the machine, which every other item of a batch would meet too.
ABORTS = (OutputError, NoRenderer, MemoryError)


def run_batch(
    function: Callable[[J], T],
    jobs: Sequence[J],
    root: Path,
    workers: Workers,
    warm: Step,
    least_bytes: int,
    goes_on: bool = False,
) -> Iterator[tuple[int, T | WorkerFailure]]:
    """Yield (number of the job, what the function makes of it or a failure) as they finish, each in a worker.

    Args:
        function: of a module, or a partial of one, that answers with something picklable.
        warm: see Pool. least_bytes: memory that a job needs.
        goes_on: a job for which the memory does not suffice, tried alone too, is a failure like others.
    Raises:
        CasaError: the disk, the renderer or the memory of this machine does not suffice; what was finished is kept.
    """
    if not jobs:
        return
    if why := unusable(cache_dir()):
        message = "the cache folder %s %s, so %s is used instead; CASA_ASSETS_CACHE names another folder"
        LOG.warning(message, cache_dir(), why, cache_for(root))
    limits = Limits(CPU_S, int(registry.load().limits["input_memory_bytes"]))
    with open_engine(workers, limits, warm, Library(root).private, least_bytes) as pool:
        for number, answer in pool.run(work, [(function, job, root) for job in jobs]):
            if isinstance(answer, RunAborted):
                raise CasaError(answer.message)
            if not goes_on and isinstance(answer, WorkerFailure) and answer.reason in ("memory", "killed"):
                raise CasaError(
                    f"a job was ended for want of memory ({answer.message}); what was finished is kept: run it again "
                    "with less beside it, or with fewer --jobs"
                )
            yield number, answer


def work(task: tuple[Callable[[Any], Any], Any, Path]) -> Any:
    """One job, in a worker."""
    function, job, root = task
    # No record is in a cycle: to look for cycles among so many takes a tenth of a kitchen's time.
    gc.set_threshold(100_000, 20, 20)
    try:
        with writing(root):
            return function(job)
    except (OutputError, NoRenderer) as error:
        return RunAborted(str(error))


def attempt(make: Callable[[], T], failed: Callable[[str, bool], T], root: Path) -> T:
    """Call `make`; where it fails, return what `failed` makes of the failure, so that the other items of a batch go on.

    Args:
        failed: takes a message, and whether the program is to blame: then the message is the trace.
        root: folder that is written to.
    Raises:
        OutputError, NoRenderer, MemoryError: every other item would meet the same.
    """
    try:
        with writing(root):
            return make()
    except ABORTS:
        raise
    except PluginFailure as error:
        return failed(f"{error}; the trace: {keep_trace(error, Library(root))}", False)
    except CasaError as error:
        return failed(str(error), False)
    except Exception:  # noqa: BLE001  the other items go on; the trace is reported and the run ends with exit 3
        return failed(traceback.format_exc(limit=-4), True)


# Runs over inputs -----------------------------------------------------------------------------------------------------

DUPLICATE_CODE = "RUN006"
# Stands in ids for the category of an input that could not be read, which nobody can know.
SHELF = "unread"


class Surveyed(Protocol):
    """What a survey found out about an input that can be read."""

    @property
    def sha256(self) -> str:
        """Digest of its bytes."""


S = TypeVar("S", bound=Surveyed)


def open_library(library: Library, stack: ExitStack) -> None:
    """Hold a library for writing until the stack is left, and remove what a killed run left half-written."""
    stack.enter_context(library.locked())
    stack.enter_context(writing(library.root))
    stack.callback(library.sweep)
    library.sweep()
    Store(library.cache).sweep()


class InputRun(Generic[S]):
    """One run over discovered inputs: what is known of them, and the refusals of those that have no bytes.

    Args:
        library: written to. table: its entries as the run begins; in a dry run those of another library.
        producer: of the entries. cache_key: of refusals of what cannot be read.
        inputs: all of them; they are read when this is made.
    Attributes:
        before: the library with the results of earlier runs; another one than `library` in a dry run only.
        found: inputs with a mesh. early: events of all others: one each for the first of a file, one for the rest.
        left_out: numbers of inputs that this run leaves as they are and does not report. surveys: by number, once
            `over` has begun.
    """

    def __init__(
        self,
        library: Library,
        table: EntryTable,
        producer: Producer,
        inputs: Iterable[Found | Refused],
        cache_key: str = "",
    ) -> None:
        self.library, self.table, self.producer, self.cache_key = library, table, producer, cache_key
        self.before = library if table.root == library.root else Library(table.root)
        self.overrides = review.read_overrides(self.before)
        self.refused_rows = RefusedRows(self.before)
        self.found: Sequence[Found] = []
        self.early: list[tuple[Event, Refused]] = []
        self.left_out: set[int] = set()
        self.surveys: dict[int, S | Rejected | WorkerFailure] = {}
        # Of what could not be read: how many are at each place (rows may name one mesh), and the ids.
        self._unread: Counter[str] = Counter()
        self._unread_ids: set[str] = set()
        self._places: set[str] = set()
        self._discover(inputs)

    def _discover(self, inputs: Iterable[Found | Refused]) -> None:
        found = []
        for one in inputs:
            if isinstance(one, Found):
                found.append(one)
            elif name := self.refused_rows.add(one):
                kind = "kept" if self.refused_rows.was_known(one) else "rejected"
                event = Event(kind, 0, one.path, name, one.code, one.message, Decision.REJECTED)
                self.early.append((event, one))
        self.found = found
        for path, code, count in self.refused_rows.rest():
            message = remainder_message(count)
            kind = "kept" if self.refused_rows.was_counted(path, code, count) else "rejected"
            event = Event(kind, 0, path, row_id(path, code), code, message, Decision.REJECTED, count=count)
            self.early.append((event, Refused(path, code, message)))

    @cached_property
    def older(self) -> dict[str, tuple[Path, ...]]:
        """Folders of the entries of `before`, see `by_input`."""
        return self.before.by_input()

    @cached_property
    def known(self) -> dict[Path, Entry]:
        """The entries of `before` by their folders."""
        return {self.before.root / entry.path: entry for entry in self.table.entries}

    @cached_property
    def total(self) -> int:
        """Number of inputs that this run reports."""
        return len(self.found) - len(self.left_out) + sum(event.count for event, _ in self.early)

    def refused_early(self) -> Iterator[Event]:
        """Yield the events of inputs without a mesh."""
        for event, one in self.early:
            self._places.add(_place_key(one.path))
            yield replace(event, total=self.total)

    def over(
        self, answers: Iterable[tuple[int, S | Rejected | WorkerFailure]], step: Callable[[Found, S], Iterator[T]]
    ) -> Iterator[Event | T]:
        """Go over the inputs in their order: what `step` yields for the first of its bytes, else why it is refused.

        Args:
            answers: number of an input, and its survey or why there is none; all are awaited.
        """
        self.surveys = dict(answers)
        first: dict[str, str] = {}
        for number, one in enumerate(self.found):
            answer, is_left_out = self.surveys[number], number in self.left_out
            if isinstance(answer, WorkerFailure):
                refused = FAILURE_CODES[answer.reason], answer.text
            elif isinstance(answer, Rejected):
                refused = answer.code, answer.message
            elif answer.sha256 in first:
                refused = DUPLICATE_CODE, f"same bytes as {first[answer.sha256]}; remove one of them"
            else:
                first[answer.sha256] = one.source.place
                if not is_left_out:
                    self._places.add(_place_key(one.source.path, one.source.uid))
                    yield from step(one, answer)
                continue
            if not is_left_out:
                yield self._refuse(one, *refused)

    def _refuse(self, one: Found, code: str, message: str) -> Event:
        """Keep why an input never became a bundle. Its id is made from its path, as its bytes have no digest."""
        place = _place_key(one.source.path, one.source.uid)
        self._places.add(place)
        self._unread[place] += 1
        digest = hashlib.sha256(f"{place}:{self._unread[place]}".encode()).hexdigest()
        refusal = Refusal(
            producer=self.producer,
            id=Identity(self.producer, digest).asset_id(SHELF),
            code=code,
            message=message,
            category=registry.FALLBACK,
            cache_key=self.cache_key,
            sha256=digest,
            source=one.source,
        )
        self._unread_ids.add(refusal.id)
        known, is_new = self.before.refusal_folder(refusal.id), True
        with suppress(OutputError):  # damaged: written anew
            is_new = not (known / REFUSAL).exists() or read_refusal(known) != refusal
        folder = self.library.refusal_folder(refusal.id)
        if is_new:
            self.library.put(self.library.stage_refusal(refusal), folder)
        return Event(
            "rejected" if is_new else "kept",
            self.total,
            one.source.place,
            refusal.id,
            code,
            message,
            Decision.REJECTED,
            folder=folder if self.library is self.before else None,
        )

    def prune(self) -> None:
        """Remove refusals of places that this run looked at and did not refuse as unreadable."""
        for folder in list(self.library.refused()):
            if folder.name.startswith(f"{SHELF}_") and folder.name not in self._unread_ids:
                try:
                    refusal = read_refusal(folder)
                    place = _place_key(refusal.source.path, refusal.source.uid)
                    is_obsolete = refusal.producer is self.producer and place in self._places
                except OutputError:
                    is_obsolete = True  # it is damaged
                if is_obsolete:
                    self.library.forget(folder)


def _place_key(path: str, uid: str = "") -> str:
    """Key of an input: its path and its id in a manifest. It is the same whether a file is refused early or late."""
    return f"{path}:{uid}"


# Resume ---------------------------------------------------------------------------------------------------------------

NEAR_DUPLICATE_CODE = "RUN007"
# Codes of refusals whose reason is the run (its limits, the machine, a bug) and not the input; the next run tries the
# input again.
RETRIED_CODES = frozenset(
    {
        "RUN001",  # timeout
        "RUN002",  # out of memory
        "RUN003",  # a native library crashed
        "RUN004",  # the program failed
        "RUN005",  # the file changed while it was being read
        "RUN008",  # the work made no progress
        rejection_codes.TOO_LARGE,
        rejection_codes.STORE_FAILED,
    }
)
NOTHING_KNOWN: Mapping[Path, Entry] = MappingProxyType({})


def cached_outcome(
    entries: Sequence[Path],
    asset_id: str | None,
    cache_key: str,
    known: Mapping[Path, Entry] = NOTHING_KNOWN,
    retried: Set[str] = RETRIED_CODES,
) -> tuple[Path, Outcome] | None:
    """Return the entry of an earlier run under the same key and its outcome; None if the input must be processed.

    Args:
        entries: folders of all that the producer made of the same bytes. cache_key: of this run.
        asset_id: of this run; None if it is known only once the work is done.
        known: entries that were read already, by their folder: their files are not opened again.
        retried: codes of refusals whose input is tried again.
    """
    for folder in entries:
        if asset_id not in (None, folder.name):
            continue  # made under another category
        try:
            entry = known.get(folder) or entry_at(folder, folder.parents[1])
            if entry.code == NEAR_DUPLICATE_CODE and (twin := read_refusal(folder).twin):
                file_inside(folder.parents[1], f"{twin}/{CERTIFICATE}", folder / REFUSAL, "twin")
        except OutputError:
            continue  # damaged, or a copy of what is gone: it is made anew
        if entry.cache_key == cache_key and entry.code not in retried and entry.is_whole:
            return folder, Outcome(entry.accepted, entry.code, entry.message, entry.warnings)
    return None


# Kitchens and exports name assets by their ids, so a worse result (in review, rejected, or with fewer moving parts)
# replaces an accepted asset of the same input only where the user asks for it (`--force`).


@dataclass(frozen=True)
class KeptAsset:
    """An accepted asset that is kept in place of a worse result of the same input.

    Attributes:
        cache_key: of the run that made it. reason: why it is kept.
    """

    folder: Path
    cache_key: str
    reason: str


@dataclass(frozen=True)
class NewResult:
    """The result of a run for an input that has an entry already.

    Attributes:
        decision: accepted, in review or rejected. code: of a rejection. to_decide: subjects of review.
        moving_parts: number of its joints; None if that number does not matter.
    """

    decision: Decision
    code: str = ""
    to_decide: tuple[str, ...] = ()
    moving_parts: int | None = None

    def reason_to_keep(self, name: str, moving_parts: int) -> str:
        """Return why the accepted asset of a name is kept in place of this; empty where this replaces it."""
        if self.code == review.REJECTED_CODE:  # a person rejects it
            return ""
        advice = "--force replaces it"
        if self.decision is Decision.REJECTED:
            return f"{name} is accepted, the new result was rejected ({self.code}); {advice}"
        if self.moving_parts is not None and self.moving_parts < moving_parts:
            parts = f"{moving_parts} moving part{'s' if moving_parts > 1 else ''}"
            return f"{name} has {parts}, the new result has {self.moving_parts}; {advice}"
        if self.decision is Decision.REVIEW:
            return f"{name} is accepted, the new result is in review ({', '.join(self.to_decide)}); {advice}"
        return ""


def kept_before(library: Library, identity: Identity, cache_key: str, entries: Iterable[Path]) -> KeptAsset | None:
    """Return the accepted asset that an earlier run kept in place of its result under a key, or None."""
    if (found := _find_accepted(entries, cache_key)) is None:
        return None
    folder, certificate, _ = found
    note = Store(library.cache).get(_note_key(identity, cache_key, folder, certificate.cache_key))
    return KeptAsset(folder, certificate.cache_key, note.decode()) if note else None


def kept_instead(
    library: Library,
    identity: Identity,
    cache_key: str,
    entries: Iterable[Path],
    new: NewResult,
    retried: Set[str] | None = RETRIED_CODES,
) -> KeptAsset | None:
    """Return the accepted asset that is better than a new result, or None to publish the new one.

    The reason is noted, so that the next run need not make the result again, except if that was rejected because of a
    fault of this run or of the machine.

    Args:
        entries: folders of all that the producer made of the same bytes.
        retried: codes of such faults; None: nothing is noted.
    """
    if (found := _find_accepted(entries, cache_key)) is None:
        return None
    folder, certificate, moving_parts = found
    reason = new.reason_to_keep(folder.name, moving_parts)
    if not reason:
        return None
    if retried is not None and new.code not in retried:
        key = _note_key(identity, cache_key, folder, certificate.cache_key)
        Store(library.cache).put(key, reason.encode())
    return KeptAsset(folder, certificate.cache_key, reason)


def _find_accepted(entries: Iterable[Path], cache_key: str) -> tuple[Path, Certificate, int] | None:
    """Return the accepted asset among the entries of one input with the number of its joints, or None.

    Damaged entries, and one that was made under the same key, are skipped.
    """
    for folder in entries:
        if folder.parent.name == REJECTED:
            continue
        try:
            manifest = read_manifest(folder)
        except OutputError:
            continue
        certificate = manifest.certificate
        is_accepted = certificate.report.passed and not certificate.report.to_decide
        if is_accepted and certificate.cache_key != cache_key and is_whole(folder, certificate):
            return folder, certificate, len(manifest.asset.get("joints", ()))
    return None


def _note_key(identity: Identity, cache_key: str, folder: Path, kept_key: str) -> str:
    """Return the key of the note on a result and the asset that was kept in its place."""
    return digest_of("kept accepted", identity.producer.value, identity.sha256, cache_key, folder.name, kept_key)
