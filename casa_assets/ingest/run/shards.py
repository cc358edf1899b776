"""A run that works on one shard: which inputs are its own, and shard.jsonl, from which a merge is made."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, StringConstraints, ValidationError

from casa_assets.cache.cache_key import key_of
from casa_assets.errors import CasaError, OutputError, Rejected
from casa_assets.ingest.run.inputs import HeldThings, Survey, SurveyAnswer, discover_inputs, survey, things_held
from casa_assets.ingest.sources.places import Found, Refused, utf8_escaped
from casa_assets.library.entry import MAX_FILES, OTHER_FILES, RefusedFile, RefusedRows
from casa_assets.library.entry_files import Producer, file_inside
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.library import Library
from casa_assets.model.record import Record, Sha256
from casa_assets.model.source import Source
from casa_assets.runs.limits import WorkerFailure
from casa_assets.runs.outcome import FAILURE_CODES

# The first line of the record says which part of which run it is, each further one describes an input, or refused
# rows of a file. A run writes the first line when it begins and all of them, by one rename, when it ends: a shard
# whose run was cut off is known by that. Results of the work on inputs are no part of it, but entries of the library.
SHARD_FILE = "shard.jsonl"
# Options that a shard keeps from its first run on. Limits and code may change: what they void is made again.
LASTING = ("category", "split", "keep_duplicates")
Number = Annotated[int, Field(ge=0)]
Code = Annotated[str, StringConstraints(pattern=r"^([A-Z]{3}[0-9]{3})?$")]


@dataclass(frozen=True)
class Shard:
    """Part `index`, from 1, of `count` of a run's inputs, by names of files alone: machines need not agree on it."""

    index: int
    count: int

    def __str__(self) -> str:
        """Text such as `3/16`."""
        return f"{self.index}/{self.count}"

    @classmethod
    def parse(cls, text: str) -> Shard:
        """The shard that a text such as `3/16` names. Raises CasaError."""
        match = re.fullmatch(r"([0-9]{1,9})/([0-9]{1,9})", text)
        shard = cls(int(match[1]), int(match[2])) if match else None
        if shard is None or not 1 <= shard.index <= shard.count:
            raise CasaError(f"{text!r} is no shard; give i/n with i from 1 to n, such as 3/16: the third of sixteen")
        return shard

    def has(self, one: Found | Refused) -> bool:
        """True if this is the shard of an input."""
        return index_of(file_of(one), self.count) == self.index


def index_of(path: str, count: int) -> int:
    """Index of the shard of a file, 1 to `count`: by the sha256 of its path, so other files do not change it."""
    return int.from_bytes(hashlib.sha256(path.encode()).digest()[:8], "big") % count + 1


def file_of(one: Found | Refused) -> str:
    """Return the path, as its source calls it, of the file on disk with an input; of a member, its archive."""
    if isinstance(one, Refused):
        return one.path
    return one.source.path.removesuffix(f"!{utf8_escaped(one.main)}") if one.archive else one.source.path


class ShardHeader(Record):
    """First line of the file.

    Attributes:
        index, count: of the shard. is_complete: its run has ended; else what follows is missing.
        category, split, keep_duplicates, limits: of the run, see `ingest.run.run.Options`; all limits by their names.
        cache_key: of the run. made_by: key of the code that discovers and surveys inputs.
        roots: absolute paths and addresses of the sources.
        inputs: how many all shards have together; rows of manifests that were refused count as inputs.
        inputs_digest: of what all of them are; the same in all shards. lines: how many follow.
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
    """Survey of an input, see `ingest.run.inputs.Survey`; where it could not be read, code and message say why."""

    sha256: Sha256 | Literal[""] = ""
    category: str = ""
    confidence: float = 0.0
    reason: str = ""
    code: Code = ""
    message: str = ""

    @classmethod
    def of(cls, answer: SurveyAnswer) -> SurveyRecord:
        """The record of a survey, or of the reason why there is none."""
        if isinstance(answer, WorkerFailure):
            return cls(code=FAILURE_CODES[answer.reason], message=answer.text)
        return cls.model_validate(answer, from_attributes=True)

    @property
    def answer(self) -> Survey | Rejected:
        """The survey, or the reason why the input has no survey."""
        if self.code:
            return Rejected(self.code, self.message)
        return Survey(self.sha256, self.category, self.confidence, self.reason)


class ShardLine(Record):
    """One input, or the refused rows of one file.

    `number`: of the input among those of all shards, in the order of discovery; of a file, of its first refused row.
    `source`: of an input. `sha256`, `things`: of a file that was taken apart, its digest and what it holds. `surveys`:
    of the input, or of each thing. `refused`: rows of a file; None of an input.
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
        """Yield the inputs that were discovered."""
        if self.source is not None:
            yield Found(Path(), "", self.source)
        if self.refused is not None:
            path, rest = self.refused.path, self.refused.rest
            yield from (Refused(path, code, message) for code, message in self.refused.rows)
            yield from (Refused(path, code, "") for code, count in rest.items() for _ in range(count))


@dataclass(frozen=True)
class ShardRecord:
    """Content of the file: results of a shard's run. `library` is the one that contains the file."""

    library: Library
    header: ShardHeader
    lines: Sequence[ShardLine]


def made_by() -> str:
    """Key of the code that decides which inputs there are and what each is."""
    return key_of(discover_inputs, survey, things_held, file_of, index_of)


def write_record(library: Library, header: ShardHeader, lines: Iterable[ShardLine] = ()) -> None:
    """Replace the file by one rename."""
    ordered = sorted(lines, key=lambda line: line.number)
    rows = [header.replace(lines=len(ordered)).model_dump_json()]
    rows += [line.model_dump_json(exclude_defaults=True) for line in ordered]
    library.write(SHARD_FILE, "\n".join(rows) + "\n")


def read_header(library: Library) -> ShardHeader | None:
    """Return the first line of the file, or None if the library is no shard. Raises OutputError if it is damaged."""
    path = library.root / SHARD_FILE
    if not os.path.lexists(path):
        return None
    file_inside(path.parent, SHARD_FILE, path, "the file itself")
    with path.open("rb") as lines:
        text = lines.readline()
    try:
        return ShardHeader.model_validate_json(text)
    except ValidationError as error:
        message = f"line 1 is damaged ({_first_fault(error)}); remove the folder, and run the shard again"
        raise OutputError(str(path), message) from error


def read_record(library: Library, categories: Mapping[str, object]) -> ShardRecord:
    """Results of a shard's run; `categories`: all, by id. Raises OutputError: no shard, not ended, or damaged."""
    path = library.root / SHARD_FILE
    header = read_header(library)
    if header is None:
        message = f"holds no {SHARD_FILE}, so it is no shard; `casa-assets ingest SOURCES --shard i/n` makes them"
        raise OutputError(str(library.root), message)
    if not header.is_complete:
        message = f"the run of shard {header.shard} has not ended; run the same command again, then merge"
        raise OutputError(str(library.root), message)
    with path.open("rb") as lines:
        next(lines)
        found = [_line(path, number, line, categories, header.split) for number, line in enumerate(lines, 2)]
    if len(found) != header.lines:
        message = f"has {len(found)} of {header.lines} lines; copy it again, or run the shard again"
        raise OutputError(str(path), message)
    return ShardRecord(library, header, found)


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
    """Return the error in a line, or an empty text if there is no error."""
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


def check_is_no_shard(library: Library) -> None:
    """Check that a run over all inputs may write to a library. Raises OutputError where it is a shard."""
    if (header := read_header(library)) is not None:
        message = f"holds shard {header.shard}; add --shard {header.shard}, or name another folder"
        raise OutputError(str(library.root), message)


def check_shard(table: EntryTable, header: ShardHeader) -> None:
    """Check that a run of a shard may write there. Raises OutputError: no shard, another, or with other options."""
    root, before = str(table.root), read_header(Library(table.root))
    if before is None:
        if any(entry.producer == Producer.INGEST.value for entry in table.entries):
            raise OutputError(root, f"holds a library that is no shard; name another folder for {header.shard}")
    elif before.shard != header.shard:
        raise OutputError(root, f"holds shard {before.shard}; name another folder for {header.shard}")
    elif other := [name for name in LASTING if getattr(before, name) != getattr(header, name)]:
        names = ", ".join(f"--{name.replace('_', '-')}" for name in other)
        message = f"holds shard {before.shard} of a run with another {names}; give the same, or name another folder"
        raise OutputError(root, message)


class Recorder:
    """Narrows a run to a shard and writes down what it finds out; its memory is bounded by the shard's own inputs.

    `count`: inputs of all shards so far. `held`, `surveys`: what files hold and what each input is, by its number.
    """

    def __init__(self, library: Library, header: ShardHeader) -> None:
        self._library, self._header, self._digest = library, header, hashlib.sha256()
        self._found: list[tuple[int, Found]] = []
        self._refused, self._first_refused = RefusedRows(library), dict[str, int]()
        self.count = 0
        self.held: Mapping[int, HeldThings] = {}
        self.surveys: Mapping[int, SurveyAnswer] = {}

    def begin(self) -> None:
        """Write down that the run has begun."""
        write_record(self._library, self._header)

    def own(self, inputs: Iterable[Found | Refused]) -> Iterator[Found | Refused]:
        """The inputs of the shard, while all are counted."""
        for number, one in enumerate(inputs):
            self.count += 1
            said = one.source.to_json() if isinstance(one, Found) else f"{one.path}\0{one.code}\0{one.message}"
            self._digest.update(f"{said}\n".encode())
            if not self._header.shard.has(one):
                continue
            if isinstance(one, Found):
                self._found.append((number, one))
            else:
                self._refused.add(one)
                if len(self._first_refused) < MAX_FILES:
                    self._first_refused.setdefault(one.path, number)
            yield one

    def end(self) -> None:
        """Write down all that was found out."""
        header = self._header.replace(is_complete=True, inputs=self.count, inputs_digest=self.digest)
        write_record(self._library, header, [*self._lines(), *self.refused()])

    @property
    def digest(self) -> str:
        """Digest of the inputs of all shards; of two runs it is the same where the sources are."""
        return self._digest.hexdigest()

    def refused(self) -> Iterator[ShardLine]:
        """A line for each file with refused rows; what only counts comes last."""
        for file in self._refused.files():
            is_other = file.path == OTHER_FILES and file.path not in self._first_refused
            yield ShardLine(number=self.count if is_other else self._first_refused[file.path], refused=file)

    def _lines(self) -> Iterator[ShardLine]:
        """A line for each input; the surveys of its things follow one another."""
        begin = 0
        for place, (number, one) in enumerate(self._found):
            held = self.held.get(place, HeldThings("", ()))
            sha256, things = held.sha256, held.names
            end = begin + (len(things) or 1)
            surveys = tuple(SurveyRecord.of(self.surveys[i]) for i in range(begin, end))
            yield ShardLine(number=number, source=one.source, sha256=sha256, things=things, surveys=surveys)
            begin = end
