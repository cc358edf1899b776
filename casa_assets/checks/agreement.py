"""Two fact tables -> where they differ, and by how much."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from casa_assets.checks.check import Measured
from casa_assets.checks.facts import BodyFacts, Facts

# Where these differ there is no number to say by how much.
WORDS = ("parent", "colliders")
# Metres, ratios and unit vectors are compared as they are, masses and moments relative to those of the body.
LENGTHS = ("position", "center_of_mass", "lower", "upper")


class Difference(NamedTuple):
    """One cell that differs: where, by how much (None where it is no number), and both values."""

    pointer: str
    size: float | None
    says: str


def agree(expected: Facts, found: Facts, tolerance: float) -> Measured:
    """The largest difference, and a problem for each that exceeds the tolerance."""
    rows = list(differences(expected, found))
    worst = max((r.size for r in rows if r.size is not None), default=0.0)
    faults = [(r.pointer, r.says) for r in rows if r.size is None or not r.size <= tolerance]
    return Measured(worst, tuple(faults))


def differences(expected: Facts, found: Facts) -> Iterator[Difference]:
    """Every cell, row by row; cells of words only where they differ."""
    for name in ("base", "exclusions", "classes"):
        yield from _word(name, getattr(expected, name), getattr(found, name))
    ours, theirs = ({b.name: b for b in table.bodies} for table in (expected, found))
    yield from _word("bodies", sorted(ours), sorted(theirs))
    for name in sorted(ours.keys() & theirs.keys()):
        yield from _body(ours[name], theirs[name])


def _body(ours: BodyFacts, theirs: BodyFacts) -> Iterator[Difference]:
    at = f"bodies/{ours.name}"
    for name in WORDS:
        yield from _word(f"{at}/{name}", getattr(ours, name), getattr(theirs, name))
    for name in LENGTHS:
        yield _number(f"{at}/{name}", getattr(ours, name), getattr(theirs, name))
    # q and -q are one rotation; which sign is canonical can flip where w is near zero.
    turned = float(np.dot(ours.quaternion, theirs.quaternion)) < 0
    yield _number(f"{at}/quaternion", ours.quaternion, [-q if turned else q for q in theirs.quaternion])
    yield _number(f"{at}/mass", (ours.mass,), (theirs.mass,), ours.mass)
    yield _number(f"{at}/inertia", ours.inertia, theirs.inertia, sum(ours.inertia[:3]))
    if len(ours.frictions) == len(theirs.frictions):
        yield _number(f"{at}/frictions", np.ravel(ours.frictions), np.ravel(theirs.frictions))
    else:
        yield from _word(f"{at}/frictions", ours.frictions, theirs.frictions)
    yield from _joint(f"{at}/joint", ours, theirs)


def _joint(at: str, ours: BodyFacts, theirs: BodyFacts) -> Iterator[Difference]:
    a, b = ours.joint, theirs.joint
    if a is None or b is None:
        yield from _word(at, a and a.name, b and b.name)
        return
    yield from _word(f"{at}/name", a.name, b.name)
    yield from _word(f"{at}/kind", a.kind, b.kind)
    for name in ("axis", "anchor", "range"):
        yield _number(f"{at}/{name}", getattr(a, name), getattr(b, name))


def _word(at: str, ours: object, theirs: object) -> Iterator[Difference]:
    if ours != theirs:
        yield Difference(at, None, f"is {theirs!s}, should be {ours!s}")


def _number(at: str, ours: object, theirs: object, scale: float = 1.0) -> Difference:
    a, b = np.asarray(ours, dtype=np.float64), np.asarray(theirs, dtype=np.float64)
    size = float(np.abs(a - b).max(initial=0.0)) / scale
    return Difference(at, size, f"is {_text(b)}, should be {_text(a)}")


def _text(values: np.ndarray) -> str:
    return " ".join(f"{v:.6g}" for v in values.ravel())
