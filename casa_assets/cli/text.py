"""Text for a terminal: untrusted words with control characters escaped, and counts with their nouns."""

from __future__ import annotations

from pathlib import PurePath


def terminal_safe(text: str) -> str:
    """The text on one line, without what a terminal would act on: such characters become backslash escapes."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def without_name(message: str, path: str) -> str:
    """A message about a file, for a line that begins with the name of the file already."""
    return message.removeprefix(f"{path}: ").removeprefix(f"{PurePath(path).name}: ")


def pluralize(number: int, thing: str) -> str:
    """`1 input`, `2 inputs`, `3 categories`, `0 boxes`."""
    if number == 1:
        return f"1 {thing}"
    if thing.endswith("y"):
        return f"{number} {thing[:-1]}ies"
    return f"{number} {thing}{'es' if thing.endswith(('s', 'x', 'ch', 'sh')) else 's'}"
