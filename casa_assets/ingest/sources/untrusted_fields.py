"""Read the text fields of a package without trust: types checked, lengths capped, JSON kept shallow."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.notes import printable

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
