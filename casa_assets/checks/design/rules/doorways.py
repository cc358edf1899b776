"""Find narrow doorways, and doors that swing into appliances or into each other."""

from __future__ import annotations

from collections.abc import Iterator

from casa_assets.checks.check import Measurement, least, not_applicable
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.geometry.planar import penetration_depth
from casa_assets.model.kitchen.floor import APPLIANCES, Corners, KitchenFacts, SweptArea
from casa_assets.model.kitchen.plan import OpeningKind


def doorways_are_wide_enough(subject: DesignSubject, limit: float) -> Measurement:
    """NKB001: clear width of the narrowest door or passage, metres."""
    # Ref: NKBA planning guideline 1: 32 inches clear.
    ways = [w for w in subject.facts.openings if w.kind is not OpeningKind.WINDOW]
    problems = tuple(
        (
            f"openings/{w.id}",
            f"{w.clear_width:.3f} m clear with its leaf open, {limit:g} wanted: make the opening wider",
        )
        for w in ways
        if w.clear_width < limit
    )
    return least((w.clear_width for w in ways), problems, "it has no door and no passage")


def entry_doors_swing_freely(subject: DesignSubject, limit: float) -> Measurement:
    """NKB002: deepest overlap of an entry door's swing with an appliance or its door, metres."""
    # Ref: NKBA planning guideline 2.
    worst, problems = 0.0, []
    if not any(way.swept_area for way in subject.facts.openings):
        return not_applicable("it has no door with a leaf")
    bodies = [*_bodies(subject.facts), *_leaves(subject.facts)]
    for way in subject.facts.openings:
        for name, outline, low, high in bodies if way.swept_area else ():
            assert way.swept_area is not None
            if _level(way.swept_area.bottom, way.swept_area.top, low, high):
                deep = penetration_depth(way.swept_area.outline, outline)
                worst = max(worst, deep)
                if deep > limit:
                    problems.append((f"openings/{way.id}", f"its leaf swings {deep:.3f} m into {name}"))
    return Measurement(worst, tuple(problems))


def appliance_doors_swing_apart(subject: DesignSubject, limit: float) -> Measurement:
    """NKB003: deepest overlap of the swings of two appliances' doors, seen from above; metres."""
    # Ref: NKBA planning guideline 2.
    worst, problems = 0.0, []
    leaves = list(_leaves(subject.facts))
    if len({name.split("/")[0] for name, *_ in leaves}) < 2:
        return not_applicable("it has no two appliances that open")
    for i, (one, a, low, high) in enumerate(leaves):
        for other, b, bottom, top in leaves[i + 1 :]:
            if one.split("/")[0] == other.split("/")[0] or not _level(low, high, bottom, top):
                continue
            deep = penetration_depth(a, b)
            worst = max(worst, deep)
            if deep > limit:
                problems.append((f"fixtures/{one}", f"its way crosses that of {other} by {deep:.3f} m"))
    return Measurement(worst, tuple(problems))


Solid = tuple[str, Corners, float, float]


def _bodies(facts: KitchenFacts) -> Iterator[Solid]:
    for fixture in facts.with_role(*APPLIANCES):
        yield fixture.name, fixture.footprint.corners, fixture.bottom, fixture.top


def _leaves(facts: KitchenFacts) -> Iterator[Solid]:
    """Doors, flaps and drawers of appliances; what is behind a door moves only once that is open."""
    for fixture in facts.with_role(*APPLIANCES):
        for joint in fixture.joints:
            leaf: SweptArea | None = joint.swept_area
            if leaf is not None and joint.behind is None:
                yield f"{fixture.name}/{joint.name}", leaf.outline, leaf.bottom, leaf.top


def _level(low: float, high: float, bottom: float, top: float) -> bool:
    """True if two ranges of height share more than a centimetre."""
    return min(high, top) - max(low, bottom) > 0.01
