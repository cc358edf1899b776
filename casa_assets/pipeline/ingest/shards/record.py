"""shard.jsonl of a shard's library: what its run found out about its inputs, for a merge that reads none of them.

The first line says which part of which run it is, each further one tells of an input, or of the refused rows of a
file. A run writes the first line when it begins and all of them, by one rename, when it ends: a shard whose run was cut
off is known by that. Results of the work on inputs are no part of it; they are the entries of the library.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, StringConstraints, ValidationError

from casa_assets.errors import OutputError, Rejected
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.model.ingest.source import Source
from casa_assets.model.record import Record, Sha256
from casa_assets.pipeline.cache.cache_key import key_of
from casa_assets.pipeline.ingest.refused_rows import MAX_FILES, OTHER_FILES, RefusedFile, RefusedRows
from casa_assets.pipeline.ingest.shards.shard import Shard
from casa_assets.pipeline.ingest.split import HeldThings
from casa_assets.pipeline.ingest.survey import Survey
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_files import file_inside

NAME = "shard.jsonl"
Number = Annotated[int, Field(ge=0)]
Code = Annotated[str, StringConstraints(pattern=r"^([A-Z]{3}[0-9]{3})?$")]


class ShardHeader(Record):
    """First line of the file.

    Attributes:
        index, count: of the shard. is_complete: its run has ended; else what follows is missing.
        category, split, keep_duplicates, limits: of the run, see `ingest.run.Options`; all limits by their names.
        cache_key: of the run. made_by: key of the code that discovers and surveys inputs.
        roots: absolute paths and addresses of the sources.
        inputs: how many all shards have together; rows of manifests that were refused count as inputs.
        inputs_digest: of what all of them are; the same in all shards of one run.
        lines: how many follow.
    """

    schema_version: Literal[1] = 1
    index: Annotated[int, Field(ge=1)]
    count: Annotated[int, Field(ge=1)]
    is_complete: bool
    category: str
    split: bool
    keep_duplicates: bool
    limits: dict[str, float]
    cache_key: str
    made_by: str
    roots: tuple[str, ...]
    inputs: Number = 0
    inputs_digest: str = ""
    lines: Number = 0

    @property
    def shard(self) -> Shard:
        """The part of the run."""
        return Shard(self.index, self.count)


class SurveyRecord(Record):
    """Survey of an input, see `ingest.survey.Survey`; where it could not be read, code and message say why."""

    sha256: Sha256 | Literal[""] = ""
    category: str = ""
    confidence: float = 0.0
    reason: str = ""
    code: Code = ""
    message: str = ""

    @property
    def answer(self) -> Survey | Rejected:
        """The survey, or the reason why there is none."""
        if self.code:
            return Rejected(self.code, self.message)
        return Survey(self.sha256, self.category, self.confidence, self.reason)


class ShardLine(Record):
    """One input, or the refused rows of one file.

    Attributes:
        number: of the input among those of all shards, in the order of discovery; of a file, of its first refused row.
        source: of an input. sha256, things: of a file that was taken apart, its digest and what it holds.
        surveys: of the input, or of each thing.
        refused: rows of a file; None of an input.
    """

    number: Number
    source: Source | None = None
    sha256: Sha256 | Literal[""] = ""
    things: tuple[str, ...] = ()
    surveys: tuple[SurveyRecord, ...] = ()
    refused: RefusedFile | None = None

    @property
    def held(self) -> HeldThings | None:
        """The things of a file that was taken apart."""
        return HeldThings(self.sha256, self.things) if self.things else None

    @property
    def inputs(self) -> Iterator[Found | Refused]:
        """What was discovered."""
        if self.source is not None:
            yield Found(Path(), "", self.source)
        if self.refused is not None:
            path, rest = self.refused.path, self.refused.rest
            yield from (Refused(path, code, message) for code, message in self.refused.rows)
            yield from (Refused(path, code, "") for code, count in rest.items() for _ in range(count))


@dataclass(frozen=True)
class ShardRecord:
    """Content of the file: what a shard's run found out. `library` is the one that it stands in."""

    library: disk.Library
    header: ShardHeader
    lines: Sequence[ShardLine]


class Discovery:
    """The inputs of a shard among all, as they are discovered; its memory is bounded by the shard's own.

    Args:
        library: of the shard.
    """

    def __init__(self, library: disk.Library, shard: Shard) -> None:
        self._shard, self._digest = shard, hashlib.sha256()
        self._refused, self._first_refused = RefusedRows(library), dict[str, int]()
        self.found: list[tuple[int, Found]] = []
        self.count = 0

    def own(self, inputs: Iterable[Found | Refused]) -> Iterator[Found | Refused]:
        """The inputs of the shard, while all are counted."""
        for number, one in enumerate(inputs):
            self.count += 1
            said = one.source.to_json() if isinstance(one, Found) else f"{one.path}\0{one.code}\0{one.message}"
            self._digest.update(f"{said}\n".encode())
            if not self._shard.has(one):
                continue
            if isinstance(one, Found):
                self.found.append((number, one))
            else:
                self._refused.add(one)
                if len(self._first_refused) < MAX_FILES:
                    self._first_refused.setdefault(one.path, number)
            yield one

    @property
    def digest(self) -> str:
        """Digest of all inputs; of two runs it is the same where the sources are."""
        return self._digest.hexdigest()

    def refused(self) -> Iterator[ShardLine]:
        """A line for each file with refused rows; what only counts comes last."""
        for file in self._refused.files():
            is_other = file.path == OTHER_FILES and file.path not in self._first_refused
            yield ShardLine(number=self.count if is_other else self._first_refused[file.path], refused=file)


def made_by() -> str:
    """Key of the code that decides which inputs there are and what each is."""
    return key_of(
        "casa_assets.pipeline.ingest.discover_inputs:discover_inputs",
        "casa_assets.pipeline.ingest.survey:survey",
        "casa_assets.pipeline.ingest.split:things_held",
        "casa_assets.pipeline.ingest.shards.shard:file_of",
        "casa_assets.pipeline.ingest.shards.shard:index_of",
    )


def write_record(library: disk.Library, header: ShardHeader, lines: Iterable[ShardLine] = ()) -> None:
    """Write the file anew, by one rename."""
    ordered = sorted(lines, key=lambda line: line.number)
    fresh = library.private / f"{NAME}.{os.getpid()}"
    with fresh.open("w", encoding="utf-8") as out:
        out.write(header.replace(lines=len(ordered)).model_dump_json() + "\n")
        for line in ordered:
            out.write(line.model_dump_json(exclude_defaults=True) + "\n")
    fresh.replace(library.root / NAME)


def read_header(library: disk.Library) -> ShardHeader | None:
    """First line of the file; None where a library is no shard. Raises OutputError where it is damaged."""
    path = library.root / NAME
    if not os.path.lexists(path):
        return None
    file_inside(path.parent, NAME, path, "the file itself")
    with path.open("rb") as lines:
        return _header(path, lines.readline())


def read_record(library: disk.Library, categories: Mapping[str, object]) -> ShardRecord:
    """What a shard's run found out.

    Args:
        categories: those that there are, by id.
    Raises:
        OutputError: the library is no shard, its run has not ended, or the file is damaged.
    """
    path = library.root / NAME
    header = read_header(library)
    if header is None:
        message = f"holds no {NAME}, so it is no shard; `casa-assets ingest SOURCES --shard i/n` makes them"
        raise OutputError(str(library.root), message)
    if not header.is_complete:
        message = f"the run of shard {header.shard} has not ended; run the same command again, then merge"
        raise OutputError(str(library.root), message)
    found: list[ShardLine] = []
    with path.open("rb") as lines:
        next(lines)
        for number, line in enumerate(lines, 2):
            found.append(_line(path, number, line, categories, header.split))
    if len(found) != header.lines:
        message = f"has {len(found)} of {header.lines} lines; copy it again, or run the shard again"
        raise OutputError(str(path), message)
    return ShardRecord(library, header, found)


def _header(path: Path, line: bytes) -> ShardHeader:
    try:
        return ShardHeader.model_validate_json(line)
    except ValidationError as error:
        message = f"line 1 is damaged ({_first_fault(error)}); remove the folder, and run the shard again"
        raise OutputError(str(path), message) from error


def _line(path: Path, number: int, text: bytes, categories: Mapping[str, object], is_split: bool) -> ShardLine:
    try:
        line = ShardLine.model_validate_json(text)
        fault = _fault(line, categories, is_split)
    except ValidationError as error:
        line, fault = ShardLine(number=0), _first_fault(error)
    if fault:
        raise OutputError(str(path), f"line {number} is damaged ({fault}); run the shard again")
    return line


def _fault(line: ShardLine, categories: Mapping[str, object], is_split: bool) -> str:
    """What is wrong with a line; empty where nothing is."""
    if (line.source is None) == (line.refused is None) or (line.things and not is_split):
        return "it is neither an input nor a file of refused rows"
    if line.source is not None and len(line.surveys) != (len(line.things) or 1):
        return f"{len(line.surveys)} surveys"
    read = [survey for survey in line.surveys if not survey.code]
    if any(not survey.sha256 for survey in read) or (line.things and not line.sha256):
        return "a digest is missing"
    # A folder is named by it.
    unknown = {survey.category for survey in read} - categories.keys()
    return f"there is no category {min(unknown)!r}" if unknown else ""


def _first_fault(error: ValidationError) -> str:
    first = error.errors(include_url=False)[0]
    return f"{'.'.join(map(str, first['loc'])) or 'the line'}: {first['msg']}"
