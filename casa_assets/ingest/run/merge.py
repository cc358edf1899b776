"""Join the libraries of shards into the one that a single run over all inputs would have made.

A merge is such a run: the inputs come in the order of their discovery, the same bytes and copies are found in that
order, entries are published one by one, and what the library holds from earlier runs counts. It differs in who
answers its questions: the records of the shards, and the entries that they made, which are linked or copied.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from casa_assets import registry
from casa_assets.errors import OutputError
from casa_assets.ingest.run.inputs import HeldThings, Job, Survey, SurveyAnswer
from casa_assets.ingest.run.run import Options, cache_key, ingest_inputs
from casa_assets.ingest.run.shards import ShardLine, ShardRecord, check_is_no_shard, index_of, made_by, read_record
from casa_assets.ingest.sources.places import Found
from casa_assets.library import clip, review
from casa_assets.library.entry import is_below
from casa_assets.library.entry_files import (
    CERTIFICATE,
    PICTURE,
    REFUSAL,
    Identity,
    Producer,
    file_inside,
    picture_of,
    read_manifest,
    read_refusal,
)
from casa_assets.library.entry_table import EntryTable, stream_entries
from casa_assets.library.library import REJECTED, Library
from casa_assets.library.library_report import write_reports
from casa_assets.model.issue import Severity
from casa_assets.runs.engine import open_library
from casa_assets.runs.outcome import Event, Outcome

# What all shards of one run have in common, and what to say where they do not.
COMMON = {
    "count": "is one of another number of shards",
    "category": "was made with another --category",
    "split": "was made with another --split",
    "keep_duplicates": "was made with another --keep-duplicates",
    "limits": "was made with other limits on inputs",
    "cache_key": "was made by another version of casa-assets",
    "made_by": "was made by another version of casa-assets",
    "inputs_digest": "found other inputs, because the sources have changed in between,",
}
# Missing shards that are named.
MAX_NAMED = 8


def check_shards(records: Sequence[ShardRecord], cache_key: str, is_partial: bool) -> None:
    """Check that shards are of one run, and of this program: its `cache_key`. Raises OutputError: not so, or lost."""
    first = records[0]
    seen: dict[int, Path] = {}
    for record in records:
        root, header = record.library.root, record.header
        for name, words in COMMON.items():
            if getattr(header, name) != getattr(first.header, name):
                message = f"{words} than {first.library.root}; run all shards again, with the same options"
                raise OutputError(str(root), message)
        if header.index in seen:
            raise OutputError(str(root), f"holds shard {header.shard}, as {seen[header.index]} does; name one of them")
        seen[header.index] = root
    if (first.header.cache_key, first.header.made_by) != (cache_key, made_by()):
        message = "was made by another version of casa-assets; merge with that one, or run all shards again"
        raise OutputError(str(first.library.root), message)
    header, place = first.header, str(first.library.root)
    missing = sorted(set(range(1, header.count + 1)) - {record.header.index for record in records})
    if missing and not is_partial:
        few = ", ".join(f"{index}/{header.count}" for index in missing[:MAX_NAMED])
        more = f" and {len(missing) - MAX_NAMED} more" if len(missing) > MAX_NAMED else ""
        message = f"is one of {header.count} shards, and these are missing: {few}{more}; name them too, or --partial"
        raise OutputError(place, message)
    lines = [line for record in records for line in record.lines]
    numbers = {line.number for line in lines if line.source is not None}
    rows = sum(sum(line.refused.counts.values()) for line in lines if line.refused is not None)
    count = sum(line.source is not None for line in lines)
    if count != len(numbers) or (not missing and count + rows != header.inputs):
        raise OutputError(place, f"the shards hold {count + rows} of {header.inputs} inputs; run all of them again")


def merge(
    shards: Sequence[Path], library: Path, is_partial: bool = False, weights: str = ""
) -> Generator[Event, None, None]:
    """Merge shards into a library; yields an Event for each input. Killed at any moment and run again, it goes on.

    Args:
        is_partial: shards may be missing; their inputs are left out.
        weights: of CLIP, for the checks on the whole library, see `Options`.
    Raises:
        OutputError: shards are missing, unfinished or damaged, do not belong together, or were made by another version
            of this program; people decided otherwise about an input; or the library cannot be written to.
    """
    if weights:
        clip.require_weights(weights)
    known = registry.load()
    records = [read_record(Library(shard), known.categories) for shard in shards]
    first = records[0].header
    check_shards(records, cache_key({**known.limits, **first.limits}, first.category), is_partial)
    options = Options(
        library,
        category=first.category,
        guards=first.limits,
        weights=weights,
        keep_duplicates=first.keep_duplicates,
        split=first.split,
    )
    place = Library(library)
    check_is_no_shard(place)
    with ExitStack() as stack:
        open_library(place, stack)
        review.adopt(place, [record.library for record in records])
        table = EntryTable(place, skip_damaged=True)
        lines = sorted(((line, record) for record in records for line in record.lines), key=lambda one: one[0].number)
        inputs = (one for line, _ in lines for one in line.inputs)
        indices, roots = {record.header.index for record in records}, [Path(root) for root in first.roots]

        def is_looked_at(path: str) -> bool:
            """True for a file of one of the shards that still exists below the roots of their sources."""
            return index_of(path, first.count) in indices and is_below(roots, path)

        yield from ingest_inputs(place, table, inputs, ShardAnswers(place, lines), options, is_looked_at)
        write_reports(place, weights, table)


class ShardAnswers:
    """Answers of shards: what their runs noted, in the order of discovery, and the entries that they made."""

    def __init__(self, library: Library, lines: Sequence[tuple[ShardLine, ShardRecord]]) -> None:
        self._library = library
        self._inputs = [(line, record.library) for line, record in lines if line.source is not None]
        # The shard that worked on the first input of these bytes. None of the others is asked for them.
        self._made_in: dict[str, Library] = {}

    def things(self, found: Sequence[Found]) -> dict[int, HeldThings]:
        """See Answers."""
        held = {number: line.held for number, (line, _) in enumerate(self._inputs)}
        return {number: things for number, things in held.items() if things is not None}

    def surveys(self, found: Sequence[Found]) -> Iterator[tuple[int, SurveyAnswer]]:
        """See Answers."""
        said = ((one.answer, shard) for line, shard in self._inputs for one in line.surveys)
        for number, (answer, shard) in enumerate(said):
            if isinstance(answer, Survey):
                self._made_in.setdefault(answer.sha256, shard)
            yield number, answer

    def outcomes(self, jobs: Sequence[Job]) -> Iterator[tuple[int, Outcome]]:
        """See Answers. Raises OutputError where a shard lacks the entry of an input; nothing is published then."""
        keys: dict[Path, dict[str, str]] = {}  # for each shard, of every whole entry that ingest made, by its path
        for shard in {shard.root: shard for shard in self._made_in.values()}.values():
            entries = stream_entries(shard, skip_damaged=True, read_only=True)
            made = (entry for entry in entries if entry.is_whole and entry.producer == Producer.INGEST)
            keys[shard.root] = {entry.path: entry.cache_key for entry in made}
        folders = [self._folder(job, keys[self._made_in[job.survey.sha256].root]) for job in jobs]
        for number, (job, folder) in enumerate(zip(jobs, folders, strict=True)):
            yield number, self._staged(job, folder)

    def _folder(self, job: Job, keys: dict[str, str]) -> Path:
        root, path = self._made_in[job.survey.sha256].root, job.found.source.place
        places = (f"{job.survey.category}/{job.asset_id}", f"{REJECTED}/{job.asset_id}")
        for place in places:
            if keys.get(place) == job.cache_key:
                return root / place
        if not job.override.is_empty or any(place in keys for place in places):
            message = f"has not worked on {path} since a person decided about it in {review.NAME}"
            raise OutputError(str(root), f"{message}; copy {self._library.root / review.NAME} there, run it again")
        raise OutputError(str(root), f"holds no whole entry of {path}; run this shard again")

    def _staged(self, job: Job, folder: Path) -> Outcome:
        """The outcome of an input with a copy of its entry. Raises OutputError where the entry is another's."""
        wanted = Identity(Producer.INGEST, job.survey.sha256)
        if folder.parent.name == REJECTED:
            refusal = read_refusal(folder)
            _check_identity(folder, Identity(refusal.producer, refusal.sha256), wanted)
            picture = {PICTURE: ""} if picture_of(folder) else {}
            staged = _copied(folder, self._library, {REFUSAL: "", **picture})
            return Outcome(False, refusal.code, refusal.message, staged=staged)
        manifest = read_manifest(folder)
        _check_identity(folder, manifest.identity, wanted)
        staged = _copied(folder, self._library, {CERTIFICATE: "", **manifest.certificate.files})
        warnings = tuple(i for i in manifest.certificate.report.issues if i.severity is Severity.WARNING)
        # What is asked about the entry from here on is answered by what was read once.
        return Outcome(True, warnings=warnings, staged=staged, manifest=replace(manifest, folder=staged))


def _check_identity(folder: Path, found: Identity | None, wanted: Identity) -> None:
    if found != wanted:
        raise OutputError(str(folder), "is not what was made of its input; remove it and run the shard again")


def _copied(folder: Path, library: Library, digests: Mapping[str, str]) -> Path:
    """The copy of an entry in the staging folder, by hard links where the file system has them.

    A file that is copied byte by byte is compared with its digest; one that is linked is not read. `digests`: sha256 of
    the files by their path in the entry; empty where it is not known. Raises OutputError: a file is missing, damaged,
    or no regular file inside the entry.
    """
    staged = library.stage(folder.name)
    for name, digest in digests.items():
        source = file_inside(folder, name, folder, "files")
        if source.is_symlink():  # within the entry: it becomes a file
            source = source.resolve()
        target = staged / name
        if "/" in name:
            target.parent.mkdir(parents=True, exist_ok=True)
        try:
            os.link(source, target)
        except OSError:  # another file system, one without hard links, or a file of somebody else
            data = source.read_bytes()
            if digest and hashlib.sha256(data).hexdigest() != digest:
                message = "is not what the certificate says; copy the shard again, or run it again"
                raise OutputError(str(folder / name), message) from None
            target.write_bytes(data)
    return staged
