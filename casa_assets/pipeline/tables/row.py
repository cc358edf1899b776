"""One row of the table of entries: its columns, and the row of an entry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property

from casa_assets.model.record import Vec3
from casa_assets.pipeline.reports.entry import Entry

Value = str | float | int | None
# Columns with their types in SQLite. Columns without NOT NULL are NULL where an entry has no such number.
COLUMNS: dict[str, str] = {
    "id": "TEXT PRIMARY KEY",
    "status": "TEXT NOT NULL",
    "category": "TEXT NOT NULL",
    "code": "TEXT NOT NULL",
    "message": "TEXT NOT NULL",
    "path": "TEXT NOT NULL",
    "size_x_m": "REAL",
    "size_y_m": "REAL",
    "size_z_m": "REAL",
    "mass_kg": "REAL",
    "colliders": "INTEGER",
    "hull_vertices": "INTEGER",
    "faces": "INTEGER",
    "warnings": "INTEGER",
    "checks": "INTEGER",
    "checks_passed": "INTEGER",
    "checks_not_run": "INTEGER",
    "checks_not_applicable": "INTEGER",
    "source": "TEXT NOT NULL",
    "source_path": "TEXT NOT NULL",
    "source_sha256": "TEXT NOT NULL",
    "title": "TEXT NOT NULL",
    "author": "TEXT NOT NULL",
    "licence": "TEXT NOT NULL",
    "split": "TEXT NOT NULL",
    "digest": "TEXT NOT NULL",
    "producer": "TEXT NOT NULL",
    "cache_key": "TEXT NOT NULL",
    "portion": "TEXT NOT NULL",
    "uri": "TEXT NOT NULL",
    "prompt": "TEXT NOT NULL",
    "generator": "TEXT NOT NULL",
    "advice": "TEXT NOT NULL",
    "decide": "TEXT NOT NULL",
    "colors": "TEXT NOT NULL",
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
    """One row, as searches read it; names and meanings are those of COLUMNS and of `Entry`.

    Attributes:
        library: folder of the library, relative to that of the table; empty where the table is of one library.
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
