"""The index: one SQLite table of all entries, always rebuildable from the asset.json and reject.json files."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing, suppress
from pathlib import Path

from casa_assets.errors import OutputError
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_table import stream_entries
from casa_assets.pipeline.reports.entry import Entry
from casa_assets.pipeline.tables import parquet
from casa_assets.pipeline.tables.conditions import Condition, to_sql
from casa_assets.pipeline.tables.row import COLUMNS, TableRow, values_of

NAME = "index.sqlite"


def rebuild(library: disk.Library, found: Iterable[Entry] | None = None) -> int:
    """Write the index anew, in the order of ids, and put it in place by one rename.

    Args:
        found: the entries; where they are not given, those that the library has now.
    Returns:
        Number of rows. Raises OutputError where an entry is damaged.
    """
    target = library.root / NAME
    fresh = library.private / f"{NAME}.{os.getpid()}"
    for leftover in library.private.glob(f"{NAME}.*"):
        leftover.unlink()
    try:
        with closing(sqlite3.connect(fresh)) as database:
            database.execute("PRAGMA journal_mode=WAL")
            count = _fill(database, library, stream_entries(library) if found is None else found)
            database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    except sqlite3.OperationalError as error:
        raise OutputError(str(target), f"cannot be written: {error}") from error
    for side in ("-wal", "-shm"):
        target.with_name(NAME + side).unlink(missing_ok=True)
    fresh.replace(target)
    return count


def rows(library: disk.Library, conditions: Sequence[Condition] = ()) -> Iterator[TableRow]:
    """The rows of a library that meet all conditions, by id.

    They are those of the index; where an entry has come, gone or been replaced since it was written, or another version
    wrote it, those of one that is made in memory. A file that was edited in its place is no such change.

    Raises:
        OutputError: an entry is damaged.
    """
    words, values = to_sql(conditions)
    with closing(_current(library)) as database:
        query = f"SELECT * FROM entries WHERE {words} ORDER BY id"  # noqa: S608  words of ours, values are bound
        for row in database.execute(query, values):
            yield TableRow(*row)


def export_parquet(library: disk.Library, target: Path) -> int:
    """Write the rows of the index as one Parquet file; returns their number.

    Raises:
        CasaError: pyarrow is not installed.
        OutputError: an entry is damaged, or the file cannot be written.
    """
    with closing(_current(library)) as database:
        return parquet.write_file(database.execute("SELECT * FROM entries ORDER BY id"), target)


def _current(library: disk.Library) -> sqlite3.Connection:
    """The index of a library as it stands now."""
    path = (library.root / NAME).absolute()
    with suppress(sqlite3.Error, OSError):
        if path.stat().st_mtime_ns > max(library.shelf_times().values(), default=0):
            kept = sqlite3.connect(f"{path.as_uri()}?mode=ro", uri=True)
            if [row[1] for row in kept.execute("PRAGMA table_info(entries)")] == list(COLUMNS):
                return kept
            kept.close()
    database = sqlite3.connect(":memory:")
    _fill(database, library, stream_entries(library))
    return database


def _fill(database: sqlite3.Connection, library: disk.Library, found: Iterable[Entry]) -> int:
    """Write the rows of entries into an empty database, in the order of their ids; returns their number."""
    columns = ", ".join(f"{name} {kind}" for name, kind in COLUMNS.items())
    unsorted = columns.replace(" PRIMARY KEY", "")
    marks = ", ".join("?" * len(COLUMNS))
    # Sorted by SQLite, which needs little memory for it however many there are.
    database.execute(f"CREATE TEMP TABLE unsorted ({unsorted})")
    database.executemany(f"INSERT INTO unsorted VALUES ({marks})", map(values_of, found))  # noqa: S608  marks only
    twice = database.execute("SELECT id FROM unsorted GROUP BY id HAVING count(*) > 1 ORDER BY id LIMIT 1").fetchone()
    if twice is not None:
        raise OutputError(str(library.root), f"two entries are called {twice[0]}; remove one of them")
    database.execute(f"CREATE TABLE entries ({columns}) WITHOUT ROWID")
    count = database.execute("INSERT INTO entries SELECT * FROM unsorted ORDER BY id").rowcount
    database.execute("DROP TABLE unsorted")
    database.execute("CREATE INDEX by_category ON entries (category, status)")
    database.commit()
    return count
