"""Find the digest and the category of an input before any work, and the things in a file; runs on every input."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from casa_assets import registry
from casa_assets.cache.cache_key import key_of
from casa_assets.core.system import keep_json, kept_json
from casa_assets.errors import Rejected
from casa_assets.ingest.sources.bundle import collect
from casa_assets.ingest.sources.places import Found, is_url
from casa_assets.ingest.sources.stores import state_at
from casa_assets.library.review import DOUBTFUL
from casa_assets.model.registry.category import Category
from casa_assets.runs.limits import WorkerFailure
from casa_assets.runs.pool import Engine

# Confidence in a category that the source itself states; of 98 such in data for developing none was wrong.
SAID_CONFIDENCE = 0.98
# Largest confidence in a category from a name if the source states another one, so that a person looks at it.
CONTRADICTED_CONFIDENCE = 0.4


@dataclass(frozen=True)
class Survey:
    """Digest of an input and its category, with the confidence, 0..1, and the reason.

    `looked_at`: files and folders that decided it, with their `state_of`.
    """

    sha256: str
    category: str
    confidence: float
    reason: str
    looked_at: tuple[tuple[str, str], ...] = ()


def state_of(path: str) -> str:
    """State of a file, folder or object on a store, which changes whenever it is written; empty if there is none."""
    if is_url(path):
        return state_at(path)
    try:
        found = os.stat(path)  # noqa: PTH116  Path would take longer than the system does
    except (OSError, ValueError):
        return ""
    return f"{found.st_mtime_ns} {found.st_ctime_ns} {found.st_size} {found.st_ino}"


def warm() -> None:
    """Load what every survey needs, once for all workers."""
    registry.load()


def survey(job: tuple[Found, str, Mapping[str, float]]) -> Survey | Rejected:
    """Survey of an input. The job is the input, the category that the user requested or nothing, and the limits."""
    found, requested, limits = job
    looked_at: set[str] = set()
    try:
        bundle = collect(found, limits, looked_at)
    except Rejected as error:
        return error
    category, confidence, reason = find_category(found, requested)
    states = tuple((path, state_of(path)) for path in sorted(looked_at))
    return Survey(bundle.sha256, category.id, confidence, reason, states)


def find_category(found: Found, requested: str) -> tuple[Category, float, str]:
    """Category of an input, confidence and reason: by the user, else by the source, else by names and titles."""
    known = registry.load()
    if requested:
        return known.category(requested), 1.0, "given on the command line"
    source = found.source
    if source.node:  # The name and title of the file speak of all things in it together.
        named = known.find_category([source.node])
        if named is not None:
            return named
        return known.category(registry.FALLBACK), 0.1, f"{source.node!r} names no category that the registry knows"
    if source.category:
        match = known.find_category([source.category])
        if match is not None:
            return match[0], max(SAID_CONFIDENCE, match[1]), f"the source says {source.category!r}"
    match = known.find_category([*source.hints, source.title, source.prompt])
    if match is not None and source.category:
        reason = f"{match[2]}; the source says {source.category!r}, which the registry does not know"
        return match[0], min(CONTRADICTED_CONFIDENCE, match[1]), reason
    if match is not None:
        return match[0], match[1], match[2]
    return known.category(registry.FALLBACK), 0.1, "nothing names a category that the registry knows"


@dataclass(frozen=True)
class HeldThings:
    """Names of the things that an input holds, and the digest of its files; a single thing has no name."""

    sha256: str
    names: tuple[str, ...]


def things_held(job: tuple[Found, Mapping[str, float]]) -> HeldThings | None:
    """Return the separate objects of an input, or None if it cannot be read, which the survey of the run reports.

    None too if the input is more probably one object: the boards of a shelf and the legs of a table are not separate
    objects.
    """
    # Here, since most runs take nothing apart, and this loads slowly.
    from casa_assets.ingest.things import guess_of_things, load, things_of

    found, limits = job
    known = registry.load()
    try:
        bundle = collect(found, limits)
        model = load(bundle, limits)
        category, _, _ = find_category(found, "")
        guess = guess_of_things(model, found.source, category, known.vocabulary, known.other_things)
        if guess is None or guess.confidence >= DOUBTFUL:
            return None
        taken = things_of(model).taken
    except Rejected:
        return None
    return HeldThings(bundle.sha256, tuple(thing.name for thing in taken) if len(taken) > 1 else ())


def taken_apart(found: Sequence[Found], held: Mapping[int, HeldThings]) -> tuple[list[Found], list[str]]:
    """The inputs with the things of a file in its place, by number of input, and the digests of files taken apart."""
    out: list[Found] = []
    digests: list[str] = []
    for number, one in enumerate(found):
        answer = held.get(number)
        if answer is None or not answer.names:
            out.append(one)
            continue
        digests.append(answer.sha256)
        out += [replace(one, source=one.source.replace(node=name)) for name in answer.names]
    return out, digests


SurveyAnswer = Survey | Rejected | WorkerFailure


# Survey table ---------------------------------------------------------------------------------------------------------
# What earlier runs found out about inputs whose files have not changed since, so that they are not read again.
#
# It lies in the cache of the library, and deleting it costs time and nothing else.

NAME = "surveys"
# A file that is younger than this when it is read may change again without a trace in its times, which come in steps.
MIN_AGE_NS = 50_000_000


class SurveyTable:
    """Surveys by input, in the cache folder; `requested`: category for all inputs, or empty.

    Of the limits of the run those on the bytes of an input count.
    """

    def __init__(self, cache: Path, requested: str, limits: Mapping[str, float], read_only: bool = False) -> None:
        self._path, self._read_only = cache / NAME, read_only
        self._made_by = key_of(survey)
        self._requested, self._limits = requested, limits
        self._said = f"{requested}\0{limits['input_bytes']}"
        kept = kept_json(self._path)
        is_ours = isinstance(kept, dict) and kept.get("made_by") == self._made_by
        self._kept: dict[str, Any] = kept["surveys"] if is_ours else {}

    def survey(self, inputs: Sequence[Found], pool: Engine) -> Iterator[tuple[int, Survey | Rejected | WorkerFailure]]:
        """Yield number and survey of every input, the known ones first; what is new is kept at the end.

        The workers of the pool read what is new. Those surveys alone have `looked_at`.
        """
        new: list[int] = []
        for number, one in enumerate(inputs):
            if (known := self.find(one)) is not None:
                yield number, known
            else:
                new.append(number)
        fresh: list[tuple[Found, Survey]] = []
        jobs = [(inputs[number], self._requested, self._limits) for number in new]
        for place, answer in pool.run(survey, jobs):
            if isinstance(answer, Survey):
                fresh.append((inputs[new[place]], answer))
            yield new[place], answer
        self.keep(fresh)

    def find(self, found: Found) -> Survey | None:
        """Return the survey of an earlier run if no file has changed since, or None otherwise."""
        known = self._kept.get(self._key(found))
        if known is None or found.is_model:
            return None
        try:
            sha256, category, confidence, reason, looked_at = known
            if all(state_of(path) == state for path, state in looked_at):
                return Survey(sha256, category, confidence, reason)
        except (ValueError, TypeError):
            pass  # not what was written there: it is read again
        return None

    def keep(self, surveys: Iterable[tuple[Found, Survey]]) -> None:
        """Keep what was found out now, but for files that are so young that they may still change unseen."""
        newest = time.time_ns() - MIN_AGE_NS
        fresh = {
            self._key(found): (one.sha256, one.category, one.confidence, one.reason, one.looked_at)
            for found, one in surveys
            if not found.is_model and all(_is_settled(state, newest) for _, state in one.looked_at)
        }
        if fresh and not self._read_only:
            keep_json(self._path, {"made_by": self._made_by, "surveys": {**self._kept, **fresh}})

    def _key(self, found: Found) -> str:
        """Key of an input: its place, and what its source says of it."""
        notes = [note.to_json() for note in found.notes]
        said = f"{self._said}\0{found.root}\0{found.archive}\0{found.main}\0{found.source.to_json()}\0{notes}"
        return hashlib.sha256(said.encode("utf-8", "surrogateescape")).hexdigest()


def _is_settled(state: str, newest_ns: int) -> bool:
    """Return whether any later change would change a state: a file's last one was before a time, ns since 1970.

    A store gives each object a tag or a time, or nothing that would change with it (`?`).
    """
    return not state or state.startswith("store ") or (state != "?" and int(state.split()[1]) < newest_ns)
