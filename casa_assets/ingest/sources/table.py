"""Tables (Parquet) that hold a mesh file in each row: inputs named `table.parquet!row.glb`, and the file of one row.

The other columns of all rows are read in a separate program (`main`), as tables are read by C++ code.
"""

from __future__ import annotations

import importlib
import json
import pickle
import posixpath
import resource
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import SUFFIXES, suffix_of
from casa_assets.formats.read.text import printable
from casa_assets.ingest.sources import rows
from casa_assets.ingest.sources.archive import SEEK_BLOCK
from casa_assets.ingest.sources.places import (
    MAX_HINTS,
    MAX_INDEX_BYTES,
    TABLE_SUFFIX,
    Folder,
    Found,
    Package,
    Place,
    Refused,
    folder_of,
    kind_of_other,
    packed_place,
    unread,
    words_of_path,
)
from casa_assets.model import rejection_codes as codes

if TYPE_CHECKING:
    from pyarrow.parquet import ParquetFile

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

    `name`: in the table. `is_struct`: its values have a field `bytes` and possibly a field `path`. `suffix`: file
    suffix that its name implies, such as `.obj`; empty if it names no format.
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
    """A table, of which no more than its head is read. Raises Rejected, also from within."""
    name = printable(posixpath.basename(path))
    try:
        # Not by `import`, for the reason that places._fsspec has.
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


def row_of_table(folder: Folder, path: str, main: str, row: int) -> Place:
    """The file `main` of a row, from 0, of the table at a path; it is all that its mesh can refer to."""

    def read(name: str, max_bytes: float) -> bytes:
        if name != main:
            raise Rejected(codes.MISSING_FILE, f"{printable(name, 80)}: a row holds one file; pack the mesh into one")
        with opened_table(folder, path) as table:
            value = _value(table, row)
        if not value:
            raise Rejected(codes.EMPTY_FILE, f"{main}: row {row} holds no bytes; write the table anew")
        if len(value) > max_bytes:
            most = max(0, int(max_bytes))
            message = f"{main}: {len(value)} bytes, more than the {most} left of --max-size; simplify it"
            raise Rejected(codes.TOO_LARGE, message)
        return value

    return packed_place(read, lambda: [main])


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


# Limits of this process; choices. A table of 250,000 rows takes a tenth of them.
MEMORY_BYTES, CPU_S = 2 << 30, 300
# Rows that are read at once.
BATCH_ROWS = 1024
IDS = ("uid", "id", "__key__", "key")
PATHS = ("path", "file_name", "filename", "file")
FORMATS = ("format", "file_type", "filetype", "fileType", "extension", "ext")


def main() -> None:
    """Print {"column": name or "", "suffix", "columns", "rows"}, then {field: value} of each row, or {"fault": why}."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_S, CPU_S))
    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY_BYTES, MEMORY_BYTES))
    root, path = pickle.load(sys.stdin.buffer)  # noqa: S301  of the process that started this one
    try:
        with opened_table(folder_of(root), path) as table:
            for line in _lines(table):
                sys.stdout.write(json.dumps(line) + "\n")
    except Rejected as error:
        sys.stdout.write(json.dumps({"fault": [error.code, error.message]}) + "\n")
    sys.stdout.flush()


def _lines(table: ParquetFile) -> Iterator[dict[str, Any]]:
    column, names = mesh_column(table), [field.name for field in table.schema_arrow]
    count = int(table.metadata.num_rows)
    if column is None:
        yield {"column": "", "suffix": "", "columns": names[:MAX_HINTS], "rows": count}
        return
    yield {"column": column.name, "suffix": column.suffix, "columns": [], "rows": count}
    wanted = _columns(table, column)
    if not wanted:
        yield from ({} for _ in range(count))
        return
    for batch in table.iter_batches(batch_size=BATCH_ROWS, columns=wanted, use_threads=False):
        fields = {name: batch.column(at).to_pylist() for at, name in enumerate(batch.schema.names)}
        for row in range(batch.num_rows):
            yield _row({name: values[row] for name, values in fields.items()}, column)


def _columns(table: ParquetFile, column: MeshColumn) -> list[str]:
    """Columns that say something of meshes: texts, whole numbers of ids, lists of texts of tags."""
    types = importlib.import_module("pyarrow.types")
    found = []
    texts = {*rows.TEXTS, "url", "tags", *IDS, *PATHS, *FORMATS}
    for field in table.schema_arrow:
        kind, name = field.type, field.name
        is_text = types.is_string(kind) or types.is_large_string(kind)
        is_list = (types.is_list(kind) or types.is_large_list(kind)) and types.is_string(kind.value_type)
        is_number = types.is_integer(kind) and name in IDS
        if (is_text and name in texts) or (is_list and name == "tags") or is_number:
            found.append(name)
        elif name == column.name and column.is_struct and any(part.name == "path" for part in kind):
            found.append(f"{name}.path")
    return found


def _row(values: dict[str, Any], column: MeshColumn) -> dict[str, Any]:
    """Fields of a row, cut to what is ever looked at."""
    if column.is_struct and isinstance(inner := values.pop(column.name, None), dict):
        values["path"] = inner.get("path") or values.get("path")
    out: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, str):
            out[name] = value[: 2 * rows.MAX_CHARACTERS]
        elif isinstance(value, list):
            out[name] = [text[: 2 * rows.MAX_CHARACTERS] for text in value[:MAX_HINTS] if isinstance(text, str)]
        elif value is not None:
            out[name] = value
    return out


_CODE = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from casa_assets.ingest.sources.table import main; main()"
)
MAX_LINE_BYTES = 1 << 20


def tabled(package: Package, name: str, others: Counter[str], is_named: bool = False) -> Iterator[Found | Refused]:
    """Inputs in one table; one without a column of meshes is counted, or refused where the user pointed at it."""
    try:
        package.check_utf8(name)
        package.files.check(name)
        lines = _printed(package, name)
        head = next(lines, {})
        if not head.get("column"):
            if is_named:
                has = ", ".join(printable(str(column), 40) for column in head.get("columns", ())) or "none"
                message = (
                    f"{printable(name)}: no column of bytes is called {', '.join(COLUMNS)}; it has {has}; rename one"
                )
                raise Rejected(codes.WRONG_TYPE, message)
            others["tables and settings"] += 1
            return
        yield from _rows(package, name, str(head.get("suffix", "")), lines, others)
    except Rejected as error:
        yield package.refuse(name, error)


def _printed(package: Package, name: str) -> Iterator[dict[str, Any]]:
    """What `main` prints. Raises Rejected where it ends otherwise than by itself, or prints too much."""
    with subprocess.Popen(
        [sys.executable, "-c", _CODE, json.dumps(sys.path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    ) as child:
        assert child.stdin is not None
        assert child.stdout is not None
        try:
            with child.stdin as to_child:
                to_child.write(pickle.dumps((package.root, name)))
            left = MAX_INDEX_BYTES
            while line := child.stdout.readline(MAX_LINE_BYTES):
                left -= len(line)
                row = rows.parse_json(line, printable(name)) if left >= 0 else None
                if not isinstance(row, dict):
                    message = f"{printable(name)}: a table whose rows say more than {MAX_INDEX_BYTES} bytes; divide it"
                    raise Rejected(codes.TOO_LARGE, message)
                if "fault" in row:
                    raise Rejected(*row["fault"])
                yield row
            child.wait()
        finally:
            child.kill()
    if child.returncode:
        message = f"{printable(name)}: a table whose reader died, by its limits or by a fault; write it anew"
        raise Rejected(codes.BAD_ARCHIVE, message)


def _rows(
    package: Package, name: str, suffix: str, lines: Iterator[Mapping[str, Any]], others: Counter[str]
) -> Iterator[Found | Refused]:
    ids: dict[str, str] = {}
    for number, row in enumerate(lines):
        place = f"{printable(name)} row {number}"
        if number >= rows.MAX_ROWS:
            why = f"more than {rows.MAX_ROWS} rows, which is what a run holds in memory; divide it"
            yield package.refuse(name, Rejected(codes.TOO_LARGE, f"{printable(name)}: {why}"))
            return
        try:
            uid, key = _names(row, number, place, ids)
            rows.check_types(row, place)
        except Rejected as error:
            yield package.refuse(name, error)
            continue
        words = (f".{str(row.get(column, '')).lower().strip().removeprefix('.')}" for column in FORMATS)
        stated = next((word for word in words if word in SUFFIXES), "")
        named = (suffix_of(str(row.get(column, ""))) for column in PATHS)
        main = f"{key}{stated or next(filter(None, named), '') or suffix or '.glb'}"
        path = f"{package.prefix}{name}!{main}"
        if kind := kind_of_other(main, frozenset()):
            others[kind] += 1
        elif (refused := unread(path)) is not None:
            yield refused
        else:
            inner = next((str(row[column]) for column in PATHS if row.get(column)), "").replace("\\", "/")
            around = [name[: -len(TABLE_SUFFIX)], *package.prefix.rstrip("/").split("/")[::-1], package.root.name]
            source = rows.source_of(row, path, uid, [*words_of_path(inner), *around])
            yield Found(package.root, main, source, archive=name, at=number)


def _names(row: Mapping[str, Any], number: int, place: str, ids: dict[str, str]) -> tuple[str, str]:
    """Id that a row states, or nothing, and the stem of its file, both unique; `ids`: takes up the names."""
    stated = next(((column, row[column]) for column in IDS if row.get(column) is not None), None)
    if stated is None:
        return "", f"{number:06}"
    column, value = stated
    try:
        uid = rows.safe_id(str(value) if type(value) is int else value, place)
    except Rejected:
        if column in ("__key__", "key"):
            return "", f"{number:06}"
        raise
    rows.check_unique(uid, place, ids)
    ids[uid] = place
    return uid, uid
