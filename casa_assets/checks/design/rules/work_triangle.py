"""Measure the work triangle of sink, cooktop and refrigerator, and the obstacles on it."""

from __future__ import annotations

import itertools
import math

import numpy as np

from casa_assets.checks.design.rules.frontage import COOKTOPS
from casa_assets.geometry.planar import length_inside, outline_of
from casa_assets.model.kitchen.floor import Fixture, KitchenFacts, PlacedRun, Role
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.record import Vec2

TALL = 1.5  # metres
FULL_DEPTH = 0.5


def centres(facts: KitchenFacts) -> list[tuple[Fixture, Vec2]]:
    """The first sink, cooktop and refrigerator, and the middles of their fronts."""
    found = []
    for roles in ((Role.SINK,), COOKTOPS, (Role.FRIDGE,)):
        first = next(iter(facts.with_role(*roles)), None)
        if first is not None:
            found.append((first, first.footprint.at(0.0, 0.0)))
    return found


def legs(facts: KitchenFacts) -> list[tuple[Vec2, Vec2]]:
    """Straight ways between them, three where all are there."""
    points = [p for _, p in centres(facts)]
    return list(itertools.combinations(points, 2)) if len(points) == 3 else []


def total(facts: KitchenFacts) -> float | None:
    """Metres round the triangle."""
    return sum(math.dist(a, b) for a, b in legs(facts)) if legs(facts) else None


def shortest(facts: KitchenFacts) -> float | None:
    """Metres of the shortest leg."""
    return min((math.dist(a, b) for a, b in legs(facts)), default=None)


def longest(facts: KitchenFacts) -> float | None:
    """Metres of the longest leg."""
    return max((math.dist(a, b) for a, b in legs(facts)), default=None)


def cut(facts: KitchenFacts) -> float | None:
    """Metres of a leg that lie across an island or a peninsula, the most; None where there is neither."""
    runs = [r for r in facts.runs if not r.at_wall and r.units]
    own = {f.run for f, _ in centres(facts)}
    crossed = [length_inside(_outline(r), a, b) for r in runs if r.id not in own for a, b in legs(facts)]
    return max(crossed, default=None)


def _outline(run: PlacedRun) -> np.ndarray:
    left, right = run.span
    corners = [run.at(u, v) for u in (left, right) for v in (-run.depth_behind, run.depth_before)]
    return outline_of(corners)


def tall_between(facts: KitchenFacts) -> float | None:
    """Tall units of full depth between two of the three in one run."""
    if not legs(facts):
        return None
    count = 0
    for run in facts.runs:
        us = sorted(run.to_local(p)[0] for f, p in centres(facts) if f.run == run.id)
        own = {f.unit for f, _ in centres(facts)}
        for a, b in itertools.pairwise(us):
            inner = [u for u in run.units if u.left > a and u.right < b and u.name not in own]
            count += sum(1 for u in inner if u.height > TALL and u.front > FULL_DEPTH)
    return float(count)


def crossed(facts: KitchenFacts) -> float | None:
    """Metres of a straight way from door to door inside the triangle, the most; None with fewer than two doors."""
    doors = [w for w in facts.openings if w.kind is not OpeningKind.WINDOW and w.leads_out]
    points = [p for _, p in centres(facts)]
    if len(doors) < 2 or len(points) < 3:
        return None
    middles = [((w.start[0] + w.end[0]) / 2, (w.start[1] + w.end[1]) / 2) for w in doors]
    triangle = outline_of(points)
    return (
        max(length_inside(triangle, a, b) for a, b in itertools.combinations(middles, 2)) if len(triangle) == 3 else 0.0
    )


def between_sink(facts: KitchenFacts) -> float | None:
    """Number of cooktop and refrigerator that are neither next to a sink nor across from it."""
    found = centres(facts)
    if len(found) < 3:
        return None
    places = {f.name: _place(facts, f, p) for f, p in found}
    sink = found[0][0]
    lost = 0
    for fixture, _ in found[1:]:
        other = next(f for f, _ in found[1:] if f is not fixture)
        chain, at = places[fixture.name]
        here, middle = places[sink.name]
        there, third = places[other.name]
        next_to = chain == here and not (there == here and min(at, middle) < third < max(at, middle))
        lost += not (next_to or _across(sink, fixture))
    return float(lost)


def _place(facts: KitchenFacts, fixture: Fixture, point: Vec2) -> tuple[str, float]:
    """First run of the chain of runs round corners that a fixture stands in, and how far along the chain it is."""
    run = facts.run(fixture.run)
    if run is None:
        return "", 0.0
    at = run.to_local(point)[0]
    seen = {run.id}
    while (before := next((r for r in facts.runs if r.next_run == run.id), None)) is not None and before.id not in seen:
        seen.add(before.id)
        at += before.length
        run = before
    return run.id, at


def _across(one: Fixture, other: Fixture) -> bool:
    """True if two fixtures look at each other."""
    (ax, ay), (bx, by) = one.footprint.front_axis, other.footprint.front_axis
    aside, before = one.footprint.to_local(other.footprint.at(0.0, 0.0))
    return ax * bx + ay * by < -0.9 and before > 0 and abs(aside) < 1.2
