"""Find the things that inputs hold and put each in the place of its file, for a run that takes files apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from casa_assets import registry
from casa_assets.errors import Rejected
from casa_assets.ingest.run.survey import find_category
from casa_assets.ingest.sources.bundle import collect
from casa_assets.ingest.sources.found import Found
from casa_assets.ingest.things import load
from casa_assets.library.review import DOUBTFUL


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
    from casa_assets.ingest.things import guess_of_things, things_of

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
