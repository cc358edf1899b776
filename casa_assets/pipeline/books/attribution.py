"""ATTRIBUTION.md of a library: who made what, under which licence, generated from the entries."""

from __future__ import annotations

import os
from collections import defaultdict

from casa_assets.pipeline import library as disk
from casa_assets.pipeline.books.entry import Entry, entries

NAME = "ATTRIBUTION.md"


def write(library: disk.Library) -> None:
    """Write the file anew, in place by one rename."""
    target = library.root / NAME
    fresh = library.private / f"{NAME}.{os.getpid()}"
    fresh.write_text(text([e for e in entries(library) if e.accepted]), encoding="utf-8")
    fresh.replace(target)


def text(accepted: list[Entry]) -> str:
    """Markdown: one section per licence, one line per asset with title, author, source and digest."""
    by_licence: dict[str, list[Entry]] = defaultdict(list)
    for entry in accepted:
        by_licence[entry.licence].append(entry)
    lines = ["# Attribution", "", f"{len(accepted)} assets. Changes made to all of them: cleaned, oriented, scaled to"]
    lines += ["metres, simplified where large, given collision shapes, mass and labels; written as MJCF and USD.", ""]
    for licence in sorted(by_licence):
        lines += [f"## {licence}", ""]
        if licence == "unknown":
            lines += ["The source states no licence; do not pass these on before you have asked.", ""]
        lines += [_line(e) for e in sorted(by_licence[licence], key=lambda e: e.id)]
        lines.append("")
    return "\n".join(lines)


def _line(entry: Entry) -> str:
    title = _plain(entry.title or entry.source_path.rsplit("/", 1)[-1])
    author = f" by {_plain(entry.author)}" if entry.author else ""
    made = f", made with {_plain(entry.generator)}" if entry.generator else ""
    uri = f", {_plain(entry.uri)}" if entry.uri else ""
    return f"- `{entry.id}`: {title}{author}{made}{uri} (source sha256 {entry.sha256[:12]})"


def _plain(words: str) -> str:
    """Text of strangers on one line, with nothing that Markdown or HTML would act on."""
    return " ".join("".join(c if c.isprintable() and c not in "<>`[]|" else " " for c in words).split())
