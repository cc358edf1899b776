"""ATTRIBUTION.md shows the words of strangers and does nothing that they say."""

from __future__ import annotations

import dataclasses
import re

import pytest

from casa_assets.library.attribution import escaped, text
from casa_assets.library.entry import Entry

HOSTILE = (
    "![](https://evil.example/t.png)",
    "[free](javascript:alert(1))",
    "<img src=x onerror=alert(1)>",
    "<https://evil.example>",
    "a | b |\n| --- | --- |",
    "x\n\n# heading\n\n- item",
    "`code` **bold** _it_ ~~gone~~",
    "https://evil.example www.evil.example a@evil.example",
    "&lt;b&gt; \u202e \x1b[31m",
    "back\\slash \\[x](y)",
)
FIELDS = ("title", "author", "licence", "generator", "uri", "source_path", "id")


def entry(**changes: str) -> Entry:
    words = {f.name: "" for f in dataclasses.fields(Entry)}
    words |= {"id": "mug_0123456789", "category": "mug", "sha256": "ab" * 32, "licence": "CC0-1.0", **changes}
    return Entry(**{**words, "accepted": True, "summary": None, "warnings": (), "results": (), "guesses": ()})  # type: ignore[arg-type]


def unescaped(line: str) -> str:
    """A line without its code spans and without what is escaped: what Markdown would act on."""
    return re.sub(r"\\.", "", re.sub(r"`[^`]*`", "", line))


def test_no_field_is_markup(subtests: pytest.Subtests) -> None:
    for words in HOSTILE:
        for field in FIELDS:
            with subtests.test(field=field, words=words):
                lines = text([entry(**{field: words})]).splitlines()
                (line,) = [one for one in lines if one.startswith("- ")]
                headings = [one for one in lines if one.startswith("#")]
                assert len(headings) == 2
                for one in (line.removeprefix("- "), headings[1].removeprefix("## ")):
                    assert not set(unescaped(one)) & set("<>[]|*_~`&!#@\\"), one
                    assert "://" not in unescaped(one)
                    assert "www." not in unescaped(one)
                    assert one.isprintable()


def test_plain_words_and_addresses_stay() -> None:
    assert escaped("A mug, by A. B.-C. (2024)") == "A mug, by A. B.-C. (2024)"
    line = text([entry(title="Mug", uri="https://example.org/a/b?c=1")])
    assert ": Mug, https://example.org/a/b?c=1 (source sha256 abababababab)" in line
