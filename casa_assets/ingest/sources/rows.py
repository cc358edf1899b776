"""Read the description of a mesh in a row (of a manifest, a table, a shard of WebDataset), without trusting it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.notes import Notes, printable
from casa_assets.ingest.sources.licence import spdx_id
from casa_assets.ingest.sources.untrusted_fields import text_field, text_list, unique_hints
from casa_assets.model.issue import Issue
from casa_assets.model.source import Source, SourceKind

# Fields that have to be text where there are any; `tags` may be a list of texts.
TEXTS = ("prompt", "category", "generator", "license", "licence", "name", "title", "author", "uri")


def check_types(row: Mapping[str, object], place: str) -> None:
    """Check the fields of a row. Raises Rejected: BAD_ROW if a field that has to be text is not text."""
    for key in TEXTS:
        value = row.get(key)
        if value is not None and not isinstance(value, str):
            message = f"{place}: {key} {printable(repr(value), 40)} is not text; fix it"
            raise Rejected(codes.BAD_ROW, message)


def remarks(place: str, row: Mapping[str, object]) -> tuple[Issue, ...]:
    """Notes on values that are NaN or infinite: they are ignored, but whoever wrote them meant something."""
    notes = Notes()
    for key, value in row.items():
        if isinstance(value, float) and not math.isfinite(value):
            notes.add(codes.NUMBER_IGNORED, place, f"{printable(key, 40)!r} is {value}, which is no number; ignored")
    return notes.issues


def source_of(row: Mapping[str, object], path: str, uid: str, names: Iterable[str]) -> Source:
    """A mesh as its row describes it.

    Args:
        path: of its file, as the source calls it. uid: its id, or empty.
        names: of the file and the folders around it, which may name the category; the best first.
    """
    prompt, generator = text_field(row, "prompt"), text_field(row, "generator")
    title = text_field(row, "name") or text_field(row, "title")
    return Source(
        kind=SourceKind.TEXT_TO_3D if prompt or generator else SourceKind.MANIFEST,
        path=path,
        uid=uid,
        title=title,
        author=text_field(row, "author"),
        licence=spdx_id(text_field(row, "license") or text_field(row, "licence")),
        uri=text_field(row, "uri") or text_field(row, "url"),
        prompt=prompt,
        generator=generator,
        category=text_field(row, "category"),
        hints=unique_hints([title], text_list(row.get("tags")), [prompt], names, [uid]),
    )
