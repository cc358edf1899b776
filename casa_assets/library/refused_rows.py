"""Record inputs that were refused without a mesh (rows of manifests, pipes, links) in one file of the library.

A manifest may have a million bad rows, and a folder for each would be a million folders. So `rejected/rows.jsonl` has
one line for each file: how many rows were refused for which reason, and the first of them word for word.
"""

from __future__ import annotations

import hashlib
import os
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from pydantic import ValidationError

from casa_assets import registry
from casa_assets.errors import OutputError
from casa_assets.ingest.sources.found import Refused
from casa_assets.ingest.sources.places import StoreRoot
from casa_assets.ingest.sources.stores import folder_of
from casa_assets.library.entry_files import file_inside
from casa_assets.library.identity import Producer
from casa_assets.library.library import REJECTED, Library
from casa_assets.model.record import Record
from casa_assets.model.source import SourceKind

NAME = "rows.jsonl"
# Rows of a file that are kept with their messages; the others are counted.
MAX_ROWS_PER_FILE = 100
# Files of one run with a line of their own; all others share one line.
MAX_FILES = 10_000
OTHER_FILES = "(other files)"


class RefusedFile(Record):
    """Refused rows of one file: its path, how many rows by code, and code and reason of the first ones."""

    path: str
    counts: dict[str, int]
    rows: tuple[tuple[str, str], ...]

    @property
    def rest(self) -> dict[str, int]:
        """Code -> how many rows were counted without being kept."""
        told = Counter(code for code, _ in self.rows)
        return {code: count - told[code] for code, count in sorted(self.counts.items()) if count > told[code]}


class RefusedRows:
    """The refused rows of one run, and those of the run before it; its memory is bounded however many there are."""

    def __init__(self, library: Library) -> None:
        self._library = library
        self._before = {file.path: file for file in read(library)}
        self._counts: dict[str, Counter[str]] = {}
        self._rows: dict[str, list[tuple[str, str]]] = {}

    def add(self, row: Refused) -> str:
        """Count a row; returns the id that it is listed by, empty where it is only counted."""
        path = row.path if row.path in self._counts or len(self._counts) < MAX_FILES else OTHER_FILES
        rows = self._rows.setdefault(path, [])
        self._counts.setdefault(path, Counter())[row.code] += 1
        if len(rows) >= MAX_ROWS_PER_FILE or path == OTHER_FILES:
            return ""
        rows.append((row.code, row.message))
        return row_id(path, len(rows))

    def was_known(self, row: Refused) -> bool:
        """True if an earlier run refused the same for the same reason."""
        before = self._before.get(row.path)
        return before is not None and (row.code, row.message) in before.rows

    def was_counted(self, path: str, code: str, count: int) -> bool:
        """True if an earlier run counted as many more rows of a file for a reason."""
        before = self._before.get(path)
        return before is not None and before.rest.get(code) == count

    def rest(self) -> Iterator[tuple[str, str, int]]:
        """Path, code and number of the rows that were only counted."""
        for file in self.files():
            for code, count in file.rest.items():
                yield file.path, code, count

    def write(self, is_looked_at: Callable[[str], bool]) -> None:
        """Replace the file by one rename; lines of files that this run did not look at stay."""
        lines = {p: file for p, file in self._before.items() if p != OTHER_FILES and not is_looked_at(p)}
        lines |= {file.path: file for file in self.files()}
        target = self._library.root / REJECTED / NAME
        if not lines:
            target.unlink(missing_ok=True)
            return
        if len(lines) == len(self._before) and all(self._before.get(path) == file for path, file in lines.items()):
            return
        target.parent.mkdir(exist_ok=True)
        temporary = self._library.private / f"{NAME}.{os.getpid()}"
        with temporary.open("w", encoding="utf-8") as out:
            for path in sorted(lines):
                out.write(lines[path].model_dump_json() + "\n")
        temporary.replace(target)

    def files(self) -> Iterator[RefusedFile]:
        """The files whose rows were refused in this run, by path; all beyond `MAX_FILES` are one."""
        for path in sorted(self._counts):
            counts = dict(sorted(self._counts[path].items()))
            yield RefusedFile(path=path, counts=counts, rows=tuple(self._rows[path]))


def read(library: Library) -> list[RefusedFile]:
    """Read the refused rows of a library, by path. Raises OutputError where the file is damaged."""
    path = library.root / REJECTED / NAME
    if not os.path.lexists(path):
        return []
    file_inside(path.parent, NAME, path, "the file itself")
    found = []
    with path.open(encoding="utf-8") as lines:
        for number, line in enumerate(lines, 1):
            try:
                found.append(RefusedFile.model_validate_json(line))
            except ValidationError as error:
                raise OutputError(str(path), f"line {number} is damaged; remove the file and run again") from error
    return found


def listed(library: Library) -> Iterator[dict[str, str]]:
    """Id, path, code and reason of every row that is kept, and of the others of a file as one for each reason."""
    for file in read(library):
        for number, (code, message) in enumerate(file.rows, 1):
            yield {"id": row_id(file.path, number), "source_path": file.path, "code": code, "message": message}
        for code, count in file.rest.items():
            message = remainder_message(count)
            yield {"id": row_id(file.path, code), "source_path": file.path, "code": code, "message": message}


def remainder_message(count: int) -> str:
    """Message for rows that are only counted."""
    return f"{count} more for this reason; fix the first ones and run again"


def row_id(path: str, number: int | str) -> str:
    """The id that a refused row is listed by."""
    return f"unread_{hashlib.sha256(f'row:{path}:{number}'.encode()).hexdigest()[:10]}"


def place_of(path: str) -> dict[str, str]:
    """The fields that all rows of a file share, as an entry of the library has them."""
    return {
        "category": registry.FALLBACK,
        "path": f"{REJECTED}/{NAME}",
        "source": SourceKind.MANIFEST.value,
        "sha256": hashlib.sha256(path.encode()).hexdigest(),
        "licence": "unknown",
        "producer": Producer.INGEST.value,
    }


def is_below(roots: Sequence[Path | StoreRoot], path: str) -> bool:
    """True if a run over these roots looks at the file that a source calls so."""
    return any(_is_in(root, path) for root in roots)


def _is_in(root: Path | StoreRoot, path: str) -> bool:
    if isinstance(root, Path):
        return (root / path).is_file() if root.is_dir() else root.name == path
    return root.name == path or folder_of(root).has(path)
