"""Entries of a library, accepted or rejected, as tables and reports need them: read from JSON alone.

Inputs that were refused without a mesh (rows of manifests, pipes, links) share one file, `rejected/rows.jsonl`: a
manifest may have a million bad rows, and a folder for each would be a million folders. It has one line for each file:
how many rows were refused for which reason, and the first of them word for word.
"""

from __future__ import annotations

import hashlib
import os
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from casa_assets import registry
from casa_assets.errors import OutputError
from casa_assets.ingest.sources.places import Refused, StoreRoot, folder_of
from casa_assets.library import entry_files
from casa_assets.library.entry_files import (
    CERTIFICATE,
    REFUSAL,
    Manifest,
    Producer,
    Summary,
    file_inside,
    read_manifest,
    read_refusal,
)
from casa_assets.library.library import REJECTED, Library
from casa_assets.model.asset.asset import Guess, Provenance
from casa_assets.model.issue import CheckResult, Decision, Issue, Severity, Tally, subjects_to_decide
from casa_assets.model.record import Record
from casa_assets.model.source import SourceKind

NO_CHECKS = Tally()
STATED = ("title", "author", "licence", "uri", "prompt", "generator")  # of an input, by its source


@dataclass(frozen=True)
class Entry:
    """One row.

    Attributes:
        id, category: of the asset. path: its folder, relative to the library.
        accepted: there is an asset, even if in review; if not, code and message.
        summary, warnings, results, guesses: of an accepted one (as far as known for a rejected one).
        checks: number of them by status; the results are left out if only the numbers are needed.
        source, source_path, sha256, title, author, licence, uri, prompt, generator: provenance.
        split: train or test, as the asset states; empty if not stated.
        portion: remaining part of an object that was cut, such as `half`; empty for a whole one.
        digest: of the asset, empty for rejected ones. producer: ingest, articulate or family. cache_key: of the entry.
        is_whole: False if a file of an accepted one is missing.
        colors: words for the colours of an accepted one, with the share of the surface that each has; empty if its
            source states no colours.
    """

    id: str
    category: str
    path: str
    accepted: bool
    code: str = ""
    message: str = ""
    summary: Summary | None = None
    warnings: tuple[Issue, ...] = ()
    results: tuple[CheckResult, ...] = ()
    guesses: tuple[Guess, ...] = ()
    source: str = ""
    source_path: str = ""
    sha256: str = ""
    title: str = ""
    author: str = ""
    licence: str = ""
    uri: str = ""
    prompt: str = ""
    generator: str = ""
    split: str = ""
    digest: str = ""
    producer: str = ""
    cache_key: str = ""
    portion: str = ""
    checks: Tally = NO_CHECKS
    is_whole: bool = True
    colors: tuple[tuple[str, float], ...] = ()

    @property
    def to_decide(self) -> tuple[str, ...]:
        """Return the subjects that a person has to decide about an asset, such as `scale`; see review.csv."""
        return subjects_to_decide(self.warnings)

    @property
    def decision(self) -> Decision:
        """Accepted, in review, or rejected."""
        if not self.accepted:
            return Decision.REJECTED
        return Decision.REVIEW if self.to_decide else Decision.ACCEPTED

    @property
    def advice(self) -> tuple[str, ...]:
        """Codes of the warnings, each once, sorted."""
        return tuple(sorted({issue.code for issue in self.warnings}))


def entries(library: Library) -> Iterator[Entry]:
    """All entries, accepted first. Raises OutputError where one is damaged."""
    for folder in (*library.accepted(), *library.refused()):
        yield entry_at(folder, library.root)
    yield from row_entries(library)


def row_entries(library: Library) -> Iterator[Entry]:
    """Entries for inputs that were refused without a mesh, see RefusedRows."""
    for row in _listed(library):
        stated: dict[str, Any] = {**_place_of(row["source_path"]), **row}
        yield Entry(accepted=False, **stated)


def entry_at(folder: Path, root: Path) -> Entry:
    """The entry in one folder of the library at `root`. Raises OutputError where it is damaged."""
    if folder.parent.name == REJECTED:
        return _refused(folder, root)
    return entry_of(read_manifest(folder), root)


def entry_of(manifest: Manifest, root: Path) -> Entry:
    """The entry of an accepted asset whose manifest was read. Raises OutputError where it is damaged."""
    folder, certificate, data = manifest.folder, manifest.certificate, manifest.asset
    try:
        origin, category = Provenance.model_validate(data["provenance"]), str(data["labels"]["category"])
    except (ValidationError, KeyError, TypeError) as error:
        raise OutputError(str(folder / CERTIFICATE), f"is damaged: {error}; run again without it") from error
    if data.get("id") != folder.name:
        message = f"holds the asset {data.get('id')!r}; move it to a folder of that name"
        raise OutputError(str(folder / CERTIFICATE), message)
    signature = certificate.signature
    return Entry(
        id=folder.name,
        category=category,
        path=folder.relative_to(root).as_posix(),
        accepted=True,
        summary=certificate.summary,
        warnings=tuple(i for i in certificate.report.issues if i.severity is Severity.WARNING),
        results=certificate.report.results,
        guesses=origin.guesses,
        source=origin.source,
        source_path=origin.place,
        sha256=origin.sha256,
        **{name: getattr(origin, name) for name in STATED},
        split=str(data["labels"].get("split") or ""),
        portion=str(data["labels"].get("portion") or ""),
        digest=certificate.asset_digest,
        producer=certificate.producer.value,
        cache_key=certificate.cache_key,
        checks=certificate.report.tally,
        is_whole=entry_files.is_whole(folder, certificate),
        colors=signature.color.names if signature is not None and signature.color.stated else (),
    )


def _refused(folder: Path, root: Path) -> Entry:
    refusal = read_refusal(folder)
    if refusal.id != folder.name:
        raise OutputError(str(folder / REFUSAL), f"is that of {refusal.id!r}; move it to a folder of that name")
    source = refusal.source
    return Entry(
        id=refusal.id,
        category=refusal.category,
        path=folder.relative_to(root).as_posix(),
        accepted=False,
        code=refusal.code,
        message=refusal.message,
        results=refusal.report.results if refusal.report else (),
        source=source.kind.value,
        source_path=source.place,
        sha256=refusal.sha256,
        **{name: getattr(source, name) for name in STATED},
        producer=refusal.producer.value,
        cache_key=refusal.cache_key,
        checks=refusal.report.tally if refusal.report else NO_CHECKS,
    )


ROWS_NAME = "rows.jsonl"
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
        self._before = {file.path: file for file in read_refused(library)}
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
        target = self._library.root / REJECTED / ROWS_NAME
        if not lines:
            target.unlink(missing_ok=True)
            return
        if len(lines) == len(self._before) and all(self._before.get(path) == file for path, file in lines.items()):
            return
        target.parent.mkdir(exist_ok=True)
        temporary = self._library.private / f"{ROWS_NAME}.{os.getpid()}"
        with temporary.open("w", encoding="utf-8") as out:
            for path in sorted(lines):
                out.write(lines[path].model_dump_json() + "\n")
        temporary.replace(target)

    def files(self) -> Iterator[RefusedFile]:
        """The files whose rows were refused in this run, by path; all beyond `MAX_FILES` are one."""
        for path in sorted(self._counts):
            counts = dict(sorted(self._counts[path].items()))
            yield RefusedFile(path=path, counts=counts, rows=tuple(self._rows[path]))


def read_refused(library: Library) -> list[RefusedFile]:
    """Read the refused rows of a library, by path. Raises OutputError where the file is damaged."""
    path = library.root / REJECTED / ROWS_NAME
    if not os.path.lexists(path):
        return []
    file_inside(path.parent, ROWS_NAME, path, "the file itself")
    found = []
    with path.open(encoding="utf-8") as lines:
        for number, line in enumerate(lines, 1):
            try:
                found.append(RefusedFile.model_validate_json(line))
            except ValidationError as error:
                raise OutputError(str(path), f"line {number} is damaged; remove the file and run again") from error
    return found


def _listed(library: Library) -> Iterator[dict[str, str]]:
    """Id, path, code and reason of every row that is kept, and of the others of a file as one for each reason."""
    for file in read_refused(library):
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


def _place_of(path: str) -> dict[str, str]:
    """The fields that all rows of a file share, as an entry of the library has them."""
    return {
        "category": registry.FALLBACK,
        "path": f"{REJECTED}/{ROWS_NAME}",
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
