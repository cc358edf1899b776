"""The index: one SQLite table of all entries, always rebuildable from the asset.json and reject.json files."""

from __future__ import annotations

import os
import sqlite3
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from casa_assets.pipeline import library as disk
from casa_assets.pipeline.entry import Entry, entries

NAME = "index.sqlite"
COLUMNS: dict[str, str] = {
    "id": "TEXT PRIMARY KEY",
    "status": "TEXT NOT NULL",
    "category": "TEXT NOT NULL",
    "code": "TEXT NOT NULL",
    "says": "TEXT NOT NULL",
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
    "source": "TEXT NOT NULL",
    "source_path": "TEXT NOT NULL",
    "source_sha256": "TEXT NOT NULL",
    "title": "TEXT NOT NULL",
    "author": "TEXT NOT NULL",
    "licence": "TEXT NOT NULL",
    "digest": "TEXT NOT NULL",
    "recipe": "TEXT NOT NULL",
}
TYPES = {"TEXT": pa.string(), "REAL": pa.float64(), "INTEGER": pa.int64()}


def rebuild(library: disk.Library) -> int:
    """Write the index anew from the entries, in the order of their ids, and put it in place by one rename.

    Returns:
        Number of rows. Raises OutputError where an entry is damaged.
    """
    target = library.root / NAME
    fresh = library.private / f"{NAME}.{os.getpid()}"
    for left in library.private.glob(f"{NAME}.*"):
        left.unlink()
    rows = [_row(e) for e in sorted(entries(library), key=lambda e: e.id)]
    base = sqlite3.connect(fresh)
    try:
        base.execute("PRAGMA journal_mode=WAL")
        columns = ", ".join(f"{name} {kind}" for name, kind in COLUMNS.items())
        base.execute(f"CREATE TABLE entries ({columns}) WITHOUT ROWID")
        base.executemany(f"INSERT INTO entries VALUES ({', '.join('?' * len(COLUMNS))})", rows)
        base.execute("CREATE INDEX by_category ON entries (category, status)")
        base.commit()
        base.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    finally:
        base.close()
    for side in ("-wal", "-shm"):
        target.with_name(NAME + side).unlink(missing_ok=True)
    fresh.replace(target)
    return len(rows)


def export_parquet(library: disk.Library, target: Path) -> int:
    """Write the rows of the index as one Parquet file; returns their number."""
    rows = [_row(e) for e in sorted(entries(library), key=lambda e: e.id)]
    schema = pa.schema([(name, TYPES[kind.split()[0]]) for name, kind in COLUMNS.items()])
    columns = {name: [row[i] for row in rows] for i, name in enumerate(COLUMNS)}
    fresh = target.with_name(f".{target.name}.{os.getpid()}")
    pq.write_table(pa.table(columns, schema=schema), fresh)
    fresh.replace(target)
    return len(rows)


def _row(entry: Entry) -> tuple[str | float | int | None, ...]:
    size = entry.summary.extents if entry.summary else (None, None, None)
    return (
        entry.id,
        "accepted" if entry.accepted else "rejected",
        entry.category,
        entry.code,
        entry.says,
        entry.path,
        *size,
        entry.summary.mass if entry.summary else None,
        entry.summary.colliders if entry.summary else None,
        entry.summary.hull_vertices if entry.summary else None,
        entry.summary.faces if entry.summary else None,
        len(entry.warnings),
        len(entry.results),
        entry.source,
        entry.source_path,
        entry.sha256,
        entry.title,
        entry.author,
        entry.licence,
        entry.digest,
        entry.recipe,
    )
