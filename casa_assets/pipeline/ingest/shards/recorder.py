"""A run that works on one shard: leaves out the inputs of the others, and writes down what a merge will need."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from casa_assets.errors import OutputError
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.pipeline.ingest.answers import FAILURE_CODES, Answers, SurveyAnswer
from casa_assets.pipeline.ingest.job import Job, Outcome
from casa_assets.pipeline.ingest.shards.record import (
    Discovery,
    ShardHeader,
    ShardLine,
    SurveyRecord,
    read_header,
    write_record,
)
from casa_assets.pipeline.ingest.split import HeldThings
from casa_assets.pipeline.ingest.survey import Survey
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_table import EntryTable
from casa_assets.pipeline.library.identity import Producer
from casa_assets.pipeline.workers.limits import WorkerFailure

# Options that a shard keeps from its first run on. Limits and code may change: what they void is made anew.
LASTING = ("category", "split", "keep_duplicates")


def check_is_no_shard(library: disk.Library) -> None:
    """Check that a run over all inputs may write to a library. Raises OutputError where it is a shard."""
    if (header := read_header(library)) is not None:
        message = f"holds shard {header.shard}; add --shard {header.shard}, or name another folder"
        raise OutputError(str(library.root), message)


class Recorder:
    """Narrows a run to a shard and notes the answers that it gets.

    Args:
        table: the entries of the shard's library. header: of the run that begins.
    Raises:
        OutputError: the library is no shard, or another one, or one of a run with other options.
    """

    def __init__(self, table: EntryTable, header: ShardHeader) -> None:
        self._library, self._header = disk.Library(table.root), header
        self._check(table)
        self._discovery = Discovery(self._library, header.shard)
        self._held: Mapping[int, HeldThings] = {}
        self._surveys: dict[int, SurveyRecord] = {}

    def begin(self) -> None:
        """Write down that the run has begun."""
        write_record(self._library, self._header)

    def own(self, inputs: Iterable[Found | Refused]) -> Iterator[Found | Refused]:
        """The inputs of the shard."""
        return self._discovery.own(inputs)

    def noting(self, answers: Answers) -> Answers:
        """The same answers, which are noted as they are given."""
        return _Noting(answers, self._note_things, self._note_survey)

    def end(self) -> None:
        """Write down all that was noted."""
        known = self._discovery
        header = self._header.replace(is_complete=True, inputs=known.count, inputs_digest=known.digest)
        write_record(self._library, header, [*self._lines(), *known.refused()])

    def _check(self, table: EntryTable) -> None:
        root, header, before = str(table.root), self._header, read_header(self._library)
        if before is None:
            if any(entry.producer == Producer.INGEST.value for entry in table.entries):
                raise OutputError(root, f"holds a library that is no shard; name another folder for {header.shard}")
        elif before.shard != header.shard:
            raise OutputError(root, f"holds shard {before.shard}; name another folder for {header.shard}")
        elif other := [name for name in LASTING if getattr(before, name) != getattr(header, name)]:
            names = ", ".join(f"--{name.replace('_', '-')}" for name in other)
            message = f"holds shard {before.shard} of a run with another {names}; give the same, or name another folder"
            raise OutputError(root, message)

    def _note_things(self, held: Mapping[int, HeldThings]) -> None:
        self._held = held

    def _note_survey(self, number: int, answer: SurveyAnswer) -> None:
        if isinstance(answer, Survey):
            said = SurveyRecord(
                sha256=answer.sha256, category=answer.category, confidence=answer.confidence, reason=answer.reason
            )
        elif isinstance(answer, WorkerFailure):
            said = SurveyRecord(code=FAILURE_CODES[answer.reason], message=answer.text)
        else:
            said = SurveyRecord(code=answer.code, message=answer.message)
        self._surveys[number] = said

    def _lines(self) -> Iterator[ShardLine]:
        """A line for each input; the surveys of its things follow one another."""
        begin = 0
        for place, (number, one) in enumerate(self._discovery.found):
            held = self._held.get(place)
            sha256, things = (held.sha256, held.names) if held is not None and held.names else ("", ())
            end = begin + (len(things) or 1)
            surveys = tuple(self._surveys[i] for i in range(begin, end))
            yield ShardLine(number=number, source=one.source, sha256=sha256, things=things, surveys=surveys)
            begin = end


@dataclass(frozen=True)
class _Noting:
    """Answers that are told to somebody else, too."""

    answers: Answers
    note_things: Callable[[Mapping[int, HeldThings]], None]
    note_survey: Callable[[int, SurveyAnswer], None]

    def things(self, found: Sequence[Found]) -> Mapping[int, HeldThings]:
        """See Answers."""
        held = self.answers.things(found)
        self.note_things(held)
        return held

    def surveys(self, found: Sequence[Found]) -> Iterator[tuple[int, SurveyAnswer]]:
        """See Answers."""
        for number, answer in self.answers.surveys(found):
            self.note_survey(number, answer)
            yield number, answer

    def outcomes(self, jobs: Sequence[Job]) -> Iterator[tuple[int, Outcome]]:
        """See Answers."""
        return self.answers.outcomes(jobs)
