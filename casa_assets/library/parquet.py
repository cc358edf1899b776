"""Entries as Parquet: the parts of a folder over any number of libraries, written in a stream.

    FOLDER/index.json                        which parts there are, of which library
    FOLDER/<library>_<hash>_<number>_<digest>.parquet    up to PART_ROWS rows of one library, by category and id
    FOLDER/.casa/                            the states that the libraries had; may be deleted

The same entries give the same bytes. A part appears under a name that holds its digest, and counts once index.json
names it: after a run that was killed the table is what it was before.
"""

from __future__ import annotations

import hashlib
import json
import os.path
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.core.system import kept_json, replace_file, require
from casa_assets.errors import OutputError
from casa_assets.library.entry import Entry
from casa_assets.library.entry_files import Summary
from casa_assets.library.entry_table import stream_entries
from casa_assets.library.library import Library
from casa_assets.model.record import Record, Sha256

if TYPE_CHECKING:
    import pyarrow

Value = str | float | int | None


def _of_summary(read: Callable[[Summary], float]) -> Callable[[Entry], float | None]:
    return lambda entry: None if entry.summary is None else read(entry.summary)


# Columns with their types in Arrow, and their values of an entry; a number is null where an entry has none.
COLUMNS: dict[str, tuple[str, Callable[[Entry], Value]]] = {
    "id": ("string", lambda e: e.id),
    "status": ("string", lambda e: e.decision.value),
    "category": ("string", lambda e: e.category),
    "code": ("string", lambda e: e.code),
    "message": ("string", lambda e: e.message),
    "path": ("string", lambda e: e.path),
    "size_x_m": ("float64", _of_summary(lambda s: s.extents[0])),
    "size_y_m": ("float64", _of_summary(lambda s: s.extents[1])),
    "size_z_m": ("float64", _of_summary(lambda s: s.extents[2])),
    "mass_kg": ("float64", _of_summary(lambda s: s.mass)),
    "colliders": ("int64", _of_summary(lambda s: s.colliders)),
    "hull_vertices": ("int64", _of_summary(lambda s: s.hull_vertices)),
    "faces": ("int64", _of_summary(lambda s: s.faces)),
    "warnings": ("int64", lambda e: len(e.warnings)),
    "checks": ("int64", lambda e: e.checks.applying),
    "checks_passed": ("int64", lambda e: e.checks.passed),
    "checks_not_run": ("int64", lambda e: e.checks.not_run),
    "checks_not_applicable": ("int64", lambda e: e.checks.not_applicable),
    "source": ("string", lambda e: e.source),
    "source_path": ("string", lambda e: e.source_path),
    "source_sha256": ("string", lambda e: e.sha256),
    "title": ("string", lambda e: e.title),
    "author": ("string", lambda e: e.author),
    "licence": ("string", lambda e: e.licence),
    "split": ("string", lambda e: e.split),
    "digest": ("string", lambda e: e.digest),
    "producer": ("string", lambda e: e.producer),
    "cache_key": ("string", lambda e: e.cache_key),
    "portion": ("string", lambda e: e.portion),
    "uri": ("string", lambda e: e.uri),
    "prompt": ("string", lambda e: e.prompt),
    "generator": ("string", lambda e: e.generator),
    "advice": ("string", lambda e: " ".join(e.advice)),
    "decide": ("string", lambda e: " ".join(e.to_decide)),
    "colors": ("string", lambda e: " ".join(f"{name}={share}" for name, share in e.colors)),
}
NAME = "index.json"
STATES = "table_states.json"
# Rows that are sorted in memory at once, and that a reader has to have in memory at once.
PART_ROWS, GROUP_ROWS = 200_000, 20_000
# Rows that are turned into Arrow at once.
BATCH_ROWS = 10_000
COMPRESSION = "zstd"
_PART_NAME = re.compile(r"[a-z0-9_]+_[0-9a-f]{8}_[0-9]{5}_[0-9a-f]{8}\.parquet")


class PartFile(Record):
    """One file of rows. name: in the folder. sha256: of the file."""

    name: str
    rows: Annotated[int, Field(ge=0)]
    sha256: Sha256


class LibraryParts(Record):
    """The parts of one library. library: its folder, relative to that of the parts, POSIX."""

    library: str
    parts: tuple[PartFile, ...]

    @property
    def rows(self) -> int:
        """How many rows there are."""
        return sum(part.rows for part in self.parts)


class PartsIndex(Record):
    """Content of index.json. columns: of all parts. libraries: sorted by their folders."""

    schema_version: Literal[1] = 1
    columns: tuple[str, ...]
    libraries: tuple[LibraryParts, ...]

    @property
    def rows(self) -> int:
        """How many rows there are."""
        return sum(library.rows for library in self.libraries)


@dataclass(frozen=True)
class WrittenParts:
    """Parts that were written, or kept. kept: folders of libraries whose parts stayed."""

    index: PartsIndex
    kept: tuple[str, ...]


def require_parquet() -> None:
    """Raise CasaError, which names the extra to install, where Parquet cannot be read and written."""
    require("pyarrow", "parquet", "Parquet")


def write_index(
    libraries: Sequence[Library],
    folder: Path,
    force: bool = False,
    entries_of: Callable[[Library], Iterable[Entry]] = stream_entries,
) -> WrittenParts:
    """Write the parts of libraries; parts of a library with no entry added, removed or replaced are kept.

    Args:
        libraries: all that the folder is to index; parts of other libraries in it are removed.
        force: write all parts again, including those of libraries in which only a file was edited in place.
    Raises:
        CasaError: pyarrow is not installed.
        OutputError: an entry is damaged, one library is named twice, or the folder cannot be written to.
    """
    require_parquet()
    own = Library(folder)
    base = folder.resolve()
    by_name = {Path(os.path.relpath(one.root.resolve(), base)).as_posix(): one for one in libraries}
    if len(by_name) < len(libraries):
        raise OutputError(str(folder), "is to hold one library twice; name each once")
    try:
        with own.locked():
            own.sweep()
            before = {} if force else _known(own)
            states: dict[str, str] = {}
            found: list[LibraryParts] = []
            kept: list[str] = []
            for name in sorted(by_name):
                # It changes whenever an entry comes, goes or is replaced, and with this code.
                states[name] = digest_of(key_of(write_index), by_name[name].shelf_times())
                state, old = before.get(name, ("", None))
                if old is not None and state == states[name] and all((folder / p.name).is_file() for p in old.parts):
                    found.append(old)
                    kept.append(name)
                else:
                    rows = (tuple(read(entry) for _, read in COLUMNS.values()) for entry in entries_of(by_name[name]))
                    found.append(LibraryParts(library=name, parts=tuple(_write_parts(rows, own, name))))
            index = PartsIndex(columns=tuple(_schema().names), libraries=tuple(found))
            _publish(own, index, states)
    except OSError as error:
        raise OutputError(str(folder), f"cannot be written to: {error.strerror or error}") from error
    return WrittenParts(index, tuple(kept))


def _write_parts(rows: Iterable[Sequence[Value]], own: Library, library: str) -> Iterator[PartFile]:
    """Write rows of one library as parts; yields each once it is there.

    Args:
        rows: values of COLUMNS, in any order; up to PART_ROWS of them are sorted together.
        library: its folder, relative to that of the parts.
    """
    import pyarrow
    import pyarrow.parquet

    stem = re.sub(r"[^a-z0-9]+", "_", Path(library).name.lower()).strip("_") or "library"
    stem = f"{stem[:40]}_{hashlib.sha256(library.encode()).hexdigest()[:8]}"
    stream, number = iter(rows), 0
    while batches := list(_batches(islice(stream, PART_ROWS), library)):
        table = pyarrow.Table.from_batches(batches)
        del batches
        table = table.sort_by([("category", "ascending"), ("id", "ascending")])
        fresh = own.staging / f"{stem}_{number:05}"
        pyarrow.parquet.write_table(table, fresh, row_group_size=GROUP_ROWS, compression=COMPRESSION)
        with fresh.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
        name = f"{fresh.name}_{digest[:8]}.parquet"
        fresh.replace(own.root / name)
        yield PartFile(name=name, rows=len(table), sha256=digest)
        number += 1


def _batches(rows: Iterator[Sequence[Value]], library: str) -> Iterator[pyarrow.RecordBatch]:
    import pyarrow

    while some := list(islice(rows, BATCH_ROWS)):
        columns = [*zip(*some, strict=True), (library,) * len(some)]
        schema = _schema()
        yield pyarrow.record_batch(
            [pyarrow.array(values, field.type) for values, field in zip(columns, schema, strict=True)], schema=schema
        )


@cache
def _schema() -> pyarrow.Schema:
    import pyarrow

    types = {name: pyarrow.type_for_alias(kind) for name, (kind, _) in COLUMNS.items()}
    return pyarrow.schema([*types.items(), ("library", pyarrow.string())])


def _known(own: Library) -> dict[str, tuple[str, LibraryParts]]:
    """The parts of each library and the state in which they were written; of those that are known."""
    said = kept_json(own.cache / STATES)
    try:
        index = PartsIndex.model_validate_json((own.root / NAME).read_bytes())
    except (OSError, ValueError):
        return {}
    if not isinstance(said, dict) or said.get("") != index.digest:  # the index is of another run
        return {}
    return {one.library: (str(said[one.library]), one) for one in index.libraries if one.library in said}


def _publish(own: Library, index: PartsIndex, states: Mapping[str, str]) -> None:
    """Put index.json in place by one rename, then take away what it does not name."""
    text = json.dumps(index.model_dump(mode="json"), sort_keys=True, indent=1) + "\n"
    replace_file(own.cache / STATES, b"{}")
    replace_file(own.root / NAME, text.encode())
    replace_file(own.cache / STATES, json.dumps({**states, "": index.digest}).encode())
    named = {part.name for library in index.libraries for part in library.parts}
    for path in own.root.glob("*.parquet"):
        if path.name not in named and _PART_NAME.fullmatch(path.name):
            path.unlink(missing_ok=True)
