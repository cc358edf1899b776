"""A table of a library's entries, so that certificates and pictures are opened only when they are new.

The data kept of an entry are found by the state of its file on disk (time, size, inode) and of the folders in it, whose
times change if a file is added or removed. The table is in the cache; deleting it costs time and nothing else. For a
read-only library it is built in memory.
"""

from __future__ import annotations

import hashlib
import json
import os
import sqlite3
import sys
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from contextlib import closing, suppress
from dataclasses import replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter

from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.cache.store import Store
from casa_assets.checks.library import ShapePair
from casa_assets.errors import OutputError
from casa_assets.library.entry import Entry, entry_at, entry_of, row_entries
from casa_assets.library.entry_files import CERTIFICATE, PICTURE, REFUSAL, Summary, read_manifest, thumbnail_of
from casa_assets.library.library import Library
from casa_assets.library.pairs import AssetRow, ShapeIndex, measure_pair, nearby_pairs, read_row, row_of
from casa_assets.model.asset.asset import ColorHistogram, Guess, ShapeDescriptor, Signature
from casa_assets.model.issue import CheckResult, Issue, Severity, Tally
from casa_assets.model.record import Record

NAME = "entries.sqlite"
MOST_UNWRITTEN = 1000  # entries that are held in memory before they are written to the table
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
# Fields of an entry that many have in common; in memory they are there once.
_REPEATED = ("category", "source", "author", "licence", "generator", "split", "producer", "cache_key", "portion")
_SEVERITIES = {severity.value: severity for severity in Severity}
R = TypeVar("R", bound=Record)
_results: TypeAdapter[tuple[CheckResult, ...]] = TypeAdapter(tuple[CheckResult, ...])


class EntryTable:
    """The entries of one library in their current state.

    Args:
        skip_damaged: leave damaged entries out: a run may be about to make them again.
        read_only: write nothing: kept data are read, and new data are not added to them.
    Raises:
        OutputError: an entry is damaged.
    """

    def __init__(self, library: Library, skip_damaged: bool = False, read_only: bool = False) -> None:
        self._library, self._read_only = library, read_only
        self._is_tidy = False  # thumbnails of entries that are gone were removed
        self._path = (library.cache / NAME).absolute()
        # Looked at before the entries: what changes while they are read is told as a change.
        self._shelf_times = library.shelf_times()
        self._entries: list[Entry] = []
        self._states: dict[str, str] = {}
        with closing(self._open()) as database:
            for entry, state in _read(library, database, skip_damaged):
                self._entries.append(entry)
                self._states[entry.path] = _short(state)
            removed = [one for one in database.execute("SELECT folder FROM entries") if one[0] not in self._states]
            self._entries += row_entries(library)
            with suppress(sqlite3.OperationalError), database:
                database.executemany("DELETE FROM entries WHERE folder = ?", removed)

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
                kept = self._kept(database, "results", entry)
                if kept is None:
                    yield entry_at(self._library.root / entry.path, self._library.root)
                    continue
                yield replace(entry, results=_results.validate_json(zlib.decompress(kept)))

    @cached_property
    def rows(self) -> Sequence[AssetRow]:
        """Every accepted asset, sorted by category and id."""
        found = []
        with closing(self._open()) as database:
            for entry in self._entries:
                folder = self._library.root / entry.path
                if not entry.accepted:
                    continue
                if (kept := self._kept(database, "row", entry)) is not None:
                    try:
                        found.append(_row_of(kept, folder))
                    except (ValueError, KeyError, TypeError):  # no row: its file says what it is
                        found.append(read_row(folder))
                elif (folder / CERTIFICATE).exists():  # else it has gone since
                    found.append(read_row(folder))
        return found

    def _kept(self, database: sqlite3.Connection, column: str, entry: Entry) -> Any:
        """Return a column of an entry in its state, or None if the row could not be written or was changed since."""
        query = f"SELECT state, {column} FROM entries WHERE folder = ?"  # noqa: S608  a name of ours
        kept = database.execute(query, (entry.path,)).fetchone()
        return kept[1] if kept is not None and _short(kept[0]) == self._states[entry.path] else None

    def is_current(self) -> bool:
        """True if no entry has come, gone or been replaced since the table was read."""
        return self._library.shelf_times() == self._shelf_times

    def has_reports(self, made_by: str, files: Iterable[str]) -> bool:
        """Return whether `keep_reports` was called for these entries and files, and they have not changed since."""
        with closing(self._open()) as database:
            return database.execute("SELECT state FROM reports").fetchall() == [(self._reports_state(made_by, files),)]

    def keep_reports(self, made_by: str, files: Iterable[str]) -> None:
        """Remember that what is derived from the entries has been written."""
        with closing(self._open()) as database, suppress(sqlite3.OperationalError), database:
            database.execute("DELETE FROM reports")
            database.execute("INSERT INTO reports VALUES (?)", (self._reports_state(made_by, files),))

    def _reports_state(self, made_by: str, files: Iterable[str]) -> str:
        paths = {name: self._library.root / name for name in files}
        written = {name: _state(path) if os.path.lexists(path) else "" for name, path in paths.items()}
        return digest_of(made_by, self._states, written)

    def twins(self, is_copy: Callable[[ShapePair], bool]) -> Set[str] | None:
        """Return digests of assets that are copies of another one; None if some were never compared with the others."""
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

    def _open(self) -> sqlite3.Connection:
        return _opened(self._path, self._read_only)


def stream_entries(library: Library, skip_damaged: bool = False, read_only: bool = False) -> Iterator[Entry]:
    """The entries of a library one after the other, accepted first, however many there are; none is kept in memory.

    Args and Raises: as of EntryTable.
    """
    with closing(_opened((library.cache / NAME).absolute(), read_only)) as database:
        for entry, _ in _read(library, database, skip_damaged):
            yield entry
    yield from row_entries(library)


def _read(library: Library, database: sqlite3.Connection, skip_damaged: bool = False) -> Iterator[tuple[Entry, str]]:
    """Every entry without the results of its checks, and its state; what is new is added to the table on the way."""
    fresh: list[tuple[str, str, str, str, bytes]] = []
    for folder, name, file in _folders(library):
        is_accepted = file == CERTIFICATE
        query = "SELECT state, entry, row <> '' FROM entries WHERE folder = ?"
        if (kept := database.execute(query, (name,)).fetchone()) is not None:
            state, text, has_row = kept
            if state == _state_again(folder, file, state) and bool(has_row) is is_accepted:
                with suppress(ValueError, TypeError, KeyError):
                    entry = _entry_of(json.loads(text))
                    if entry.path == name:
                        yield entry, state
                        continue
        inner = sorted(os.path.relpath(place, folder) for place, _, _ in os.walk(folder))
        state = _state_of_entry(folder, file, inner)
        try:
            manifest = read_manifest(folder) if is_accepted else None
            entry = entry_of(manifest, library.root) if manifest else entry_at(folder, library.root)
            row = _rows.dump_json(row_of(manifest)).decode() if manifest else ""
        except OutputError:
            if skip_damaged:
                continue
            raise
        bare = replace(entry, results=())
        results = zlib.compress(_results.dump_json(entry.results))
        fresh.append((name, state, _entries.dump_json(bare).decode(), row, results))
        if len(fresh) >= MOST_UNWRITTEN:
            _write(database, fresh)
            fresh.clear()
        yield bare, state
    _write(database, fresh)


def _write(database: sqlite3.Connection, fresh: Sequence[tuple[str, str, str, str, bytes]]) -> None:
    if not database.execute("PRAGMA database_list").fetchone()[2]:
        return  # in memory, where nobody would read it
    with suppress(sqlite3.OperationalError), database:
        database.executemany("INSERT OR REPLACE INTO entries VALUES (?, ?, ?, ?, ?)", fresh)


def _opened(path: Path, read_only: bool = False) -> sqlite3.Connection:
    """Open the table in a file, or one in memory if there is no usable file and none can be made."""
    if read_only:
        with suppress(sqlite3.Error):
            kept = sqlite3.connect(f"{path.as_uri()}?mode=ro", uri=True)
            if kept.execute("SELECT key FROM made_by").fetchall() == [(_made_by(),)]:
                return kept
            kept.close()
        return _ready(sqlite3.connect(":memory:"))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return _ready(sqlite3.connect(path))
    except (OSError, sqlite3.OperationalError):
        return _ready(sqlite3.connect(":memory:"))
    except sqlite3.DatabaseError:  # no table at all: what a disk fault, or a stranger, has left there
        path.unlink(missing_ok=True)
        return _ready(sqlite3.connect(path))


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
    for name in _REPEATED:
        data[name] = sys.intern(data[name])
    if (summary := data["summary"]) is not None:
        data["summary"] = _unchecked(Summary, {**summary, "extents": tuple(summary["extents"])})
    for issue in data["warnings"]:
        issue |= {"severity": _SEVERITIES[issue["severity"]], "code": sys.intern(issue["code"])}
    for guess in data["guesses"]:
        guess |= {"subject": sys.intern(guess["subject"]), "value": sys.intern(guess["value"])}
    data["warnings"] = tuple([_unchecked(Issue, issue) for issue in data["warnings"]])
    data["guesses"] = tuple([_unchecked(Guess, guess) for guess in data["guesses"]])
    data["results"] = ()
    data["colors"] = tuple([(sys.intern(name), share) for name, share in data["colors"]])
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


def _unchecked(kind: type[R], values: dict[str, Any]) -> R:
    """A record of values that were checked before; `model_construct` does the same in five times the time."""
    names, every = _fields_of(kind)
    made = kind.__new__(kind)
    # Names out of JSON would be other strings in each record.
    object.__setattr__(made, "__dict__", {name: values[name] for name in names})
    object.__setattr__(made, "__pydantic_fields_set__", every)
    object.__setattr__(made, "__pydantic_extra__", None)
    object.__setattr__(made, "__pydantic_private__", None)
    return made


@cache
def _fields_of(kind: type[Record]) -> tuple[tuple[str, ...], set[str]]:
    """Names of the fields of a record, and a set of them for all: one each would be much of the memory of a table."""
    return tuple(kind.model_fields), set(kind.model_fields)


def _folders(library: Library) -> Iterator[tuple[Path, str, str]]:
    """Folder, its path relative to the library, and the name of the file that says what it is; accepted first."""
    for folders, file in ((library.accepted(), CERTIFICATE), (library.refused(), REFUSAL)):
        for folder in folders:
            yield folder, f"{folder.parent.name}/{folder.name}", file


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


def _short(state: str) -> str:
    """A state in few bytes, for memory."""
    return hashlib.blake2b(state.encode(), digest_size=16).hexdigest()


def _state(path: Path | str) -> str:
    """Return the state of a file, which changes whenever it is written again."""
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
