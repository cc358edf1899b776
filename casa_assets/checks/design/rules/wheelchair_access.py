"""Measure wheelchair access (the access profile); no limits are applied.

Ref: 2010 ADA Standards 804, 305, 306, 308, 309; ICC A117.1 1003.12.
"""

from __future__ import annotations

from casa_assets.checks.design.robot.floor_map import BASE_RADIUS_M, CELL_M
from casa_assets.checks.design.robot.parking import GAP_M
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.model.kitchen.floor import APPLIANCES, AisleKind, Footprint, Role
from casa_assets.model.kitchen.plan import OpeningKind

CLEAR = (0.762, 1.219)  # metres of free floor at each place of work, either way round
REACH = (0.381, 1.219)  # heights that a seated person reaches, metres


def pass_aisle(subject: DesignSubject) -> float | None:
    """Metres between fronts that face each other, the least; None where none do."""
    return min((a.width for a in subject.facts.aisles if a.kind is AisleKind.WORK), default=None)


def u_aisle(subject: DesignSubject) -> float | None:
    """Least metres between fronts in the middle of three joined runs, or None where no three join."""
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
        middle = fixture.footprint.at(0.0, start + deep / 2 + CELL_M)
        if not _is_taken(
            subject, Footprint(center=middle, size=(wide - CELL_M, deep - CELL_M), yaw=fixture.footprint.yaw)
        ):
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
