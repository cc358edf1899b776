"""The entries of a library in a table beside it, so that certificates and pictures are opened only when they are new.

What the table keeps of an entry is found again by the state of its file on disk (time, size, inode) and of the folders
in it, whose times tell that a file has come or gone. It lies in the cache, and deleting it costs time and nothing else.
In a library that may only be read it is built in memory.
"""

from __future__ import annotations

import json
import os
import sqlite3
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter

from casa_assets.checks.library.duplicates import ShapePair
from casa_assets.errors import OutputError
from casa_assets.model.asset.provenance import Guess
from casa_assets.model.asset.signature import ColorHistogram, ShapeDescriptor, Signature
from casa_assets.model.issue import CheckResult, Issue, Severity, Tally
from casa_assets.model.record import Record
from casa_assets.pipeline.cache.cache_key import digest_of, key_of
from casa_assets.pipeline.cache.store import Store
from casa_assets.pipeline.dedup.entries import AssetRow, read_row
from casa_assets.pipeline.dedup.pairs import ShapeIndex, measure_pair, nearby_pairs
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_files import PICTURE, thumbnail_of
from casa_assets.pipeline.reports.entry import Entry, entry_at, row_entries

NAME = "entries.sqlite"
_SCHEMA = """
CREATE TABLE IF NOT EXISTS made_by (key TEXT PRIMARY KEY);
CREATE TABLE IF NOT EXISTS entries (folder TEXT PRIMARY KEY, state TEXT, entry TEXT, row TEXT, results BLOB);
CREATE TABLE IF NOT EXISTS thumbnails (folder TEXT PRIMARY KEY, state TEXT, webp BLOB);
CREATE TABLE IF NOT EXISTS compared (digest TEXT PRIMARY KEY);
CREATE TABLE IF NOT EXISTS reports (state TEXT PRIMARY KEY);
CREATE TABLE IF NOT EXISTS pairs (
    first TEXT, second TEXT, most REAL, every REAL, size REAL, colors REAL, PRIMARY KEY (first, second)
);
"""
_entries: TypeAdapter[Entry] = TypeAdapter(Entry)
_rows: TypeAdapter[AssetRow] = TypeAdapter(AssetRow)
_SEVERITIES = {severity.value: severity for severity in Severity}
R = TypeVar("R", bound=Record)
_results: TypeAdapter[tuple[CheckResult, ...]] = TypeAdapter(tuple[CheckResult, ...])


@dataclass(frozen=True)
class _Kept:
    state: str
    entry: str
    row: str
    results: bytes


class EntryTable:
    """The entries of one library as they stand now.

    Args:
        library: whose entries. force: forget what is kept and open every certificate.
        skip_damaged: leave damaged entries out: a run may be about to make them anew.
        read_only: write nothing: what is kept is read, and what is new is not added to it.
    Raises:
        OutputError: an entry is damaged.
    """

    def __init__(
        self,
        library: disk.Library,
        force: bool = False,
        skip_damaged: bool = False,
        read_only: bool = False,
    ) -> None:
        self._library, self._skip_damaged = library, skip_damaged
        self._read_only = read_only
        self._is_tidy = False  # thumbnails of entries that are gone were removed
        self._path = (library.cache / NAME).absolute()
        # Looked at before the entries: what changes while they are read is told as a change.
        self._shelf_times = library.shelf_times()
        if force:
            with suppress(OSError):
                self._path.unlink(missing_ok=True)
        with closing(self._open()) as database:
            before = {folder: _Kept(*rest) for folder, *rest in database.execute("SELECT * FROM entries")}
            self._entries: list[Entry] = []
            self._row_makers: list[Callable[[], AssetRow]] = []
            self._states: dict[str, str] = {}
            fresh = [(name, *vars(kept).values()) for name, kept in self._read(before)]
            removed = before.keys() - {e.path for e in self._entries}
            self._entries += row_entries(library)
            with suppress(sqlite3.OperationalError), database:
                database.executemany("INSERT OR REPLACE INTO entries VALUES (?, ?, ?, ?, ?)", fresh)
                database.executemany("DELETE FROM entries WHERE folder = ?", [(name,) for name in removed])

    @property
    def root(self) -> Path:
        """Folder of the library."""
        return self._library.root

    @property
    def entries(self) -> Sequence[Entry]:
        """All entries, accepted first; without the results of their checks, see `with_results`."""
        return self._entries

    def with_results(self, wanted: Iterable[Entry]) -> Iterator[Entry]:
        """Some of the entries with the results of their checks, which take half a millisecond each and much memory."""
        with closing(self._open()) as database:
            for entry in wanted:
                if entry.path not in self._states:  # rows of a file that was refused; nothing was checked
                    yield entry
                    continue
                query = "SELECT results FROM entries WHERE folder = ? AND state = ?"
                kept = database.execute(query, (entry.path, self._states[entry.path])).fetchone()
                if kept is None:  # the table could not be written
                    yield entry_at(self._library.root / entry.path, self._library.root)
                    continue
                yield replace(entry, results=_results.validate_json(zlib.decompress(kept[0])))

    @cached_property
    def rows(self) -> Sequence[AssetRow]:
        """Every accepted asset, sorted by category and id."""
        return [make() for make in self._row_makers]

    def is_current(self) -> bool:
        """True if no entry has come, gone or been replaced since the table was read."""
        return self._library.shelf_times() == self._shelf_times

    def has_reports(self, made_by: str, files: Iterable[str]) -> bool:
        """True if `keep_reports` was told of these entries and files, and they are as they were then."""
        with closing(self._open()) as database:
            return database.execute("SELECT state FROM reports").fetchall() == [(self._reports_state(made_by, files),)]

    def keep_reports(self, made_by: str, files: Iterable[str]) -> None:
        """Remember that what is derived from the entries has been written.

        Args:
            made_by: key of what wrote it. files: names in the library of all that was written and read for it.
        """
        with closing(self._open()) as database, suppress(sqlite3.OperationalError), database:
            database.execute("DELETE FROM reports")
            database.execute("INSERT INTO reports VALUES (?)", (self._reports_state(made_by, files),))

    def _reports_state(self, made_by: str, files: Iterable[str]) -> str:
        paths = {name: self._library.root / name for name in files}
        written = {name: _state(path) if os.path.lexists(path) else "" for name, path in paths.items()}
        return digest_of(made_by, self._states, written)

    def twins(self, is_copy: Callable[[ShapePair], bool]) -> Set[str] | None:
        """Digests of assets that are copies of another one; None where some were never compared with the others."""
        with closing(self._open()) as database:
            compared = {digest for (digest,) in database.execute("SELECT digest FROM compared")}
            pairs = database.execute("SELECT * FROM pairs").fetchall()
        own = {entry.digest for entry in self._entries if entry.accepted}
        if not own <= compared:
            return None
        near = [
            ShapePair(one, other, p95, p995, size, colors, True)
            for one, other, p95, p995, size, colors in pairs
            if {one, other} <= own
        ]
        return {digest for pair in near if is_copy(pair) for digest in (pair.one, pair.other)}

    def alike(self, store: Store) -> list[ShapePair]:
        """Every pair of assets whose forms are near each other, in the order of the rows; only new ones are compared.

        Two that came out of numbers are no pair: one shape in several colours is meant, and there are many.

        Args:
            store: keeps how surfaces lie over each other, by the contents of both.
        """
        signed = [asset for asset in self.rows if asset.signature is not None]
        digests = {asset.digest for asset in self.rows}
        place = {asset.digest: i for i, asset in enumerate(signed)}
        with closing(self._open()) as database:
            compared = {digest for (digest,) in database.execute("SELECT digest FROM compared")}
            known = [pair for pair in database.execute("SELECT * FROM pairs") if pair[0] in place and pair[1] in place]
            new = [i for i, asset in enumerate(signed) if asset.digest not in compared]
            found = [_pair(signed[i], signed[j], store) for i, j in _new_nearby_pairs(signed, new)]
            with suppress(sqlite3.OperationalError), database:
                database.executemany("INSERT OR REPLACE INTO pairs VALUES (?, ?, ?, ?, ?, ?)", found)
                database.executemany(
                    "INSERT OR REPLACE INTO compared VALUES (?)", [(digest,) for digest in sorted(digests)]
                )
                removed = [(digest,) for digest in compared - digests]
                database.executemany("DELETE FROM compared WHERE digest = ?", removed)
                database.executemany("DELETE FROM pairs WHERE first = ?1 OR second = ?1", removed)
        pairs = sorted((*known, *found), key=lambda pair: (place[pair[0]], place[pair[1]]))
        return [_alike(signed[place[first]], signed[place[second]], *rest) for first, second, *rest in pairs]

    def thumbnails(self, wanted: Iterable[Entry]) -> dict[str, bytes]:
        """A small picture (WebP) of each of these entries that has one, by `Entry.path`; only new pictures are opened.

        Raises:
            OutputError: a picture is damaged, or is a link that leads out of its entry.
        """
        paths = [e.path for e in wanted if os.path.lexists(self._library.root / e.path / PICTURE)]
        query = "SELECT state, CAST(webp AS BLOB) FROM thumbnails WHERE folder = ?"
        found, fresh = {}, []
        with closing(self._open()) as database:
            for path in paths:
                state, kept = _state(self._library.root / path / PICTURE), database.execute(query, (path,)).fetchone()
                if kept is not None and kept[0] == state:
                    found[path] = kept[1]
                else:
                    found[path] = thumbnail_of(self._library.root / path)
                    fresh.append((path, state, found[path]))
            with suppress(sqlite3.OperationalError), database:
                database.executemany("INSERT OR REPLACE INTO thumbnails VALUES (?, ?, ?)", fresh)
                if not self._is_tidy:
                    database.execute("DELETE FROM thumbnails WHERE folder NOT IN (SELECT folder FROM entries)")
                    self._is_tidy = True
        return found

    def _read(self, before: dict[str, _Kept]) -> Iterator[tuple[str, _Kept]]:
        """Fill the lists; yields what is to be written down: of entries that are new or have changed."""
        for folder, name, file in _folders(self._library):
            is_accepted = file == disk.CERTIFICATE
            kept = before.get(name)
            if kept is not None and kept.state == (state := _state_again(folder, file, kept.state)):
                with suppress(ValueError, TypeError, KeyError, zlib.error):
                    entry = _entry_of(json.loads(kept.entry))
                    if entry.path == name and bool(kept.row) is is_accepted:
                        self._add(entry, name, state, partial(_row_at, folder, kept.row) if is_accepted else None)
                        continue
            state = _state_of_entry(folder, file, _folders_in(folder))
            try:
                entry = entry_at(folder, self._library.root)
                row = read_row(folder) if is_accepted else None
            except OutputError:
                if self._skip_damaged:
                    continue
                raise
            bare = replace(entry, results=())
            make = (lambda made=row: made) if row is not None else None
            self._add(bare, name, state, make)
            results = zlib.compress(_results.dump_json(entry.results))
            row_json = _rows.dump_json(row).decode() if row else ""
            yield name, _Kept(state, _entries.dump_json(bare).decode(), row_json, results)

    def _add(self, entry: Entry, name: str, state: str, make_row: Callable[[], AssetRow] | None) -> None:
        self._entries.append(entry)
        self._states[name] = state
        if make_row is not None:
            self._row_makers.append(make_row)

    def _open(self) -> sqlite3.Connection:
        if self._read_only:
            memory = sqlite3.connect(":memory:")
            with suppress(sqlite3.Error), closing(sqlite3.connect(f"{self._path.as_uri()}?mode=ro", uri=True)) as kept:
                kept.backup(memory)
            return _ready(memory)
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            return _ready(sqlite3.connect(self._path))
        except (OSError, sqlite3.OperationalError):
            return _ready(sqlite3.connect(":memory:"))
        except sqlite3.DatabaseError:  # no table at all: what a disk fault, or a stranger, has left there
            self._path.unlink(missing_ok=True)
            return _ready(sqlite3.connect(self._path))


def _ready(database: sqlite3.Connection) -> sqlite3.Connection:
    """The table, empty where other code has made it."""
    try:
        with database:
            database.executescript(_SCHEMA)
            if database.execute("SELECT key FROM made_by").fetchall() != [(_made_by(),)]:
                tables = ("made_by", "entries", "thumbnails", "compared", "pairs", "reports")
                database.executescript("".join(f"DROP TABLE IF EXISTS {name};" for name in tables) + _SCHEMA)
                database.execute("INSERT INTO made_by VALUES (?)", (_made_by(),))
    except sqlite3.DatabaseError:
        database.close()
        raise
    return database


def _made_by() -> str:
    """Key of the code that decides what is kept."""
    return key_of(__name__)


def _entry_of(data: dict[str, Any]) -> Entry:
    """An entry that `_entries` wrote. It was checked before it was written: to check it again takes ten times as long.

    Raises:
        KeyError, TypeError: this is no such entry.
    """
    if (summary := data["summary"]) is not None:
        data["summary"] = _unchecked(disk.Summary, {**summary, "extents": tuple(summary["extents"])})
    for issue in data["warnings"]:
        issue["severity"] = _SEVERITIES[issue["severity"]]
    data["warnings"] = tuple([_unchecked(Issue, issue) for issue in data["warnings"]])
    data["guesses"] = tuple([_unchecked(Guess, guess) for guess in data["guesses"]])
    data["results"] = ()
    data["checks"] = Tally(**data["checks"])
    return Entry(**data)


def _row_of(text: str, folder: Path) -> AssetRow:
    """A row that `_rows` wrote, likewise."""
    data = json.loads(text)
    signature = data["signature"]
    if signature is not None:
        shape, color = signature["shape"], signature["color"]
        shape = {name: tuple(value) if isinstance(value, list) else value for name, value in shape.items()}
        color = {**color, "tones": tuple(color["tones"]), "names": tuple(map(tuple, color["names"]))}
        data["signature"] = _unchecked(
            Signature, {"shape": _unchecked(ShapeDescriptor, shape), "color": _unchecked(ColorHistogram, color)}
        )
    return AssetRow(**{**data, "folder": folder, "extents": tuple(data["extents"])})


def _row_at(folder: Path, text: str) -> AssetRow:
    """The row of an asset as the table has it, or as its file says where that is no row."""
    try:
        return _row_of(text, folder)
    except (ValueError, KeyError, TypeError):
        return read_row(folder)


def _unchecked(kind: type[R], values: dict[str, Any]) -> R:
    """A record of values that were checked before; `model_construct` does the same in five times the time."""
    made = kind.__new__(kind)
    object.__setattr__(made, "__dict__", values)
    object.__setattr__(made, "__pydantic_fields_set__", set(values))
    object.__setattr__(made, "__pydantic_extra__", None)
    object.__setattr__(made, "__pydantic_private__", None)
    return made


def _folders(library: disk.Library) -> Iterator[tuple[Path, str, str]]:
    """Folder, its path relative to the library, and the name of the file that says what it is; accepted first."""
    for folders, file in ((library.accepted(), disk.CERTIFICATE), (library.refused(), disk.REFUSAL)):
        for folder in folders:
            yield folder, f"{folder.parent.name}/{folder.name}", file


def _folders_in(folder: Path) -> list[str]:
    """Relative paths of a folder itself and of all folders below it, sorted."""
    return sorted(os.path.relpath(place, folder) for place, _, _ in os.walk(folder))


def _state_of_entry(folder: Path, file: str, folders: Iterable[str]) -> str:
    """State of an entry: of the file that says what it is, and of some folders in it, each with its path."""
    base = str(folder)  # Path would take longer than all the rest
    states = [f"{os.lstat(f'{base}/{name}').st_mtime_ns} {name}" for name in folders]
    return "\n".join((_state(f"{base}/{file}"), *states))


def _state_again(folder: Path, file: str, before: str | None) -> str:
    """The same for the folders that a state of before names; empty where one of them is gone."""
    names = [line.partition(" ")[2] for line in (before or "").split("\n")[1:]]
    try:
        return _state_of_entry(folder, file, names)
    except OSError:
        return ""


def _state(path: Path | str) -> str:
    """State of a file that changes whenever it is written anew."""
    found = os.lstat(path)
    return f"{found.st_mtime_ns} {found.st_ctime_ns} {found.st_size} {found.st_ino}"


def _new_nearby_pairs(signed: Sequence[AssetRow], new: Sequence[int]) -> list[tuple[int, int]]:
    """Pairs of places of assets of near form of which at least one is new, and at least one not out of numbers."""
    forms = [asset.signature.shape for asset in signed if asset.signature is not None]
    fresh, meshes = set(new), {i for i, asset in enumerate(signed) if not asset.from_numbers}
    # Every pair has one of either, so the fewer are looked up.
    few = min(fresh, meshes, key=len)
    if 2 * len(few) > len(signed):
        near = nearby_pairs(forms)
    else:
        table = ShapeIndex(forms)
        near = sorted({(min(i, j), max(i, j)) for i in few for j in table.near(forms[i]) if j != i})
    return [pair for pair in near if not fresh.isdisjoint(pair) and not meshes.isdisjoint(pair)]


def _pair(first: AssetRow, second: AssetRow, store: Store) -> tuple[str, str, float, float, float, float]:
    found = measure_pair(first, second, store)
    return first.digest, second.digest, found.p95, found.p995, found.size, found.colors


def _alike(first: AssetRow, second: AssetRow, p95: float, p995: float, size: float, colors: float) -> ShapePair:
    return ShapePair(first.id, second.id, p95, p995, size, colors, first.category == second.category)
