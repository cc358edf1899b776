"""The index: one SQLite table of all entries, always rebuildable from the asset.json and reject.json files."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterable
from contextlib import closing, suppress
from itertools import pairwise
from pathlib import Path

from casa_assets.errors import OutputError
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.optional_packages import require
from casa_assets.pipeline.reports.entry import Entry, entries

NAME = "index.sqlite"
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
}
ARROW_TYPES = {"TEXT": "string", "REAL": "float64", "INTEGER": "int64"}


def rebuild(library: disk.Library, found: Iterable[Entry] | None = None) -> int:
    """Write the index anew, in the order of ids, and put it in place by one rename.

    Args:
        found: the entries; where they are not given, every one is read from its own file.
    Returns:
        Number of rows. Raises OutputError where an entry is damaged.
    """
    target = library.root / NAME
    fresh = library.private / f"{NAME}.{os.getpid()}"
    for leftover in library.private.glob(f"{NAME}.*"):
        leftover.unlink()
    rows = [_row(e) for e in sorted(entries(library) if found is None else found, key=lambda e: e.id)]
    try:
        with closing(sqlite3.connect(fresh)) as database:
            database.execute("PRAGMA journal_mode=WAL")
            columns = ", ".join(f"{name} {kind}" for name, kind in COLUMNS.items())
            database.execute(f"CREATE TABLE entries ({columns}) WITHOUT ROWID")
            database.executemany(f"INSERT INTO entries VALUES ({', '.join('?' * len(COLUMNS))})", rows)  # noqa: S608  marks only
            database.execute("CREATE INDEX by_category ON entries (category, status)")
            database.commit()
            database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    except sqlite3.IntegrityError as error:
        twice = next(a[0] for a, b in pairwise(rows) if a[0] == b[0])
        raise OutputError(str(library.root), f"two entries are called {twice}; remove one of them") from error
    except sqlite3.OperationalError as error:
        raise OutputError(str(target), f"cannot be written: {error}") from error
    for side in ("-wal", "-shm"):
        target.with_name(NAME + side).unlink(missing_ok=True)
    fresh.replace(target)
    return len(rows)


def require_parquet() -> None:
    """Check that Parquet can be written. Raises CasaError, which names the extra to install."""
    require("pyarrow", "parquet", "Parquet")


def export_parquet(library: disk.Library, target: Path) -> int:
    """Write the rows of the index as one Parquet file; returns their number.

    Raises:
        CasaError: pyarrow is not installed.
        OutputError: an entry is damaged, or the file cannot be written.
    """
    require_parquet()
    import pyarrow
    import pyarrow.parquet

    rows = [_row(e) for e in sorted(entries(library), key=lambda e: e.id)]
    types = {name: pyarrow.type_for_alias(ARROW_TYPES[kind.split()[0]]) for name, kind in COLUMNS.items()}
    columns = {name: [row[i] for row in rows] for i, name in enumerate(COLUMNS)}
    fresh = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        pyarrow.parquet.write_table(pyarrow.table(columns, schema=pyarrow.schema(list(types.items()))), fresh)
        fresh.replace(target)
    except OSError as error:
        with suppress(OSError):
            fresh.unlink()
        raise OutputError(str(target), f"cannot be written: {error}") from error
    return len(rows)


def _row(entry: Entry) -> tuple[str | float | int | None, ...]:
    size = entry.summary.extents if entry.summary else (None, None, None)
    return (
        entry.id,
        entry.decision.value,
        entry.category,
        entry.code,
        entry.message,
        entry.path,
        *size,
        entry.summary.mass if entry.summary else None,
        entry.summary.colliders if entry.summary else None,
        entry.summary.hull_vertices if entry.summary else None,
        entry.summary.faces if entry.summary else None,
        len(entry.warnings),
        entry.checks.applying,
        entry.checks.passed,
        entry.checks.not_run,
        entry.checks.not_applicable,
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
    )
