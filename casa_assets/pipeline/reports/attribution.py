"""ATTRIBUTION.md of a library: who made what, under which licence, generated from the entries."""

from __future__ import annotations

import os
import re
from collections import defaultdict
from collections.abc import Iterable

from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.reports.entry import Entry

NAME = "ATTRIBUTION.md"
# Of one field; what is longer is no name of a thing, a person or a licence.
MAX_CHARACTERS = 300
_WEB_ADDRESS = re.compile(r"https?://[A-Za-z0-9.-]+(:[0-9]+)?(/[A-Za-z0-9._~/%?=+,;:@-]*)?")


def write(library: disk.Library, found: Iterable[Entry]) -> None:
    """Write the file anew from the entries, in place by one rename."""
    target = library.root / NAME
    fresh = library.private / f"{NAME}.{os.getpid()}"
    fresh.write_text(text([e for e in found if e.accepted]), encoding="utf-8")
    fresh.replace(target)


def text(accepted: list[Entry]) -> str:
    """Markdown: one section per licence, one line per asset with title, author, source and digest."""
    by_licence: dict[str, list[Entry]] = defaultdict(list)
    for entry in accepted:
        by_licence[entry.licence].append(entry)
    lines = ["# Attribution", "", f"{len(accepted)} assets. Changes made to all of them: cleaned, oriented, scaled to"]
    lines += ["metres, simplified where large, given collision shapes, mass and labels; written as MJCF and USD.", ""]
    for licence in sorted(by_licence):
        lines += [f"## {escaped(licence)}", ""]
        if licence == "unknown":
            lines += ["The source states no licence; do not pass these on before you have asked.", ""]
        lines += [_line(e) for e in sorted(by_licence[licence], key=lambda e: e.id)]
        lines.append("")
    return "\n".join(lines)


def _line(entry: Entry) -> str:
    title = escaped(entry.title or entry.source_path.rsplit("/", 1)[-1])
    author = f" by {escaped(entry.author)}" if entry.author else ""
    made = f", made with {escaped(entry.generator)}" if entry.generator else ""
    uri = f", {_address(entry.uri)}" if entry.uri else ""
    return f"- `{_in_code(entry.id)}`: {title}{author}{made}{uri} (source sha256 {_in_code(entry.sha256[:12])})"


def escaped(words: str) -> str:
    """Words of strangers as Markdown that shows them, on one line, with no markup, picture or link of theirs.

    Ref: CommonMark 0.31, backslash escapes; GFM, autolinks (extension), which take bare `https://`, `www.` and `a@b`.
    """
    plain = _one_line(words)
    plain = re.sub(r"([\\`*_\[\]<>|~&!#@])", r"\\\1", plain)
    return re.sub(r"(?i)\b(www)\.", r"\1\.", plain.replace("://", "\\://"))


def _address(uri: str) -> str:
    """Markdown for the address of a source: a link where it is a plain web address, else only its text."""
    return uri if _WEB_ADDRESS.fullmatch(uri) else escaped(uri)


def _in_code(words: str) -> str:
    """Words inside backticks, which nothing but a backtick ends."""
    return _one_line(words).replace("`", "'")


def _one_line(words: str) -> str:
    text = " ".join("".join(c if c.isprintable() else " " for c in words).split())
    return text if len(text) <= MAX_CHARACTERS else f"{text[:MAX_CHARACTERS]} ..."
