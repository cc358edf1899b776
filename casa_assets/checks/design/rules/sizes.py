"""Seats, heights, standard sizes and wheelchair access, measured for the grade of a kitchen."""

from __future__ import annotations

import math

from casa_assets.checks.design.robot.floor_map import BASE_RADIUS_M, CELL_M, GAP_M, obstacles
from casa_assets.checks.design.rules.appliances import COOKTOPS, over
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.mesh.planar import length_inside
from casa_assets.model.kitchen.floor import APPLIANCES, AisleKind, Fixture, Footprint, KitchenFacts, Role, RunEnd
from casa_assets.model.kitchen.plan import OpeningKind

# Seating --------------------------------------------------------------------------------------------------------------
# Measure seats, heights and standard sizes for the design rules.

FAR = 3.0  # metres behind a seat that are looked at


def behind_seats(subject: DesignSubject) -> float | None:
    """Metres free behind the seat that has least, from its back; open sides of the room do not bound it."""
    found = [_free_behind(subject.facts, s) for s in subject.facts.with_role(Role.SEAT) if s.run]
    return min(found, default=None)


def _free_behind(facts: KitchenFacts, seat: Fixture) -> float:
    """Metres from the back edge of a seat to the nearest obstacle behind it."""
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
    pairs = [(a.footprint, b.footprint) for a in seats for b in seats if a is not b and a.run == b.run]
    return min((math.dist(a.center, b.center) for a, b in pairs), default=None)


def knee_depth(subject: DesignSubject) -> float | None:
    """Metres that the worktop reaches out over those who sit at it, the least."""
    runs = {s.run for s in subject.facts.with_role(Role.SEAT) if s.run}
    return min((r.overhang for r in subject.facts.runs if r.id in runs), default=None)


def sink_to_dishwasher(subject: DesignSubject) -> float | None:
    """Metres between the nearest edges of dishwasher and sink."""
    facts = subject.facts
    washers, sinks = (
        [f.footprint.at(share * f.footprint.size[0], 0.0) for f in facts.with_role(role) for share in (-0.5, 0.5)]
        for role in (Role.DISHWASHER, Role.SINK)
    )
    return min((math.dist(edge, other) for edge in washers for other in sinks), default=None)


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


# Wheelchair access ----------------------------------------------------------------------------------------------------
# Measure wheelchair access (the access profile); no limits are applied.
#
# Ref: 2010 ADA Standards 804, 305, 306, 308, 309; ICC A117.1 1003.12.

CLEAR = (0.762, 1.219)  # metres of free floor at each place of work, either way round
REACH = (0.381, 1.219)  # heights that a seated person reaches, metres


def pass_aisle(subject: DesignSubject) -> float | None:
    """Metres between fronts that face each other, the least; None if no fronts do."""
    return min((a.width for a in subject.facts.aisles if a.kind is AisleKind.WORK), default=None)


def u_aisle(subject: DesignSubject) -> float | None:
    """Least metres between fronts in the middle of three joined runs, or None if no three runs join."""
    facts = subject.facts
    ends = {r.id: r.next_run for r in facts.runs}
    trios = [(a, n) for a, b in ends.items() if b is not None and (n := ends.get(b)) is not None]
    found = [x.width for x in facts.aisles if any({x.first, x.second} == set(trio) for trio in trios)]
    return min(found, default=None)


def lacking_floor(subject: DesignSubject) -> float | None:
    """Sinks and appliances without that much free floor before them."""
    worked = subject.facts.with_role(Role.SINK, *APPLIANCES)
    return float(sum(not _has_floor(subject, f.name) for f in worked)) if worked else None


def _has_floor(subject: DesignSubject, name: str) -> bool:
    place = subject.parking.shut.get(name)
    if place is None:
        return False
    fixture = next(f for f in subject.facts.fixtures if f.name == name)
    _, before = fixture.footprint.to_local(place.position)
    start = before - BASE_RADIUS_M - GAP_M
    for wide, deep in (CLEAR, CLEAR[::-1]):
        middle, size = fixture.footprint.at(0.0, start + deep / 2 + CELL_M), (wide - CELL_M, deep - CELL_M)
        if not _is_taken(subject, Footprint(center=middle, size=size, yaw=fixture.footprint.yaw)):
            return True
    return False


def _is_taken(subject: DesignSubject, foot: Footprint) -> bool:
    floor = subject.floor
    w, d = foot.size
    for i in range(int(w / CELL_M) + 1):
        for k in range(int(d / CELL_M) + 1):
            if floor.holds(floor.solid, foot.at(-w / 2 + i * CELL_M, -k * CELL_M)):
                return True
    return False


def lowest_worktop(subject: DesignSubject) -> float | None:
    """Height of the lowest worktop or table, metres."""
    heights = [r.height for r in subject.facts.runs] + [t.top for t in subject.facts.with_role(Role.TABLE)]
    return min(heights, default=None)


def sink_rim(subject: DesignSubject) -> float | None:
    """Height of the lowest sink's rim, metres."""
    heights = [r.height for f in subject.facts.with_role(Role.SINK) if (r := subject.facts.run(f.run)) is not None]
    return min(heights, default=None)


def knee_room(subject: DesignSubject) -> float | None:
    """Metres of the widest gap below a worktop."""
    gaps = [u.right - u.left for r in subject.facts.runs for u in r.units if u.kind == "gap" and u.has_worktop]
    return max(gaps, default=0.0)


def reached_grips(subject: DesignSubject) -> float | None:
    """Share of all handles, knobs and keys that a seated person reaches."""
    grips = [j.grip_point[2] for f in subject.facts.fixtures for j in f.joints if j.grip_point is not None]
    return sum(REACH[0] <= z <= REACH[1] for z in grips) / len(grips) if grips else None


def reached_shelves(subject: DesignSubject) -> float | None:
    """Share of shelves and drawers, by their area, whose floor a seated person reaches."""
    kept = (Role.CABINET, Role.DRAWERS, Role.UPPER, Role.SHELF, Role.PANTRY, Role.CORNER, Role.ISLAND, Role.SINK_BASE)
    found = [
        (v.footprint.size[0] * v.footprint.size[1], REACH[0] <= v.bottom <= REACH[1])
        for f in subject.facts.with_role(*kept)
        for v in f.regions
        if v.name not in ("main", "int")
    ]
    total = sum(area for area, _ in found)
    return sum(area for area, good in found if good) / total if total else None


def turning_circle(subject: DesignSubject) -> float | None:
    """Metres across the widest free circle on the floor."""
    floor = subject.floor
    return 2.0 * float((floor.clear * floor.room).max())


def clear_doorway(subject: DesignSubject) -> float | None:
    """Metres of the narrowest doorway."""
    return min((w.clear_width for w in subject.facts.openings if w.kind is not OpeningKind.WINDOW), default=None)
