"""Write library.json: the checks on all entries of a library together and, with CLIP weights, on their pictures."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, ValidationError

from casa_assets import registry
from casa_assets.checks.library import CategoryRank, LibrarySizes, LibraryView
from casa_assets.checks.objects.collection import CollectedMember, ObjectCollection
from casa_assets.checks.run import run
from casa_assets.checks.table import libraries
from casa_assets.model.issue import Report
from casa_assets.model.record import Record
from casa_assets.pipeline.cache.store import Store
from casa_assets.pipeline.clip import NO_WEIGHTS, ClipModel
from casa_assets.pipeline.dedup.clip_embeddings import image_embeddings, likenesses, similar_looking_pairs
from casa_assets.pipeline.dedup.pairs import AssetRow
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_table import EntryTable
from casa_assets.registry.tables import look_alikes

NAME = "library.json"


class LookRecord(Record):
    """Result of comparing the pictures of one asset with all categories, see checks.library.duplicates.CategoryRank.

    Attributes:
        content: digest of the asset.
    """

    content: str
    category: str
    share: float
    rank: int
    others: tuple[tuple[str, float], ...]


class LibraryReport(Record):
    """Content of library.json.

    Attributes:
        report: the checks on all assets together. weights: name of the CLIP weights, empty if CLIP was not used.
        seen: id -> result of comparing its pictures with all categories. looks: pairs of ids with similar pictures, and
            their cosine.
    """

    schema_version: Literal[1, 2] = 2
    report: Report
    weights: str = ""
    seen: Annotated[dict[str, LookRecord], Field(default_factory=dict)]
    looks: tuple[tuple[str, str, float], ...] = ()


def compare_library(library: disk.Library, table: EntryTable, eye: ClipModel | None = None) -> LibraryReport:
    """Compare all accepted assets with each other and write library.json, by one rename.

    Args:
        table: the entries of the library.
        eye: looks at the pictures. Without one, what an earlier run saw of assets that are still the same is kept.
    Raises:
        OutputError: an entry is damaged. CannotDraw, NoRenderer: with an eye, where pictures cannot be made.
    """
    rows = table.rows
    store = Store(library.cache)
    before = read_library_report(library.root)
    members = object_rows(rows)
    view = LibraryView(len(rows), tuple(table.alike(store)))
    weights, looks = (before.weights, before.looks) if before else ("", ())
    if eye is not None:
        embeddings = {row.id: image_embeddings(row, eye, store) for row in rows}
        weights, looks = eye.name, tuple(similar_looking_pairs(embeddings))
        seen = tuple(likenesses(embeddings, rows, eye, store))
        unseen = ""
    else:
        seen = _remembered(rows, before)
        unseen = "" if seen and len(seen) == len(rows) else _why(len(seen), len(rows))
    ids = {row.id for row in rows}
    looks = tuple(pair for pair in looks if {pair[0], pair[1]} <= ids)
    view = LibraryView(view.count, view.alike, looks, seen, unseen)
    name, limits = "library", registry.load().limits
    report = run(view, name, limits, table=libraries.ROWS) + run(_sizes(rows), name, limits, table=libraries.ROWS)
    if members:
        from casa_assets.checks.table import objects  # here, since few libraries hold generated objects

        report = report + run(_collection(members), name, limits, table=objects.ROWS)
    digests = {row.id: row.digest for row in rows}
    content = LibraryReport(
        report=report,
        weights=weights if seen else "",
        seen={one.asset: _kept(one, digests[one.asset]) for one in seen},
        looks=looks if not unseen else (),
    )
    _write(library, content)
    return content


def object_rows(rows: Sequence[AssetRow]) -> list[AssetRow]:
    """The members of categories of registry/objects/ that have a signature."""
    drawn = [row for row in rows if row.from_numbers and row.signature is not None]
    if not drawn:
        return []
    from casa_assets.registry.objects import object_names  # here, since it loads all families

    known = frozenset(object_names())
    return [row for row in drawn if row.category in known]


def read_library_report(root: Path) -> LibraryReport | None:
    """Read library.json of a library; None if it is missing or damaged, so that it has to be made again."""
    try:
        return LibraryReport.model_validate_json((root / NAME).read_text(encoding="utf-8"))
    except (OSError, ValidationError, ValueError):
        return None


def likeness_of(name: str, seen: LookRecord) -> CategoryRank:
    """The record as the checks have it."""
    return CategoryRank(name, seen.category, seen.share, seen.rank, seen.others)


def _collection(members: Sequence[AssetRow]) -> ObjectCollection:
    found = [CollectedMember(r.id, r.category, r.signature, r.extents) for r in members if r.signature is not None]
    return ObjectCollection(tuple(found), look_alikes())


def _sizes(found: Sequence[AssetRow]) -> LibrarySizes:
    return LibrarySizes(tuple((r.id, r.category, r.longest) for r in found))


def _remembered(found: Sequence[AssetRow], before: LibraryReport | None) -> tuple[CategoryRank, ...]:
    if before is None:
        return ()
    old = before.seen
    return tuple(likeness_of(r.id, old[r.id]) for r in found if r.id in old and old[r.id].content == r.digest)


def _why(known_count: int, count: int) -> str:
    if not known_count:
        return f"{NO_WEIGHTS} (--clip-weights)"
    new = count - known_count
    return f"{NO_WEIGHTS} (--clip-weights), and {new} of {count} assets were not there when somebody looked"


def _kept(one: CategoryRank, digest: str) -> LookRecord:
    return LookRecord(content=digest, category=one.category, share=one.share, rank=one.rank, others=one.others)


def _write(library: disk.Library, content: LibraryReport) -> None:
    text = json.dumps(content.model_dump(mode="json"), sort_keys=True, indent=1, ensure_ascii=False, allow_nan=False)
    library.private.mkdir(parents=True, exist_ok=True)
    temporary = library.private / f"{NAME}.{os.getpid()}"
    temporary.write_text(text + "\n", encoding="utf-8")
    temporary.replace(library.root / NAME)
