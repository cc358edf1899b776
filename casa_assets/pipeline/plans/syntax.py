"""Mend text that is no YAML: fences and prose around it, tabs, brackets and quotes that are open, and the like."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

from casa_assets.errors import RegistryError
from casa_assets.pipeline.plans.fault import Fault, Mend
from casa_assets.registry.read import parse_document

FENCE = re.compile(r"^\s*(```|~~~)")
BEGIN = re.compile(r"^(\w[\w ]*:(\s|$)|\{|\[|---)")
KEY = re.compile(r"^(\s*(?:- )?)([A-Za-z_]\w*):(?=[^\s:/])")
QUOTES = str.maketrans({"“": '"', "”": '"', "„": '"', "‘": "'", "’": "'", "\u00a0": " ", "\ufeff": ""})
BULLET = re.compile(r"^(\s*)[*•‣◦–]\s+")
CLOSERS = {"{": "}", "[": "]"}
ROWS_BY_NAME = {"walls", "openings", "runs", "worktop_items", "wall_items", "floor_items"}


def text_fault(text: str, name: str) -> Fault | None:
    """What keeps a text from being read as YAML, the first such thing; None where it is read.

    Args:
        name: of the file, for messages.
    """
    for find in (_fence, _typographic, _bullets, _documents):
        fault = find(text)
        if fault:
            return fault
    try:
        value = parse_document(text, name).value
    except RegistryError as error:
        return _unread(text, name, error)
    return None if isinstance(value, dict | list) and value else _prose(text, name)


def _mended(line: int, expected: str, got: str, sentence: str, text: str | None) -> Fault:
    return Fault((), expected, got, None if text is None else Mend(sentence, text=text), line)


def _fence(text: str) -> Fault | None:
    lines = text.splitlines()
    marks = [k for k, line in enumerate(lines) if FENCE.match(line)]
    if not marks:
        return None
    inside = lines[marks[0] + 1 : marks[1] if len(marks) > 1 else None]
    return _mended(
        marks[0] + 1,
        "YAML alone",
        "a fence of Markdown",
        "Keep only what stands inside the fence.",
        "\n".join(inside) + "\n",
    )


def _typographic(text: str) -> Fault | None:
    plain = text.translate(QUOTES)
    if plain == text:
        return None
    line = next(k for k, (a, b) in enumerate(zip(text.split("\n"), plain.split("\n"), strict=True), 1) if a != b)
    return _mended(line, "plain quotes and spaces", "typographic ones", "Write plain quotes and spaces.", plain)


def _bullets(text: str) -> Fault | None:
    lines = text.splitlines()
    plain = [BULLET.sub(r"\1- ", line) for line in lines]
    line = next((k for k, (a, b) in enumerate(zip(lines, plain, strict=True), 1) if a != b), 0)
    if not line:
        return None
    return _mended(line, "items behind a hyphen", "bullets", "Begin items with a hyphen.", "\n".join(plain) + "\n")


def _documents(text: str) -> Fault | None:
    lines = text.splitlines()
    marks = [k for k, line in enumerate(lines) if line.rstrip() in ("---", "...") and any(x.strip() for x in lines[:k])]
    begun = [k for k in marks if any(x.strip() and not x.lstrip().startswith("#") for x in lines[:k])]
    if not begun:
        return None
    return _mended(
        begun[0] + 1,
        "one plan in a file",
        "a second document",
        f"Take out line {begun[0] + 1} and what follows.",
        "\n".join(lines[: begun[0]]) + "\n",
    )


def _prose(text: str, name: str) -> Fault:
    """Words before or behind the YAML, or nothing at all."""
    lines = text.splitlines()
    first = next((k for k, line in enumerate(lines) if BEGIN.match(line)), None)
    if first is None or not any(line.strip() for line in lines):
        return _mended(1, "a plan, beginning with `title:`", "none", "", None)
    # Prose at the margin ends a plan, whose lines at the margin are keys, items, brackets or comments.
    last = next(
        (
            k
            for k in range(first + 1, len(lines))
            if lines[k][:1].strip() and not re.match(r"[\w ]+:|[-#}\]]", lines[k])
        ),
        len(lines),
    )
    return _mended(
        1 if first else last + 1,
        "YAML alone",
        "words around it",
        "Keep only the YAML.",
        "\n".join(lines[first:last]) + "\n" if first or last < len(lines) else None,
    )


def _unread(text: str, name: str, error: RegistryError) -> Fault:
    """The fault of a text that YAML cannot read, with the first change that brings the reader further."""
    for sentence, changed in _candidates(text, error):
        if changed != text and _reads_further(changed, name, error.line):
            return _mended(error.line, error.expected, error.got, sentence, changed)
    prose = _prose(text, name)
    if prose.mend and prose.mend.text and _reads_further(prose.mend.text, name, 0):
        return prose
    return _mended(error.line, error.expected, error.got, "", None)


def _reads_further(text: str, name: str, line: int) -> bool:
    try:
        parse_document(text, name)
    except RegistryError as error:
        return line > 0 and error.line > line
    return True


def _candidates(text: str, error: RegistryError) -> Iterator[tuple[str, str]]:
    lines = text.split("\n")
    if "each key once" in error.expected:
        yield from _second_key(lines, error)
    tabs = "\n".join(re.sub(r"^[ \t]*\t[ \t]*", lambda m: m.group().replace("\t", "  "), line) for line in lines)
    yield "Indent with spaces in place of tabs.", tabs
    yield "Put a space behind each colon.", "\n".join(KEY.sub(r"\1\2: ", line) for line in lines)
    yield "Write comments behind #.", "\n".join(re.sub(r"(^|\s)//", r"\1#", line) for line in lines)
    last = min(error.line, len(lines))
    for sentence, change in _LINE_CHANGES:
        for k in range(last - 1, -1, -1):
            changed = change(lines, k)
            if changed is not None:
                yield f"{sentence} in line {k + 1}.", "\n".join([*lines[:k], changed, *lines[k + 1 :]])
            if k < last - 4:
                break
    for k in range(len(lines)):
        if (changed := _closed_quote(lines, k)) is not None:
            yield f"Close the quotes in line {k + 1}.", "\n".join([*lines[:k], changed, *lines[k + 1 :]])
    for k in (last - 1, last - 2):
        if 0 <= k < len(lines):
            for column in _indents(lines[:k]):
                changed = " " * column + lines[k].lstrip()
                yield f"Indent line {k + 1} by {column} spaces.", "\n".join([*lines[:k], changed, *lines[k + 1 :]])


def _second_key(lines: list[str], error: RegistryError) -> Iterator[tuple[str, str]]:
    path = error.pointer.split(".")
    key, k = path[-1], error.line - 1
    named = len(path) == 2 and path[0] in ROWS_BY_NAME
    if named and path[0] != "worktop_items":
        yield (
            f"Call the second {key!r} {key}_2.",
            "\n".join(
                [
                    *lines[:k],
                    re.sub(rf"\b{re.escape(key)}(?=['\"]?\s*:)", f"{key}_2", lines[k], count=1),
                    *lines[k + 1 :],
                ]
            ),
        )
    indent = len(lines[k]) - len(lines[k].lstrip())
    end = k + 1
    while end < len(lines) and (not lines[end].strip() or len(lines[end]) - len(lines[end].lstrip()) > indent):
        end += 1
    if re.match(rf"\s*['\"]?{re.escape(key)}['\"]?\s*:", lines[k]):
        yield f"Take out the second {key!r}.", "\n".join([*lines[:k], *lines[end:]])
    yield (
        f"Take out the second {key!r}.",
        "\n".join([*lines[:k], re.sub(rf"(.*),\s*{re.escape(key)}:[^,}}]*", r"\1", lines[k]), *lines[k + 1 :]]),
    )


def _indents(before: list[str]) -> list[int]:
    """Indents of the lines above, the nearest line first, each once."""
    found = [len(line) - len(line.lstrip()) for line in reversed(before) if line.strip()]
    return list(dict.fromkeys(found))


def _balanced(lines: list[str], k: int) -> str | None:
    """The line with its brackets closed, or without those that close nothing."""
    body, hash_, comment = lines[k].partition(" #")
    open_: list[str] = []
    kept: list[str] = []
    for letter in body:
        if letter in CLOSERS:
            open_.append(CLOSERS[letter])
        elif letter in CLOSERS.values():
            if letter not in open_:
                continue
            while open_[-1] != letter:
                kept.append(open_.pop())
            open_.pop()
        kept.append(letter)
    closed = "".join(kept).rstrip()
    closed = closed.rstrip(",") + "".join(reversed(open_)) if open_ else closed
    return closed + hash_ + comment if closed != body.rstrip() else None


def _closed_quote(lines: list[str], k: int) -> str | None:
    for quote in "\"'":
        if lines[k].count(quote) % 2:
            return re.sub(r"([\s}\],]*)$", rf"{quote}\1", lines[k], count=1)
    return None


def _quoted_value(lines: list[str], k: int) -> str | None:
    found = re.match(r"^(\s*(?:- )?\w+:\s+)([^\s'\"{\[].*)$", lines[k])
    if not found:
        return None
    text = found[2].rstrip().replace("\\", "").replace('"', "'")
    return f'{found[1]}"{text}"'


def _with_colon(lines: list[str], k: int) -> str | None:
    found = re.match(r"^(\s*\w+)(\s+[{\[].*|\s*=\s*.*)?$", lines[k])
    return f"{found[1]}: {(found[2] or '').strip().lstrip('=').strip()}".rstrip() if found else None


def _with_space_after_dash(lines: list[str], k: int) -> str | None:
    found = re.match(r"^(\s*)[-*•–]\s*(\w.*)$", lines[k])
    return f"{found[1]}- {found[2]}" if found else None


_LINE_CHANGES: tuple[tuple[str, Callable[[list[str], int], str | None]], ...] = (
    ("Close the brackets that are open, and no others,", _balanced),
    ("Close the quotes", _closed_quote),
    ("Put a colon behind the key", _with_colon),
    ("Begin the item with a hyphen and a space", _with_space_after_dash),
    ("Put the value in quotes", _quoted_value),
)
