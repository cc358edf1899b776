"""Read the description of a mesh in a row (of a manifest, a table, a shard of WebDataset), without trusting it.

Types are checked, lengths capped, JSON is kept shallow, and words for a licence become SPDX ids.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping

from casa_assets.errors import Rejected
from casa_assets.formats.read.text import Notes, printable
from casa_assets.model import rejection_codes as codes
from casa_assets.model.issue import Issue
from casa_assets.model.source import Source, SourceKind

MAX_CHARACTERS = 2000
# Three bytes of JSON can make an object of a hundred; 800,000 pairs, as Objaverse lists them, are the largest known.
MAX_VALUES = 5_000_000
MAX_HINTS = 40
_SAFE_ID = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,127}")


def parse_json(text: bytes | str, place: str) -> object:
    """JSON value; NaN, infinities and endless integers are read as None.

    Raises:
        Rejected: BAD_ROW where it is broken, nested too deep, or holds more values than any index needs.
    """
    raw = text if isinstance(text, bytes) else text.encode("utf-8", "replace")
    if sum(raw.count(mark) for mark in (b",", b"[", b"{")) > MAX_VALUES:
        raise Rejected(codes.BAD_ROW, f"{place}: more than {MAX_VALUES} values; split the file")
    try:
        return json.loads(text, parse_constant=lambda _: None, parse_int=_whole)
    except RecursionError as error:
        raise Rejected(codes.BAD_ROW, f"{place}: JSON nested too deep; fix the line") from error
    except ValueError as error:
        raise Rejected(codes.BAD_ROW, f"{place}: broken JSON ({printable(str(error), 80)}); fix the line") from error


def _whole(digits: str) -> int | None:
    return int(digits) if len(digits) < 20 else None


def text_field(row: Mapping[str, object], key: str) -> str:
    """Text at `key`, cleaned of control characters; empty where it is missing or no text."""
    value = row.get(key)
    return printable(value, MAX_CHARACTERS).strip() if isinstance(value, str) else ""


def text_list(values: object, key: str = "name") -> list[str]:
    """Texts of a list of texts or of objects with a `key`; a bare text counts as one."""
    if isinstance(values, str):
        return [printable(values)]
    if not isinstance(values, list):
        return []
    found = [text_field(v, key) if isinstance(v, dict) else printable(v) if isinstance(v, str) else "" for v in values]
    return [w for w in found[:MAX_HINTS] if w]


def unique_hints(*groups: Iterable[str]) -> tuple[str, ...]:
    """All words in order, each once, without empty ones and content hashes."""
    out: dict[str, None] = {}
    for group in groups:
        for one in group:
            text = one.strip()
            if text and not re.fullmatch(r"[0-9a-f]{8,64}|\d+(-\d+)?", text):
                out[text] = None
    return tuple(out)[:MAX_HINTS]


def safe_id(value: object, place: str) -> str:
    """An id that is used for output names.

    Raises:
        Rejected: BAD_ROW where it is no text, BAD_ID where it could name a path.
    """
    if not isinstance(value, str):
        raise Rejected(codes.BAD_ROW, f"{place}: id {printable(repr(value), 40)} is no text; fix it")
    if not _SAFE_ID.fullmatch(value) or ".." in value:
        message = f"{place}: id {printable(repr(value), 40)} is not letters, digits, `_`, `-` and `.`; fix it"
        raise Rejected(codes.BAD_ID, message)
    return value


# Objaverse uses Sketchfab's slugs, which are Creative Commons 4.0. Ref: https://objaverse.allenai.org/objaverse-1.0
_SLUGS = {
    "by": "CC-BY-4.0",
    "by-sa": "CC-BY-SA-4.0",
    "by-nd": "CC-BY-ND-4.0",
    "by-nc": "CC-BY-NC-4.0",
    "by-nc-sa": "CC-BY-NC-SA-4.0",
    "by-nc-nd": "CC-BY-NC-ND-4.0",
    "cc0": "CC0-1.0",
    "publicdomain": "CC0-1.0",
    "mit": "MIT",
    "mit-0": "MIT-0",
    "apache": "Apache-2.0",
    "bsd-3-clause": "BSD-3-Clause",
    "bsd-2-clause": "BSD-2-Clause",
}
# The long names that GitHub and Sketchfab show.
_NAMES = {
    "mit license": "MIT",
    "apache license 2.0": "Apache-2.0",
    "creative commons attribution": "CC-BY-4.0",
    "creative commons attribution 4.0 international": "CC-BY-4.0",
    "creative commons attribution share alike 4.0 international": "CC-BY-SA-4.0",
    "creative commons zero v1.0 universal": "CC0-1.0",
    "cc0 public domain": "CC0-1.0",
    "the unlicense": "Unlicense",
    'bsd 3-clause "new" or "revised" license': "BSD-3-Clause",
    'bsd 2-clause "simplified" license': "BSD-2-Clause",
    "gnu general public license v3.0": "GPL-3.0-only",
    "gnu general public license v2.0": "GPL-2.0-only",
}
# SPDX ids in any case. Ref: hubs of models and data sets write them small.
_IDS = {spdx_id.lower(): spdx_id for spdx_id in (*_SLUGS.values(), *_NAMES.values())}
_CREATIVE = re.compile(r"cc[ -](by(?:-(?:nc|sa|nd)){0,2})[ -]v?(\d\.\d)")


def spdx_id(word: str) -> str:
    """SPDX id where the word maps to one, the word itself where not, `unknown` where it is empty."""
    text = " ".join(word.split())
    key = text.lower()
    if not key:
        return "unknown"
    if key in _SLUGS or key in _NAMES:
        return _SLUGS.get(key) or _NAMES[key]
    if key in _IDS:
        return _IDS[key]
    creative = _CREATIVE.fullmatch(key.replace(" by ", "-by-").replace("by nc", "by-nc"))
    if creative:
        return f"CC-{creative.group(1).upper()}-{creative.group(2)}"
    return text[:80]


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
