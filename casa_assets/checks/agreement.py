"""Two fact tables -> where they differ, and by how much."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from casa_assets.checks.check import Measured
from casa_assets.checks.facts import BodyFacts, Facts, JointFacts, LookFacts, PlaceFacts, PoseFacts, Words

# Where these differ there is no number to say by how much.
WORDS = ("parent", "colliders")
# Metres, ratios and unit vectors are compared as they are, masses and moments relative to those of the body.
LENGTHS = ("position", "center_of_mass", "lower", "upper")
TOLD = ("classes", "labels", "grips", "behind", "contract", "behavior")


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
    for name in ("base", "exclusions"):
        yield from _word(name, getattr(expected, name), getattr(found, name))
    yield from _words(expected.words, found.words)
    bodies = {body.name: body for body in found.bodies}
    yield from _word("bodies", sorted(b.name for b in expected.bodies), sorted(bodies))
    for body in sorted(expected.bodies, key=lambda b: b.name):
        if body.name in bodies:
            yield from _body(body, bodies[body.name])
    places = {place.name: place for place in found.places}
    yield from _word("places", sorted(p.name for p in expected.places), sorted(places))
    for place in expected.places:
        if place.name in places:
            yield from _place(place, places[place.name])
    looks = {look.name: look for look in found.looks}
    yield from _word("looks", sorted(look.name for look in expected.looks), sorted(looks))
    for look in expected.looks:
        if look.name in looks:
            yield from _look(look, looks[look.name])
    poses = {pose.name: pose for pose in found.poses}
    yield from _word("poses", sorted(p.name for p in expected.poses), sorted(poses))
    for pose in expected.poses:
        if pose.name in poses:
            yield from _pose(pose, poses[pose.name])


def ratio(ours: np.ndarray, theirs: np.ndarray) -> float:
    """The largest difference of two arrays of one shape, each relative to the larger of its two numbers."""
    scale = np.maximum(np.maximum(np.abs(ours), np.abs(theirs)), 1e-12)
    return float((np.abs(ours - theirs) / scale).max(initial=0.0))


def _body(ours: BodyFacts, theirs: BodyFacts) -> Iterator[Difference]:
    at = f"bodies/{ours.name}"
    for name in WORDS:
        yield from _word(f"{at}/{name}", getattr(ours, name), getattr(theirs, name))
    for name in LENGTHS:
        yield _number(f"{at}/{name}", getattr(ours, name), getattr(theirs, name))
    yield _turned(f"{at}/quaternion", ours.quaternion, theirs.quaternion)
    yield _number(f"{at}/mass", (ours.mass,), (theirs.mass,), ours.mass)
    yield _number(f"{at}/inertia", ours.inertia, theirs.inertia, sum(ours.inertia[:3]))
    if len(ours.frictions) == len(theirs.frictions):
        yield _number(f"{at}/frictions", np.ravel(ours.frictions), np.ravel(theirs.frictions))
    else:
        yield from _word(f"{at}/frictions", ours.frictions, theirs.frictions)
    yield from _joint(f"{at}/joint", ours.joint, theirs.joint)


def _joint(at: str, a: JointFacts | None, b: JointFacts | None) -> Iterator[Difference]:
    if a is None or b is None:
        yield from _word(at, a and a.name, b and b.name)
        return
    yield from _word(f"{at}/name", a.name, b.name)
    yield from _word(f"{at}/kind", a.kind, b.kind)
    for name in ("axis", "anchor", "range"):
        yield _number(f"{at}/{name}", getattr(a, name), getattr(b, name))
    ours, theirs = np.array(a.resistance), np.array(b.resistance)
    yield Difference(f"{at}/resistance", ratio(ours, theirs), f"is {_text(theirs)}, should be {_text(ours)}")


def _place(ours: PlaceFacts, theirs: PlaceFacts) -> Iterator[Difference]:
    at = f"places/{ours.name}"
    yield from _word(f"{at}/body", ours.body, theirs.body)
    yield from _word(f"{at}/kind", ours.kind, theirs.kind)
    yield _number(f"{at}/position", ours.position, theirs.position)
    yield _turned(f"{at}/quaternion", ours.quaternion, theirs.quaternion)
    yield _number(f"{at}/size", ours.size, theirs.size)
    if ours.color is None or theirs.color is None:
        yield from _word(f"{at}/color", ours.color, theirs.color)
    else:
        yield _number(f"{at}/color", ours.color, theirs.color)


def _look(ours: LookFacts, theirs: LookFacts) -> Iterator[Difference]:
    at = f"looks/{ours.name}"
    yield _number(f"{at}/color", ours.color, theirs.color)
    yield _number(f"{at}/light", ours.light, theirs.light)
    yield from _word(f"{at}/picture", ours.picture, theirs.picture)


def _pose(ours: PoseFacts, theirs: PoseFacts) -> Iterator[Difference]:
    at = f"poses/{ours.name}"
    if ours.bodies != theirs.bodies:
        yield from _word(f"{at}/bodies", ours.bodies, theirs.bodies)
        return
    for i, body in enumerate(ours.bodies):
        yield _number(f"{at}/{body}/position", ours.positions[i], theirs.positions[i])
        yield _turned(f"{at}/{body}/quaternion", ours.quaternions[i], theirs.quaternions[i])


def _words(ours: Words, theirs: Words) -> Iterator[Difference]:
    for name in TOLD:
        yield from _word(name, getattr(ours, name), getattr(theirs, name))
    a, b = ([(s.name, s.joint, s.value) for s in words.states] for words in (ours, theirs))
    yield from _word("states", a, b)
    if a == b:
        for one, other in zip(ours.states, theirs.states, strict=True):
            yield _number(f"states/{one.name}/interval", one.interval, other.interval)


def _word(at: str, ours: object, theirs: object) -> Iterator[Difference]:
    if ours != theirs:
        yield Difference(at, None, f"is {theirs!s}, should be {ours!s}")


def _turned(at: str, ours: object, theirs: object) -> Difference:
    """q and -q are one rotation; which sign is canonical can flip where w is near zero."""
    a, b = np.asarray(ours, dtype=np.float64), np.asarray(theirs, dtype=np.float64)
    return _number(at, a, -b if float(a @ b) < 0 else b)


def _number(at: str, ours: object, theirs: object, scale: float = 1.0) -> Difference:
    a, b = np.asarray(ours, dtype=np.float64), np.asarray(theirs, dtype=np.float64)
    size = float(np.abs(a - b).max(initial=0.0)) / scale
    return Difference(at, size, f"is {_text(b)}, should be {_text(a)}")


def _text(values: np.ndarray) -> str:
    return " ".join(f"{v:.6g}" for v in values.ravel())
