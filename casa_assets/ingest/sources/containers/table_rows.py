"""Print the fields of a table's rows, except the files in them; a separate program, as tables are read by C++ code.

Standard input: pickled folder and path. Standard output: JSON lines, see `main`. It is started by `tabled`.
"""

from __future__ import annotations

import importlib
import json
import pickle
import resource
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from casa_assets.errors import Rejected
from casa_assets.ingest.sources.containers.table import MeshColumn, mesh_column, opened_table
from casa_assets.ingest.sources.places import folder_of
from casa_assets.ingest.sources.rows import TEXTS
from casa_assets.ingest.sources.untrusted_fields import MAX_CHARACTERS, MAX_HINTS

if TYPE_CHECKING:
    from pyarrow.parquet import ParquetFile

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
    texts = {*TEXTS, "url", "tags", *IDS, *PATHS, *FORMATS}
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
            out[name] = value[: 2 * MAX_CHARACTERS]
        elif isinstance(value, list):
            out[name] = [text[: 2 * MAX_CHARACTERS] for text in value[:MAX_HINTS] if isinstance(text, str)]
        elif value is not None:
            out[name] = value
    return out
