"""Tables (Parquet) that hold a mesh file in each row: which column has them, and the file of one row."""

from __future__ import annotations

import importlib
import posixpath
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.formats import SUFFIXES
from casa_assets.ingest.load.notes import printable
from casa_assets.ingest.sources.containers.archive import SEEK_BLOCK
from casa_assets.ingest.sources.places import Folder

if TYPE_CHECKING:
    from pyarrow.parquet import ParquetFile

SUFFIX = ".parquet"
# Names that people give to columns of files, best first; a column may be called by its format, too.
COLUMNS = (
    *("mesh", "model", "object", "asset"),
    *sorted(suffix.removeprefix(".") for suffix in SUFFIXES),
    *("bytes", "content", "data", "file", "binary"),
)
# What the head of a table may take up; choices. One of a million columns is none that holds meshes.
MAX_HEAD_BYTES = 64 << 20
# Bytes of a column that are read at once: pages of some megabytes follow one another in it.
BUFFER_BYTES = 1 << 20


@dataclass(frozen=True)
class MeshColumn:
    """Column that holds the files.

    Attributes:
        name: in the table. is_struct: its values have a field `bytes` and possibly a field `path`.
        suffix: file suffix that its name implies, such as `.obj`; empty if it names no format.
    """

    name: str
    is_struct: bool = False

    @property
    def leaf(self) -> str:
        """Name of the column of bytes, as Parquet has it."""
        return f"{self.name}.bytes" if self.is_struct else self.name

    @property
    def suffix(self) -> str:
        """See the class."""
        suffix = f".{self.name.lower()}"
        return suffix if suffix in SUFFIXES else ""


def is_table(name: str) -> bool:
    """True for the name of a table."""
    return name.lower().endswith(SUFFIX) and len(name) > len(SUFFIX)


def mesh_column(table: ParquetFile) -> MeshColumn | None:
    """The column that holds mesh files; None if no column has one of the usual names."""
    types = importlib.import_module("pyarrow.types")
    found: dict[str, MeshColumn] = {}
    for field in table.schema_arrow:
        if types.is_binary(field.type) or types.is_large_binary(field.type):
            found.setdefault(field.name.lower(), MeshColumn(field.name))
        elif types.is_struct(field.type):
            inner = {part.name: part.type for part in field.type}
            if "bytes" in inner and (types.is_binary(inner["bytes"]) or types.is_large_binary(inner["bytes"])):
                found.setdefault(field.name.lower(), MeshColumn(field.name, is_struct=True))
    return next((found[name] for name in COLUMNS if name in found), None)


@contextmanager
def opened_table(folder: Folder, path: str) -> Iterator[ParquetFile]:
    """A table, of which no more than its head is read.

    Raises:
        Rejected: NEEDS_PYARROW, BAD_ARCHIVE, TOO_LARGE, and what files are refused for; also from within.
    """
    name = printable(posixpath.basename(path))
    try:
        # Not by `import`, for the reason that stores.client has.
        pyarrow = importlib.import_module("pyarrow")
        parquet = importlib.import_module("pyarrow.parquet")
    except ImportError as error:
        message = f"{name}: a table is read by pyarrow, which is not installed; pip install 'pyarrow>=17'"
        raise Rejected(codes.NEEDS_PYARROW, message) from error
    folder.check(path)
    faults = (pyarrow.ArrowException, OSError, ValueError, KeyError, IndexError, TypeError, OverflowError)
    try:
        with folder.open(path, SEEK_BLOCK) as stream:
            stream.seek(-8, 2)
            end = stream.read(8)
            head = int.from_bytes(end[:4], "little")
            if end[4:] == b"PAR1" and head > MAX_HEAD_BYTES:
                message = f"{name}: a table whose head takes {head} bytes, more than {MAX_HEAD_BYTES}; divide it"
                raise Rejected(codes.TOO_LARGE, message)
            # Bytes are read page by page, not a whole group of rows at once.
            yield parquet.ParquetFile(stream, pre_buffer=False, buffer_size=BUFFER_BYTES)
    except faults as error:
        why = printable(" ".join(str(error).split()), 80) or type(error).__name__
        raise Rejected(codes.BAD_ARCHIVE, f"{name}: a table that cannot be read ({why}); write it anew") from error


class TablePlace:
    """The file of one row, which is all that its mesh can refer to; see places.Place.

    Args:
        path: of the table in the folder. main: what the row's file is called. row: its number, from 0.
    """

    def __init__(self, folder: Folder, path: str, main: str, row: int) -> None:
        self._folder, self._path, self._main, self._row = folder, path, main, row

    def read(self, path: str, max_bytes: float) -> bytes:
        """See Place."""
        if path != self._main:
            raise Rejected(codes.MISSING_FILE, f"{printable(path, 80)}: a row holds one file; pack the mesh into one")
        with opened_table(self._folder, self._path) as table:
            value = _value(table, self._row)
        if not value:
            raise Rejected(codes.EMPTY_FILE, f"{self._main}: row {self._row} holds no bytes; write the table anew")
        if len(value) > max_bytes:
            most = max(0, int(max_bytes))
            message = f"{self._main}: {len(value)} bytes, more than the {most} left of --max-size; simplify it"
            raise Rejected(codes.TOO_LARGE, message)
        return value

    def has(self, path: str) -> bool:
        """See Place."""
        return path == self._main

    def is_inside(self, folder: str) -> bool:
        """See Place."""
        return True

    def listing(self, folder: str) -> list[str]:
        """See Place."""
        return [] if folder else [self._main]


def _value(table: ParquetFile, row: int) -> bytes | None:
    """Bytes of the file in a row; rows before it in its group are read one by one and let go."""
    column = mesh_column(table)
    if column is None:
        raise ValueError("no column of meshes any more")
    head: Any = table.metadata
    group = 0
    while row >= head.row_group(group).num_rows:
        row -= head.row_group(group).num_rows
        group += 1
    batches = table.iter_batches(batch_size=1, row_groups=[group], columns=[column.leaf], use_threads=False)
    for number, batch in enumerate(batches):
        if number == row:
            value = batch.column(0)[0].as_py()
            value = value.get("bytes") if isinstance(value, dict) else value
            return value if isinstance(value, bytes) else None
    raise ValueError(f"its groups have fewer rows than it says, {number + 1} of {row + 1}")
