"""What follows from all entries of a library together: library.json, and with it attribution and review.

library.json holds the checks on all entries and, with CLIP weights, on their pictures.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, ValidationError

from casa_assets import registry
from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.cache.store import Store
from casa_assets.checks.check import run
from casa_assets.checks.library import ROWS, CategoryRank, LibrarySizes, LibraryView
from casa_assets.checks.objects import CollectedMember, ObjectCollection
from casa_assets.library import attribution, clip, review
from casa_assets.library.clip import NO_WEIGHTS, ClipModel, image_embeddings, likenesses, similar_looking_pairs
from casa_assets.library.entry import ROWS_NAME
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.library import REJECTED, Library
from casa_assets.library.pairs import AssetRow
from casa_assets.model.issue import Report
from casa_assets.model.record import Record
from casa_assets.registry.tables import look_alikes

NAME = "library.json"


class LookRecord(Record):
    """Result of comparing the pictures of one asset with all categories, see checks.library.CategoryRank.

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

    schema_version: Literal[2] = 2
    report: Report
    weights: str = ""
    seen: Annotated[dict[str, LookRecord], Field(default_factory=dict)]
    looks: tuple[tuple[str, str, float], ...] = ()


def compare_library(library: Library, table: EntryTable, eye: ClipModel | None = None) -> LibraryReport:
    """Compare all accepted assets with each other and write library.json, by one rename.

    Args:
        eye: looks at the pictures. Without one, what an earlier run saw of assets that are still the same is kept.
    Raises:
        OutputError: an entry is damaged. CannotDraw, NoRenderer: with an eye, where pictures cannot be made.
    """
    rows = table.rows
    store = Store(library.cache)
    before = read_library_report(library.root)
    alike = tuple(table.alike(store))
    weights, looks = (before.weights, before.looks) if before else ("", ())
    if eye is not None:
        embeddings = {row.id: image_embeddings(row, eye, store) for row in rows}
        weights, looks = eye.name, tuple(similar_looking_pairs(embeddings))
        seen = tuple(likenesses(embeddings, rows, eye, store))
        unseen = ""
    else:
        old = before.seen if before else {}
        same = (row.id for row in rows if row.id in old and old[row.id].content == row.digest)
        seen = tuple(likeness_of(name, old[name]) for name in same)
        unseen = "" if seen and len(seen) == len(rows) else f"{NO_WEIGHTS} (--clip-weights)"
        if unseen and seen:
            new = len(rows) - len(seen)
            unseen += f", and {new} of {len(rows)} assets were not there when somebody looked"
    ids = {row.id for row in rows}
    looks = tuple(pair for pair in looks if {pair[0], pair[1]} <= ids)
    view = LibraryView(len(rows), alike, looks, seen, unseen)
    name, limits = "library", registry.load().limits
    sizes = LibrarySizes(tuple((row.id, row.category, row.longest) for row in rows))
    report = run(view, name, limits, table=ROWS) + run(sizes, name, limits, table=ROWS)
    if members := object_rows(rows):
        from casa_assets.checks import objects

        found = [CollectedMember(r.id, r.category, r.signature, r.extents) for r in members if r.signature is not None]
        report = report + run(ObjectCollection(tuple(found), look_alikes()), name, limits, table=objects.ROWS)
    digests = {row.id: row.digest for row in rows}
    content = LibraryReport(
        report=report,
        weights=weights if seen else "",
        seen={
            one.asset: LookRecord(
                content=digests[one.asset], category=one.category, share=one.share, rank=one.rank, others=one.others
            )
            for one in seen
        },
        looks=looks if not unseen else (),
    )
    text = json.dumps(content.model_dump(mode="json"), sort_keys=True, indent=1, ensure_ascii=False, allow_nan=False)
    library.write(NAME, text + "\n")
    return content


def object_rows(rows: Sequence[AssetRow]) -> list[AssetRow]:
    """The members of categories of registry/objects/ that have a signature."""
    drawn = [row for row in rows if row.from_numbers and row.signature is not None]
    if not drawn:
        return []
    from casa_assets.registry.families import object_names  # here, since it loads all families

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


# What `write_reports` writes, and what it reads beside the entries.
DERIVED = (attribution.NAME, review.NAME, NAME, f"{REJECTED}/{ROWS_NAME}")


def write_reports(library: Library, weights: str = "", table: EntryTable | None = None) -> None:
    """Rewrite the files derived from the entries: the attribution file, and the reports on all entries together.

    If all of them are as they were written for the same entries, they are kept.

    Args:
        table: the entries as they were before the run; None: they are read.
    """
    if table is None or not table.is_current():
        table = EntryTable(library)
    made_by = digest_of(key_of(write_reports), weights)
    if table.has_reports(made_by, DERIVED):
        return
    attribution.write(library, table.entries)
    review.write(library, table.entries)
    compare_library(library, table, clip.load_clip(weights) if weights else None)
    table.keep_reports(made_by, DERIVED)
