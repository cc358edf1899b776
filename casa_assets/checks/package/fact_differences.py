"""Compare two fact tables cell by cell."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from casa_assets.checks.check import Measurement
from casa_assets.checks.package.facts import (
    AssetFacts,
    BodyFacts,
    JointFacts,
    PlaceFacts,
    PoseFacts,
    ProgramTexts,
    VisualFacts,
)

# Where these differ there is no number to say by how much.
WORDS = ("parent", "colliders")
# Metres, ratios and unit vectors are compared as they are, masses and moments relative to those of the body.
LENGTHS = ("position", "center_of_mass", "lower", "upper")
TOLD = ("classes", "labels", "grips", "behind", "contract", "behavior")


class Difference(NamedTuple):
    """One cell that differs: where, by how much (None where it is no number), and both values."""

    pointer: str
    size: float | None
    message: str


def agree(expected: AssetFacts, found: AssetFacts, tolerance: float) -> Measurement:
    """The largest difference, and a problem for each that exceeds the tolerance."""
    rows = list(differences(expected, found))
    worst = max((r.size for r in rows if r.size is not None), default=0.0)
    faults = [(r.pointer, r.message) for r in rows if r.size is None or not r.size <= tolerance]
    return Measurement(worst, tuple(faults))


def differences(expected: AssetFacts, found: AssetFacts) -> Iterator[Difference]:
    """Every cell, row by row; cells of words only where they differ."""
    for name in ("base", "exclusions"):
        yield from word(name, getattr(expected, name), getattr(found, name))
    yield from words(expected.words, found.words)
    bodies = {body.name: body for body in found.bodies}
    yield from word("bodies", sorted(b.name for b in expected.bodies), sorted(bodies))
    for body in sorted(expected.bodies, key=lambda b: b.name):
        if body.name in bodies:
            yield from _body(body, bodies[body.name])
    places = {place.name: place for place in found.places}
    yield from word("places", sorted(p.name for p in expected.places), sorted(places))
    for place in expected.places:
        if place.name in places:
            yield from _place(place, places[place.name])
    looks = {look.name: look for look in found.looks}
    yield from word("looks", sorted(look.name for look in expected.looks), sorted(looks))
    for look in expected.looks:
        if look.name in looks:
            yield from _look(look, looks[look.name])
    poses = {pose.name: pose for pose in found.poses}
    yield from word("poses", sorted(p.name for p in expected.poses), sorted(poses))
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
        yield from word(f"{at}/{name}", getattr(ours, name), getattr(theirs, name))
    for name in LENGTHS:
        yield number(f"{at}/{name}", getattr(ours, name), getattr(theirs, name))
    yield turned(f"{at}/quaternion", ours.quaternion, theirs.quaternion)
    yield number(f"{at}/mass", (ours.mass,), (theirs.mass,), ours.mass)
    yield number(f"{at}/inertia", ours.inertia, theirs.inertia, sum(ours.inertia[:3]))
    if len(ours.frictions) == len(theirs.frictions):
        yield number(f"{at}/frictions", np.ravel(ours.frictions), np.ravel(theirs.frictions))
    else:
        yield from word(f"{at}/frictions", ours.frictions, theirs.frictions)
    yield from _joint(f"{at}/joint", ours.joint, theirs.joint)


def _joint(at: str, a: JointFacts | None, b: JointFacts | None) -> Iterator[Difference]:
    if a is None or b is None:
        yield from word(at, a and a.name, b and b.name)
        return
    yield from word(f"{at}/name", a.name, b.name)
    yield from word(f"{at}/kind", a.kind, b.kind)
    for name in ("axis", "anchor", "range"):
        yield number(f"{at}/{name}", getattr(a, name), getattr(b, name))
    ours, theirs = np.array(a.resistance), np.array(b.resistance)
    yield Difference(f"{at}/resistance", ratio(ours, theirs), f"is {_text(theirs)}, should be {_text(ours)}")


def _place(ours: PlaceFacts, theirs: PlaceFacts) -> Iterator[Difference]:
    at = f"places/{ours.name}"
    yield from word(f"{at}/body", ours.body, theirs.body)
    yield from word(f"{at}/kind", ours.kind, theirs.kind)
    yield number(f"{at}/position", ours.position, theirs.position)
    yield turned(f"{at}/quaternion", ours.quaternion, theirs.quaternion)
    yield number(f"{at}/size", ours.size, theirs.size)
    if ours.color is None or theirs.color is None:
        yield from word(f"{at}/color", ours.color, theirs.color)
    else:
        yield number(f"{at}/color", ours.color, theirs.color)


def _look(ours: VisualFacts, theirs: VisualFacts) -> Iterator[Difference]:
    at = f"looks/{ours.name}"
    yield number(f"{at}/color", ours.color, theirs.color)
    yield number(f"{at}/light", ours.light, theirs.light)
    yield from word(f"{at}/picture", ours.picture, theirs.picture)


def _pose(ours: PoseFacts, theirs: PoseFacts) -> Iterator[Difference]:
    at = f"poses/{ours.name}"
    if ours.bodies != theirs.bodies:
        yield from word(f"{at}/bodies", ours.bodies, theirs.bodies)
        return
    for i, body in enumerate(ours.bodies):
        yield number(f"{at}/{body}/position", ours.positions[i], theirs.positions[i])
        yield turned(f"{at}/{body}/quaternion", ours.quaternions[i], theirs.quaternions[i])


def words(ours: ProgramTexts, theirs: ProgramTexts) -> Iterator[Difference]:
    """Differences of the texts that programs read."""
    for name in TOLD:
        yield from word(name, getattr(ours, name), getattr(theirs, name))
    a, b = ([(s.name, s.joint, s.value) for s in words.states] for words in (ours, theirs))
    yield from word("states", a, b)
    if a == b:
        for one, other in zip(ours.states, theirs.states, strict=True):
            yield number(f"states/{one.name}/interval", one.interval, other.interval)


def word(at: str, ours: object, theirs: object) -> Iterator[Difference]:
    """A cell that is no number, where it differs."""
    if ours != theirs:
        yield Difference(at, None, f"is {theirs!s}, should be {ours!s}")


def turned(at: str, ours: object, theirs: object) -> Difference:
    """q and -q are one rotation; which sign is canonical can flip where w is near zero."""
    a, b = np.asarray(ours, dtype=np.float64), np.asarray(theirs, dtype=np.float64)
    return number(at, a, -b if float(a @ b) < 0 else b)


def number(at: str, ours: object, theirs: object, scale: float = 1.0) -> Difference:
    """A cell of numbers: the largest difference, over `scale`."""
    a, b = np.asarray(ours, dtype=np.float64), np.asarray(theirs, dtype=np.float64)
    size = float(np.abs(a - b).max(initial=0.0)) / scale
    return Difference(at, size, f"is {_text(b)}, should be {_text(a)}")


def _text(values: np.ndarray) -> str:
    return " ".join(f"{v:.6g}" for v in values.ravel())
