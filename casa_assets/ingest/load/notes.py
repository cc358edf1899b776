"""Notes made while reading; their length and number are bounded, whatever a hostile file contains."""

from __future__ import annotations

import unicodedata

from casa_assets.ingest import rejection_codes as codes
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
