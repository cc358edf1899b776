"""Reject near-duplicates among the inputs of a run and in its library: the first stays.

Which one is first must not depend on which worker is faster: what the library had from other inputs comes first, then
the inputs in the order in which they were found. So an accepted asset is held back until all inputs before it are done.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TypeVar

from casa_assets.cache.store import Store
from casa_assets.checks.library import SAME_SIZE, ShapePair
from casa_assets.errors import OutputError
from casa_assets.ingest.run.job import Result
from casa_assets.library import library as disk
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.pairs import AssetRow, ShapeIndex, measure_pair, row_of
from casa_assets.runs.engine import NEAR_DUPLICATE_CODE
from casa_assets.runs.outcome import Outcome

Published = TypeVar("Published")


class Deduplicator:
    """Finds copies among the inputs of a run and in its library.

    Args:
        limit: largest distance between the surfaces of copies, as a share of their radius.
        own: sha256 of the inputs of this run; their entries in the library are judged in the order of the inputs.
        table: the entries of the library from before the run; None: they are read when they are asked for.
    """

    def __init__(
        self, library: disk.Library, limit: float, own: Set[str] = frozenset(), table: EntryTable | None = None
    ) -> None:
        self._library, self._limit, self._own, self._table = library, limit, own, table
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

        Args:
            results: numbered from 0 without gaps, in any order. Results after a missing number are judged at the end.
            publish: puts a result in its place, where later ones are compared with it; its answers are yielded.
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
            row = row_of(result.outcome.manifest or disk.read_manifest(result.folder))
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
        outcome = Outcome(False, NEAR_DUPLICATE_CODE, message)
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
                continue  # damaged, or made anew in the meantime: it is no copy of anything
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
    def _entries(self) -> EntryTable:
        return self._table or EntryTable(self._library, skip_damaged=True)

    @cached_property
    def _digests(self) -> dict[Path, str]:
        root = self._entries.root
        return {root / entry.path: entry.digest for entry in self._entries.entries if entry.accepted}

    @cached_property
    def _rows(self) -> dict[Path, AssetRow]:
        return {row.folder: row for row in self._entries.rows}
