"""Text of files (plain UTF-8 lines, rows of numbers, names as Ids), and notes, bounded whatever a file contains."""

from __future__ import annotations

import codecs
import re
import unicodedata
import warnings

import numpy as np

from casa_assets.core.numeric import Floats
from casa_assets.errors import Rejected
from casa_assets.model import rejection_codes as codes
from casa_assets.model.issue import Issue, Severity

MAX_NOTES = 40


def printable(text: str, max_length: int = 120) -> str:
    """The text without control, format and surrogate characters, at most `max_length` characters long."""
    head = text[: 4 * max_length]
    kept = "".join(c if unicodedata.category(c) not in ("Cc", "Cf", "Cs", "Co", "Zl", "Zp") else "?" for c in head)
    return kept if len(kept) <= max_length else kept[: max_length - 3] + "..."


class Notes:
    """Collects warnings: the same code at the same pointer once, at most MAX_NOTES in all."""

    def __init__(self) -> None:
        self._issues: dict[tuple[str, str], Issue] = {}
        self._left_out = 0

    def add(self, code: str, pointer: str, message: str) -> None:
        """Record one warning; `pointer` names the place in the file, `message` one sentence."""
        key = (code, printable(pointer))
        if key in self._issues:
            return
        if len(self._issues) >= MAX_NOTES:
            self._left_out += 1
            return
        self._issues[key] = Issue(code=code, severity=Severity.WARNING, pointer=key[1], message=printable(message, 400))

    @property
    def issues(self) -> tuple[Issue, ...]:
        """All that was recorded, in order; a last one counts what was left out."""
        found = tuple(self._issues.values())
        if not self._left_out:
            return found
        message = f"{self._left_out} more warnings were left out of this list"
        return (*found, Issue(code=codes.MORE_NOTES, severity=Severity.WARNING, message=message))


MAX_CHARACTERS = 60


def normalize_text(data: bytes, name: str) -> bytes:
    """UTF-8 without byte order mark, lines ended by a single newline.

    Raises:
        Rejected: ENCODING where the bytes are no text (NUL bytes) or broken UTF-16.
    """
    if data.startswith(codecs.BOM_UTF8):
        data = data[3:]
    elif data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        try:
            data = data.decode("utf-16").encode("utf-8")
        except UnicodeError as error:
            raise Rejected(codes.ENCODING, f"{name}: broken UTF-16 ({error.args[-1]}); save it as UTF-8") from error
    elif b"\0" in data[:4096]:
        raise Rejected(codes.ENCODING, f"{name}: holds NUL bytes, so it is no text file; save it as UTF-8 text")
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return data


def decode(raw: bytes) -> str:
    """Text of a short byte string: UTF-8, or Windows-1252 where it is not UTF-8."""
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("cp1252", "replace")


def numbers(lines: list[bytes], min_columns: int, max_columns: int, keyword: str) -> Floats:
    """(N, max_columns) float64; columns that a line does not have are NaN, and those beyond are dropped without a note.

    Raises:
        Rejected: BAD_NUMBER with the first bad line.
    """
    counts = np.fromiter((len(line.split()) for line in lines), dtype=np.int64, count=len(lines))
    flat = parsed_numbers(b" ".join(lines))
    if flat is None or len(flat) != int(counts.sum()) or (len(counts) and int(counts.min()) < min_columns):
        return _slow_numbers(lines, min_columns, max_columns, keyword)
    if len(counts) and int(counts.min()) == int(counts.max()):
        table = flat.reshape(len(lines), -1)[:, :max_columns]
        pad = max_columns - table.shape[1]
        return table if not pad else np.hstack((table, np.full((len(lines), pad), np.nan)))
    out = np.full((len(lines), max_columns), np.nan)
    starts = np.concatenate(([0], np.cumsum(counts)[:-1])) if len(counts) else np.zeros(0, dtype=np.int64)
    for column in range(max_columns):
        rows = np.flatnonzero(counts > column)
        out[rows, column] = flat[starts[rows] + column]
    return out


def _slow_numbers(lines: list[bytes], min_columns: int, max_columns: int, keyword: str) -> Floats:
    out = np.full((len(lines), max_columns), np.nan)
    for i, line in enumerate(lines):
        words = line.partition(b"#")[0].split()[:max_columns]
        try:
            values = [float(word) for word in words]
        except ValueError as error:
            message = f"`{keyword} {printable(decode(line), 60)}` (number {i + 1} of its kind) is not a row of numbers"
            raise Rejected(codes.BAD_NUMBER, message + "; export with decimal points") from error
        if len(values) < min_columns:
            message = f"`{keyword} {printable(decode(line), 60)}`: {min_columns} numbers wanted; export it again"
            raise Rejected(codes.BAD_NUMBER, message)
        out[i, : len(values)] = values
    return out


def parsed_numbers(text: bytes) -> Floats | None:
    """All numbers of a text, or None if any word in it is not a number."""
    if not text.strip():
        return np.zeros(0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return np.fromstring(text.decode("ascii"), dtype=np.float64, sep=" ")
        except (ValueError, DeprecationWarning):
            return None


def identifier(text: str, fallback: str) -> str:
    """`text` as an Id; starts with `fallback` where nothing usable is left or it would start with a digit."""
    ascii_text = unicodedata.normalize("NFKD", text[:400]).encode("ascii", "ignore").decode("ascii")
    parted = re.sub(r"([a-z0-9])([A-Z][a-z])", r"\1_\2", ascii_text)
    words = re.sub(r"[^a-z0-9]+", "_", parted.lower()).strip("_")
    if not words:
        return fallback
    if words[0].isdigit():
        words = f"{fallback}_{words}"
    return words[:MAX_CHARACTERS].rstrip("_")


class UniqueNames:
    """Hands out Ids, each once."""

    def __init__(self) -> None:
        self._taken: set[str] = set()
        self._next: dict[str, int] = {}

    def unique(self, text: str, fallback: str) -> str:
        """`text` as an Id that was not handed out before: `lid`, `lid_2`, `lid_3`."""
        stem = identifier(text, fallback)
        name = stem
        while name in self._taken:
            number = self._next.get(stem, 2)
            self._next[stem] = number + 1
            name = f"{stem}_{number}"
        self._taken.add(name)
        return name
