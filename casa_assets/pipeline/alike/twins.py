"""Copies of one thing among the inputs of a run and in its library: the first stays, the others are turned away.

Which one is first must not hang on which worker is faster: what the library had from other inputs comes first, then the
inputs in the order in which they were found. So an accepted asset is held back until all inputs before it are done.
"""

from __future__ import annotations

import shutil
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from casa_assets.checks.alike import SAME_SIZE, Alike
from casa_assets.errors import OutputError
from casa_assets.geometry.form import form_gap
from casa_assets.model.source import Source
from casa_assets.pipeline import library as disk
from casa_assets.pipeline.alike.pairs import FORM_GAP, measured
from casa_assets.pipeline.alike.rows import Row, row
from casa_assets.pipeline.store import Store

if TYPE_CHECKING:
    from casa_assets.pipeline.ingest import Event

CODE = "RUN007"
PICTURE = "preview.png"


@dataclass
class Twins:
    """What is known of copies while a run goes on.

    Attributes:
        library, mark: of the run; the mark is its recipe. limit: how near surfaces of copies lie to each other.
        order: id -> source of every input that was read, in the order in which they were found.
    """

    library: disk.Library
    mark: str
    limit: float
    order: Mapping[str, Source] = field(default_factory=dict)
    _known: list[Row] | None = None

    def apart(self, events: Iterable[Event]) -> Iterator[Event]:
        """The events, accepted ones in the order of their inputs, copies turned into rejections."""
        held: dict[str, Event] = {}
        gone: dict[str, bool] = {}
        waiting: deque[str] | None = None
        for event in events:
            if event.was_rejected or event.asset_id not in self.order:
                gone[event.asset_id] = True
                yield event
            else:
                held[event.asset_id] = event
                waiting = deque(self.order) if waiting is None else waiting
            while waiting and (waiting[0] in held or waiting[0] in gone):
                name = waiting.popleft()
                if name in held:
                    yield self._judged(held.pop(name))
        assert not held, "every input that was read is accepted or rejected in the end"

    def _judged(self, event: Event) -> Event:
        """The event, or a rejection where the library has the same thing already."""
        folder = next(
            (f for f in self.library.root.glob(f"*/{event.asset_id}") if f.parent.name != disk.REJECTED), None
        )
        if folder is None:
            return event
        own = row(folder)
        found = self._twin(own)
        if found is None:
            self._others().append(own)
            return event
        twin, pair = found
        source = self.order[event.asset_id]
        says = _says(twin, pair)
        self._refuse(own, source, twin, says)
        return replace(event, kind="rejected", code=CODE, says=says, was_rejected=True, warnings=())

    def _twin(self, own: Row) -> tuple[Row, Alike] | None:
        if own.signature is None:
            return None
        store = Store(self.library.cache)
        for other in self._others():
            if other.signature is None or form_gap(own.signature.form, other.signature.form) > FORM_GAP:
                continue
            try:
                pair = measured(other, own, store)
            except OutputError:
                continue  # damaged, or made anew in the meantime: it is no copy of anything
            if pair.twins(self.limit):
                return other, pair
        return None

    def _others(self) -> list[Row]:
        """What later inputs may be copies of: at first all that the library has from inputs not of this run."""
        if self._known is None:
            own = {name.rpartition("_")[2] for name in self.order}
            folders = [f for f in self.library.accepted() if f.name.rpartition("_")[2] not in own]
            self._known = [found for folder in folders if (found := _read(folder)) is not None]
        return self._known

    def _refuse(self, own: Row, source: Source, twin: Row, says: str) -> None:
        """Move an accepted asset to the rejected ones; killed in between, its input is due again."""
        certificate = disk.read_certificate(own.folder)
        staged = self.library.stage(own.id)
        shutil.copyfile(own.folder / PICTURE, staged / PICTURE)
        refusal = disk.Refusal(
            id=own.id,
            code=CODE,
            says=says,
            category=own.category,
            recipe=self.mark,
            sha256=disk.part(own.folder, "asset")["provenance"]["sha256"],
            source=source,
            report=certificate.report,
            twin=twin.folder.relative_to(self.library.root).as_posix(),
        )
        disk.write_refusal(staged, refusal)
        self.library.forget(own.folder)
        self.library.publish(staged, self.library.refusal_folder(own.id))


def stands(root: Path, refusal: disk.Refusal) -> bool:
    """Whether what an input is a copy of is still in the library: else the input is due."""
    return (root / refusal.twin / disk.CERTIFICATE).is_file()


def _read(folder: Path) -> Row | None:
    try:
        return row(folder)
    except OutputError:
        return None


def _says(twin: Row, pair: Alike) -> str:
    size = "" if abs(pair.size - 1) <= SAME_SIZE else f", {pair.size:.2f} times as large"
    near = f"95 % of the surface within {100 * pair.most:.1f} % of its radius"
    return f"duplicate of {twin.path} ({twin.id}){size}: {near}, and the same colours; keep one of them"
