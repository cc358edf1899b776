"""One row of the table of entries: its columns, and the row of an entry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

from casa_assets.model.issue import Decision, Tally
from casa_assets.model.record import Vec3
from casa_assets.pipeline.reports.entry import Entry

Value = str | float | int | None
# Columns with their types in Arrow; a number is null where an entry has none.
COLUMNS: dict[str, str] = {
    "id": "string",
    "status": "string",
    "category": "string",
    "code": "string",
    "message": "string",
    "path": "string",
    "size_x_m": "float64",
    "size_y_m": "float64",
    "size_z_m": "float64",
    "mass_kg": "float64",
    "colliders": "int64",
    "hull_vertices": "int64",
    "faces": "int64",
    "warnings": "int64",
    "checks": "int64",
    "checks_passed": "int64",
    "checks_not_run": "int64",
    "checks_not_applicable": "int64",
    "source": "string",
    "source_path": "string",
    "source_sha256": "string",
    "title": "string",
    "author": "string",
    "licence": "string",
    "split": "string",
    "digest": "string",
    "producer": "string",
    "cache_key": "string",
    "portion": "string",
    "uri": "string",
    "prompt": "string",
    "generator": "string",
    "advice": "string",
    "decide": "string",
    "colors": "string",
}


@dataclass(frozen=True, slots=True)
class RowNumbers:
    """Numbers of an asset: extents in metres, mass in kg, counts; as `library.Summary` has them."""

    extents: Vec3
    mass: float
    colliders: int
    hull_vertices: int
    faces: int


@dataclass(frozen=True)
class TableRow:
    """One row, as reports and searches read it; names and meanings are those of COLUMNS and of `Entry`.

    Attributes:
        library: folder of the library, relative to that of the table; empty for a row that is in no table.
    """

    id: str
    status: str
    category: str
    code: str
    message: str
    path: str
    size_x_m: float | None
    size_y_m: float | None
    size_z_m: float | None
    mass_kg: float | None
    colliders: int | None
    hull_vertices: int | None
    faces: int | None
    warnings: int
    checks_applying: int
    checks_passed: int
    checks_not_run: int
    checks_not_applicable: int
    source: str
    source_path: str
    source_sha256: str
    title: str
    author: str
    licence: str
    split: str
    digest: str
    producer: str
    cache_key: str
    portion: str
    uri: str
    prompt: str
    generator: str
    advice_codes: str
    decide: str
    color_shares: str
    library: str = ""

    @property
    def accepted(self) -> bool:
        """There is an asset, be it in review."""
        return self.status != Decision.REJECTED.value

    @property
    def decision(self) -> Decision:
        """Accepted, in review, or rejected."""
        return Decision(self.status)

    @property
    def to_decide(self) -> tuple[str, ...]:
        """What a person has to decide about an asset, such as `scale`."""
        return tuple(self.decide.split())

    @property
    def advice(self) -> tuple[str, ...]:
        """Codes of the warnings, each once, sorted."""
        return tuple(self.advice_codes.split())

    @property
    def warning_count(self) -> int:
        """How many warnings there are."""
        return self.warnings

    @property
    def checks(self) -> Tally:
        """How many checks there are by status; what failed and let the asset pass was a warning."""
        failed = self.checks_applying - self.checks_passed - self.checks_not_run
        return Tally(self.checks_passed, failed, self.checks_not_run, self.checks_not_applicable)

    @cached_property
    def summary(self) -> RowNumbers | None:
        """Numbers of an asset; None for a rejected input."""
        if self.size_x_m is None or self.size_y_m is None or self.size_z_m is None:
            return None
        extents = self.size_x_m, self.size_y_m, self.size_z_m
        return RowNumbers(extents, self.mass_kg or 0.0, self.colliders or 0, self.hull_vertices or 0, self.faces or 0)

    @property
    def colors(self) -> tuple[tuple[str, float], ...]:
        """Words for colours, each with its share of the surface."""
        pairs = (word.partition("=") for word in self.color_shares.split())
        return tuple((name, float(share)) for name, _, share in pairs)


# Fields of TableRow in the order of COLUMNS, then `library`.
FIELDS = tuple(field.name for field in fields(TableRow))
assert len(FIELDS) == len(COLUMNS) + 1


def values_of(entry: Entry) -> tuple[Value, ...]:
    """The values of COLUMNS of an entry."""
    summary, checks = entry.summary, entry.checks
    size: Sequence[float | None] = summary.extents if summary else (None, None, None)
    return (
        entry.id,
        entry.decision.value,
        entry.category,
        entry.code,
        entry.message,
        entry.path,
        *size,
        summary.mass if summary else None,
        summary.colliders if summary else None,
        summary.hull_vertices if summary else None,
        summary.faces if summary else None,
        entry.warning_count,
        checks.applying,
        checks.passed,
        checks.not_run,
        checks.not_applicable,
        entry.source,
        entry.source_path,
        entry.sha256,
        entry.title,
        entry.author,
        entry.licence,
        entry.split,
        entry.digest,
        entry.producer,
        entry.cache_key,
        entry.portion,
        entry.uri,
        entry.prompt,
        entry.generator,
        " ".join(entry.advice),
        " ".join(entry.to_decide),
        " ".join(f"{name}={share}" for name, share in entry.colors),
    )


def row_of(entry: Entry) -> TableRow:
    """The row of an entry, which is in no table."""
    values: tuple[Any, ...] = values_of(entry)
    return TableRow(*values)
