"""Read rows that describe meshes, of manifests, tables and shards of WebDataset, without trusting them.

Types are checked, lengths capped, JSON is kept shallow, and words for a licence become SPDX ids.
"""

from __future__ import annotations

import codecs
import json
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import starmap

from casa_assets.errors import Rejected
from casa_assets.formats.read.text import Notes, printable
from casa_assets.ingest.sources.places import MAX_HINTS, Found, Package, Refused, unique_hints, words_of_path
from casa_assets.model import rejection_codes as codes
from casa_assets.model.issue import Issue
from casa_assets.model.source import Source, SourceKind

MAX_CHARACTERS = 2000
# Three bytes of JSON can make an object of a hundred; 800,000 pairs, as Objaverse lists them, are the largest known.
MAX_VALUES = 5_000_000
_SAFE_ID = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,127}")


def parse_json(text: bytes | str, place: str) -> object:
    """JSON value; NaN, infinities and endless integers are None. Raises Rejected: BAD_ROW, also of too many values."""
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


def text_list(values: object) -> list[str]:
    """Texts of a list of texts or of objects with a `name`; a bare text counts as one."""
    if isinstance(values, str):
        return [printable(values)]
    if not isinstance(values, list):
        return []
    found = [
        text_field(v, "name") if isinstance(v, dict) else printable(v) if isinstance(v, str) else "" for v in values
    ]
    return [w for w in found[:MAX_HINTS] if w]


def check_unique(uid: str, place: str, ids: Mapping[str, str]) -> None:
    """Raises Rejected: DUPLICATE_ID if an earlier row of the file has the id; `ids`: with the place of each."""
    if uid in ids:
        raise Rejected(codes.DUPLICATE_ID, f"{place}: id {uid!r} was used by {ids[uid]}; rename one")


def as_object(row: object, place: str) -> Mapping[str, object]:
    """A row that is a JSON object. Raises Rejected BAD_ROW: it is none."""
    if not isinstance(row, dict):
        raise Rejected(codes.BAD_ROW, f"{place}: {printable(json.dumps(row), 40)} is not an object; fix it")
    return row


def safe_id(value: object, place: str) -> str:
    """An id fit for names of output. Raises Rejected: BAD_ROW where it is no text, BAD_ID where it may be a path."""
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

    `path`: of its file, as the source calls it. `uid`: its id, or empty. `names`: of the file and the folders around
    it, which may name the category; the best first.
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


# Names that announce a manifest, whatever the state of its content.
NAMES = frozenset({"manifest.jsonl", "manifest.json"})
# A run keeps all of its inputs in memory, to find the same bytes and to settle copies in their order: 2.3 kB for a row
# of a manifest, so 0.6 GB for this many. The work on them would take a core three weeks.
MAX_ROWS, MAX_BROKEN_ROWS = 250_000, 1000


def read_lines(package: Package, name: str, is_named: bool) -> Iterator[Found | Refused]:
    """Inputs of a `.jsonl` manifest; nothing of another `.jsonl`, unless `is_named`: the user pointed at it."""
    try:
        data = package.read(name)
    except Rejected as error:
        yield package.refuse(name, error)
        return
    if not (is_named or name.lower() in NAMES or b'"file"' in data):
        return
    ids: dict[str, str] = {}

    def row(number: int, line: bytes) -> Found | Refused:
        place = f"{printable(name)} line {number}"
        return _row(package, name, place, lambda: parse_json(line.decode("utf-8", "replace"), place), ids)

    filled = ((n, line) for n, line in enumerate(_lines(data.removeprefix(codecs.BOM_UTF8)), start=1) if line.strip())
    yield from _bounded(package, name, starmap(row, filled))


def _lines(data: bytes) -> Iterator[bytes]:
    """Lines one by one: a list of all of them could be many times larger than the file."""
    end, start = b"\n" if b"\n" in data else b"\r", 0
    while start <= len(data):
        stop = data.find(end, start)
        stop = len(data) if stop < 0 else stop
        yield data[start:stop]
        start = stop + 1


def read_list(package: Package, name: str, is_named: bool) -> Iterator[Found | Refused]:
    """Inputs of a `.json` list whose rows have `id` and `file`; nothing where it is some other JSON."""
    must = is_named or name.lower() in NAMES
    try:
        data = package.read(name)
        if not must and not data.removeprefix(codecs.BOM_UTF8).lstrip().startswith(b"["):
            return
        rows = parse_json(data.removeprefix(codecs.BOM_UTF8), name)
    except Rejected as error:
        if must:
            yield package.refuse(name, Rejected(codes.BAD_MANIFEST, error.message))
        return
    is_manifest = isinstance(rows, list) and any(isinstance(r, dict) and "id" in r and "file" in r for r in rows)
    if not isinstance(rows, list) or not is_manifest:
        if must:
            message = f"{name}: not a list of rows with `id` and `file`; fix it"
            yield package.refuse(name, Rejected(codes.BAD_MANIFEST, message))
        return
    ids: dict[str, str] = {}

    def read(number: int, row: object) -> Found | Refused:
        return _row(package, name, f"{name} row {number}", lambda: row, ids)

    yield from _bounded(package, name, starmap(read, enumerate(rows, start=1)))


def _bounded(package: Package, name: str, rows: Iterator[Found | Refused]) -> Iterator[Found | Refused]:
    """The rows, until there are more, or more broken ones, than any honest manifest has."""
    broken = 0
    for number, one in enumerate(rows, start=1):
        broken += isinstance(one, Refused) and one.code == codes.BAD_ROW
        if number > MAX_ROWS or broken > MAX_BROKEN_ROWS:
            most, advice = f"{MAX_BROKEN_ROWS} broken rows", "fix the file"
            if number > MAX_ROWS:
                most = f"{MAX_ROWS} rows, which is what a run holds in memory"
                advice = "split the file and ingest its parts one after the other into the same library"
            message = f"{printable(name)}: more than {most}; the rows from {number} on were not read, {advice}"
            yield package.refuse(name, Rejected(codes.BAD_MANIFEST, message))
            return
        yield one


def _row(package: Package, name: str, place: str, read: Callable[[], object], ids: dict[str, str]) -> Found | Refused:
    """One row of a manifest; refused with its place where anything in it is wrong."""
    try:
        row = as_object(read(), place)
        uid = safe_id(row.get("id"), place)
        check_unique(uid, place, ids)
        check_types(row, place)
        main = package.file(row.get("file"), place)
        ids[uid] = place
        source = source_of(row, main, uid, words_of_path(main))
        return replace(package.found(main, source), notes=remarks(place, row))
    except Rejected as error:
        return package.refuse(name, error)
