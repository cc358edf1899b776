"""Words of strangers, made fit for a terminal."""

from __future__ import annotations


def plain(text: str) -> str:
    """The text on one line, without what a terminal would act on: such characters become backslash escapes."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)
