"""Reject near-duplicates among the inputs of a run and in its library: the first stays.

Which one is first must not depend on which worker is faster: what the library had from other inputs comes first, then
the inputs in the order in which they were found. So an accepted asset is held back until all inputs before it are done.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Set
from dataclasses import dataclass, field, replace

from casa_assets.checks.library.duplicates import SAME_SIZE, ShapePair
from casa_assets.errors import OutputError
from casa_assets.pipeline.cache.store import Store
from casa_assets.pipeline.dedup.entries import AssetRow, read_row
from casa_assets.pipeline.dedup.pairs import ShapeIndex, measure_pair
from casa_assets.pipeline.ingest.job import Outcome, Result
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_table import EntryTable

NEAR_DUPLICATE_CODE = "RUN007"


@dataclass
class Deduplicator:
    """Finds copies among the inputs of a run and in its library.

    Attributes:
        library: of the run. limit: largest distance between the surfaces of copies, as a share of their radius.
        own: sha256 of the inputs of this run; their entries in the library are judged in the order of the inputs.
    """

    library: disk.Library
    limit: float
    own: Set[str] = frozenset()
    _known: list[AssetRow] | None = None
    _forms: ShapeIndex = field(default_factory=ShapeIndex)

    def filter(self, results: Iterable[Result]) -> Iterator[Result]:
        """The results, rejections at once and accepted ones in the order of their inputs, copies made rejections.

        Nothing is published here: whoever takes a result has to publish it before asking for the next one.

        Args:
            results: numbered from 0 without gaps, in any order. What comes after a missing number is judged at the end.
        """
        finished: dict[int, Result | None] = {}
        next_number = 0
        for result in results:
            if result.outcome.accepted:
                finished[result.number] = result
            else:
                finished[result.number] = None
                yield result
            while next_number in finished:
                if (ready := finished.pop(next_number)) is not None:
                    yield self._judged(ready)
                next_number += 1
        for number in sorted(finished):
            if (ready := finished[number]) is not None:
                yield self._judged(ready)

    def _judged(self, result: Result) -> Result:
        """The result, or a rejection if it is a copy of an earlier asset."""
        if result.folder is None:
            return result
        job = result.job
        row = replace(read_row(result.folder), category=job.survey.category, path=job.found.source.place)
        original_and_pair = self._original(row)
        if original_and_pair is None:
            if row.signature is not None:
                self._others().append(replace(row, folder=self.library.folder(row.category, row.id)))
                self._forms.add(row.signature.shape)
            return result
        original, pair = original_and_pair
        outcome = Outcome(False, NEAR_DUPLICATE_CODE, _message(original, pair))
        twin = original.folder.relative_to(self.library.root).as_posix()
        return replace(result, outcome=outcome, is_kept=False, twin=twin)

    def _original(self, row: AssetRow) -> tuple[AssetRow, ShapePair] | None:
        """The first asset that this one is a copy of, and how near they are."""
        if row.signature is None:
            return None
        store = Store(self.library.cache)
        others = self._others()
        for index in self._forms.near(row.signature.shape):
            other = others[index]
            try:
                pair = measure_pair(other, row, store)
            except OutputError:
                continue  # damaged, or made anew in the meantime: it is no copy of anything
            if pair.twins(self.limit):
                return other, pair
        return None

    def _others(self) -> list[AssetRow]:
        """Assets that later inputs may be copies of: at first those of the library from inputs outside this run."""
        if self._known is None:
            rows = [row for row in EntryTable(self.library, skip_damaged=True).rows if row.sha256 not in self.own]
            with_shape = [(row, row.signature.shape) for row in rows if row.signature is not None]
            self._known, self._forms = [row for row, _ in with_shape], ShapeIndex(form for _, form in with_shape)
        return self._known


def _message(original: AssetRow, pair: ShapePair) -> str:
    size = "" if abs(pair.size - 1) <= SAME_SIZE else f", {pair.size:.2f} times as large"
    near = f"95 % of the surface within {100 * pair.p95:.1f} % of its radius"
    return f"duplicate of {original.path} ({original.id}){size}: {near}, and the same colours; keep one of them"
