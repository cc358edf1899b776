"""Decisions of a person about the inputs of a library, which every later run on it obeys: review.csv.

It lists uncertain guesses. A row is one input. The columns that begin with `set_` are the person's: their
values are taken in place of the guess, with full confidence. Rows with such a value are kept, all others are written
again from the entries.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from casa_assets import registry
from casa_assets.errors import OutputError, UnknownId
from casa_assets.library.entry import Entry
from casa_assets.library.library import Library
from casa_assets.model.asset.asset import Guess
from casa_assets.model.issue import ASKED_CODE, REVIEW_CODE, Issue, Severity
from casa_assets.model.source import UserOverride

NAME = "review.csv"
# Of an input that a person rejects.
REJECTED_CODE = "REV002"
# A guess less sure than this is for a person to look at.
DOUBTFUL = 0.5
# What a person can decide. The front is left out: a wrong one spoils nothing, and most things have none.
SUBJECTS = ("things", "category", "up_axis", "scale", "mass", "frame", "plan", "contacts")
INFO_COLUMNS = ("sha256", "id", "input", "look_at", "category", "size_m", "up", "mass_kg", "reason")
# Fields of UserOverride.
OVERRIDE_NAMES = ("decision", "category", "up", "turn_deg", "size_m", "mass_kg")
OVERRIDE_COLUMNS = tuple(f"set_{name}" for name in OVERRIDE_NAMES)
# An input that was turned away for one of these may be a good one of a wrong size or kind.
REVIEWABLE_CODES = frozenset({"AST001", "AST002", "AST003", "AST013", "MSH003"})


@dataclass(frozen=True)
class ReviewRow:
    """One line: the cells by column, and what they rule."""

    cells: Mapping[str, str]
    override: UserOverride


def doubtful_guesses(guesses: Sequence[Guess]) -> tuple[Issue, ...]:
    """A warning for each guess that a person should look at."""
    return tuple(
        Issue(
            code=REVIEW_CODE,
            severity=Severity.WARNING,
            pointer=guess.subject,
            message=f"{guess.value} is {guess.confidence:.0%} sure: {guess.reason}; say it in {NAME}",
        )
        for guess in guesses
        if guess.subject in SUBJECTS and guess.confidence < DOUBTFUL
    )


def read_overrides(library: Library) -> dict[str, UserOverride]:
    """Read the overrides by the sha256 of their input. Raises OutputError where a cell cannot be understood."""
    return {digest: row.override for digest, row in _read(library).items() if not row.override.is_empty}


def write(library: Library, found: Iterable[Entry]) -> int:
    """Rewrite the list by one rename; without rows the file is removed. Returns the number of rows."""
    overridden = {digest: row for digest, row in _read(library).items() if not row.override.is_empty}
    rows: dict[str, Mapping[str, str]] = {digest: row.cells for digest, row in overridden.items()}
    for entry in found:
        subjects = subjects_to_review(entry)
        if entry.sha256 in overridden:
            rows[entry.sha256] = {**overridden[entry.sha256].cells, **_info_cells(entry, subjects)}
        elif subjects:
            rows[entry.sha256] = _info_cells(entry, subjects)
    return _write_rows(library, rows)


def cells(library: Library) -> dict[str, Mapping[str, str]]:
    """Cells of the rows by column, by the sha256 of their input. Raises OutputError where one cannot be understood."""
    return {digest: row.cells for digest, row in _read(library).items()}


def decide(library: Library, entry: Entry, words: Mapping[str, str]) -> None:
    """Write a person's words about an input, such as {"category": "mug"}, into its row; all other rows stay.

    Raises:
        OutputError: a word cannot be understood; nothing is written then.
    """
    stated = {f"set_{name}": words.get(name, "") for name in OVERRIDE_NAMES}
    _override_of(stated, f"{library.root / NAME}, {entry.id}", registry.load())
    rows = cells(library)
    before = rows.get(entry.sha256) or _info_cells(entry, subjects_to_review(entry))
    _write_rows(library, {**rows, entry.sha256: {**before, **stated}})


def adopt(library: Library, others: Sequence[Library]) -> None:
    """Take over the rows of other libraries in which a person decided something. Raises OutputError."""
    own = _read(library)
    decided = {digest: (library, row) for digest, row in own.items() if not row.override.is_empty}
    known = len(decided)
    for other in others:
        for digest, row in _read(other).items():
            if row.override.is_empty:
                continue
            before, first = decided.setdefault(digest, (other, row))
            if first.override != row.override:
                place, input_ = other.root / NAME, row.cells.get("input") or digest
                raise OutputError(str(place), f"decides otherwise about {input_} than {before.root / NAME}; change one")
    if len(decided) > known:
        cells_by_digest = {digest: row.cells for digest, row in own.items()}
        _write_rows(library, {**cells_by_digest, **{digest: row.cells for digest, (_, row) in decided.items()}})


def _write_rows(library: Library, rows: Mapping[str, Mapping[str, str]]) -> int:
    target = library.root / NAME
    if not rows:
        target.unlink(missing_ok=True)
        return 0
    text = io.StringIO()
    writer = csv.DictWriter(
        text, (*INFO_COLUMNS, *OVERRIDE_COLUMNS), restval="", extrasaction="ignore", lineterminator="\n"
    )
    writer.writeheader()
    writer.writerows(sorted(rows.values(), key=lambda r: (r.get("id", ""), r["sha256"])))
    if target.is_file() and target.read_bytes() == text.getvalue().encode():
        return len(rows)
    library.write(NAME, text.getvalue())
    return len(rows)


def subjects_to_review(entry: Entry) -> list[str]:
    """Return what a person should look at: subjects that have to be decided, then those that are only asked about.

    For a rejected input: its code, if kind or size may be the reason.
    """
    if not entry.accepted:
        return [entry.code] if entry.code in REVIEWABLE_CODES else []
    asked = (issue.pointer for issue in entry.warnings if issue.code == ASKED_CODE)
    return list(dict.fromkeys((*entry.to_decide, *asked)))


def _info_cells(entry: Entry, subjects: Sequence[str]) -> dict[str, str]:
    """The columns that are ours; words of strangers are made fit for a spreadsheet, which takes `=` for a formula."""
    guesses = {g.subject: g for g in entry.guesses}
    # of the guess, else of the first warning about the subject
    reasons = {issue.pointer: issue.message for issue in reversed(entry.warnings)}
    reasons |= {subject: guess.reason for subject, guess in guesses.items()}
    size = max(entry.summary.extents) if entry.summary else None
    cells = {
        "sha256": entry.sha256,
        "id": entry.id,
        "input": entry.source_path,
        "look_at": " ".join(subjects),
        "category": entry.category,
        "size_m": "" if size is None else f"{size:.4g}",
        "up": guesses["up_axis"].value if "up_axis" in guesses else "",
        "mass_kg": "" if entry.summary is None else f"{entry.summary.mass:.4g}",
        "reason": " | ".join(reasons.get(subject, entry.message) for subject in subjects) or entry.message,
    }
    plain = {
        name: " ".join("".join(c if c.isprintable() else " " for c in value).split()) for name, value in cells.items()
    }
    return {name: f"'{value}" if value.startswith(("=", "+", "-", "@")) else value for name, value in plain.items()}


def _read(library: Library) -> dict[str, ReviewRow]:
    path = library.root / NAME
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        return {}
    except (OSError, UnicodeDecodeError) as error:
        raise OutputError(str(path), f"cannot be read: {error}") from error
    try:
        lines = list(csv.DictReader(io.StringIO(text), strict=True))
    except csv.Error as error:
        raise OutputError(str(path), f"is no CSV: {error}") from error
    rows: dict[str, ReviewRow] = {}
    records = registry.load()
    for number, line in enumerate(lines, 2):
        cells = {name: (value or "").strip() for name, value in line.items() if isinstance(name, str)}
        digest = cells.get("sha256", "")
        if not digest:
            raise OutputError(str(path), f"row {number}: there is no sha256; keep that column")
        rows[digest] = ReviewRow(cells, _override_of(cells, f"{path} row {number}", records))
    return rows


def _override_of(cells: Mapping[str, str], place: str, records: registry.Registry) -> UserOverride:
    stated: dict[str, Any] = {
        name: cells[f"set_{name}"] for name in UserOverride.model_fields if cells.get(f"set_{name}")
    }
    try:
        if "category" in stated:
            records.category(stated["category"])
        for name in ("turn_deg", "size_m", "mass_kg"):
            if name in stated:
                stated[name] = float(stated[name].replace(",", "."))
        return UserOverride.model_validate(stated)
    except (UnknownId, ValueError, ValidationError) as error:
        message = error.errors()[0]["msg"] if isinstance(error, ValidationError) else str(error)
        raise OutputError(place, f"cannot be understood: {message}") from error
