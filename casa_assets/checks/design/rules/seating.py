"""Measure seats, heights and standard sizes for the design rules."""

from __future__ import annotations

import math

from casa_assets.checks.design.robot.floor_map import obstacles
from casa_assets.checks.design.rules.appliances import COOKTOPS, over
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.geometry.planar import length_inside
from casa_assets.model.kitchen.floor import Fixture, KitchenFacts, Role, RunEnd

FAR = 3.0  # metres behind a seat that are looked at


def behind_seats(subject: DesignSubject) -> float | None:
    """Metres free behind the seat that has least, from its back; open sides of the room do not bound it."""
    found = [_free_behind(subject.facts, s) for s in subject.facts.with_role(Role.SEAT) if s.run]
    return min(found, default=None)


def _free_behind(facts: KitchenFacts, seat: Fixture) -> float:
    """Metres from the back edge of a seat to what stands behind it."""
    run = facts.run(seat.run)
    assert run is not None
    # Seats look at the run's back: behind them is away from it.
    u, v = run.to_local(seat.footprint.center)
    start = -v + seat.footprint.size[1] / 2
    free = FAR
    for outline in obstacles(facts.replace(fixtures=())):
        step = 0.05
        for k in range(math.ceil(free / step - 1e-9)):
            a, b = run.at(u, -(start + k * step)), run.at(u, -(start + (k + 1) * step))
            if length_inside(outline, a, b) > 0:
                free = k * step
                break
    return free


def seat_width(subject: DesignSubject) -> float | None:
    """Metres from seat to seat, the least."""
    seats = [s for s in subject.facts.with_role(Role.SEAT) if s.run]
    apart = [
        math.dist(a.footprint.center, b.footprint.center) for a in seats for b in seats if a is not b and a.run == b.run
    ]
    return min(apart, default=None)


def knee_depth(subject: DesignSubject) -> float | None:
    """Metres that the worktop reaches out over those who sit at it, the least."""
    runs = {s.run for s in subject.facts.with_role(Role.SEAT) if s.run}
    return min((r.overhang for r in subject.facts.runs if r.id in runs), default=None)


def sink_to_dishwasher(subject: DesignSubject) -> float | None:
    """Metres between the nearest edges of dishwasher and sink."""
    facts = subject.facts
    found = []
    for washer in facts.with_role(Role.DISHWASHER):
        for sink in facts.with_role(Role.SINK):
            edges = [(a, b) for a in (-0.5, 0.5) for b in (-0.5, 0.5)]
            gaps = [
                math.dist(
                    washer.footprint.at(a * washer.footprint.size[0], 0.0),
                    sink.footprint.at(b * sink.footprint.size[0], 0.0),
                )
                for a, b in edges
            ]
            found.append(min(gaps))
    return min(found, default=None)


def hoods(subject: DesignSubject) -> float | None:
    """Cooktops under a hood, over all cooktops."""
    cooktops = subject.facts.with_role(*COOKTOPS)
    covered = [c for c in cooktops if any(f.role is Role.HOOD for f in over(subject.facts, c))]
    return len(covered) / len(cooktops) if cooktops else None


def microwave_high(subject: DesignSubject) -> float | None:
    """Height of the foot of the highest microwave, metres."""
    return max((f.bottom for f in subject.facts.with_role(Role.MICROWAVE)), default=None)


def microwave_low(subject: DesignSubject) -> float | None:
    """Height of the foot of the lowest microwave, metres."""
    return min((f.bottom for f in subject.facts.with_role(Role.MICROWAVE)), default=None)


def _above_worktop(subject: DesignSubject) -> list[float]:
    high = max((r.height for r in subject.facts.runs), default=0.92)
    return [f.bottom - high for f in subject.facts.with_role(Role.UPPER, Role.SHELF) if high < f.bottom < high + 0.7]


def least_over_worktop(subject: DesignSubject) -> float | None:
    """Metres between worktop and the lowest wall unit."""
    return min(_above_worktop(subject), default=None)


def most_over_worktop(subject: DesignSubject) -> float | None:
    """Metres between worktop and the highest foot of a wall unit that begins over it."""
    return max(_above_worktop(subject), default=None)


def cooktop_to_wall(subject: DesignSubject) -> float | None:
    """Metres between a cooktop and the wall at the end of its run, the least."""
    found = []
    for run in subject.facts.runs:
        for unit in (u for u in run.units if u.kind in ("range", "hob")):
            found += [unit.left] if run.left_end is RunEnd.WALL else []
            found += [run.length - unit.right] if run.right_end is RunEnd.WALL else []
    return min(found, default=None)


def height_off(subject: DesignSubject) -> float | None:
    """Metres by which worktops are off 36 inches, the most."""
    return max((abs(r.height - 0.914) for r in subject.facts.runs), default=None)


def least_depth(subject: DesignSubject) -> float | None:
    """Metres of the shallowest worktop."""
    return min((r.depth_before for r in subject.facts.runs), default=None)
