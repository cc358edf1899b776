"""Find narrow doorways and aisles, and doors that swing into appliances or into each other."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

from casa_assets.checks.check import Measurement, all_at_least, least, not_applicable
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.mesh.outline import penetration_depth
from casa_assets.model.kitchen.floor import APPLIANCES, AisleKind, Corners, KitchenFacts
from casa_assets.model.kitchen.plan import OpeningKind

# Doorways -------------------------------------------------------------------------------------------------------------
# Find narrow doorways, and doors that swing into appliances or into each other.


def doorways_are_wide_enough(subject: DesignSubject, limit: float) -> Measurement:
    """NKB001: clear width of the narrowest door or passage, metres."""
    # Ref: NKBA planning guideline 1: 32 inches clear.
    widths = {
        f"openings/{opening.id}": opening.clear_width
        for opening in subject.facts.openings
        if opening.kind is not OpeningKind.WINDOW
    }
    message = f"{{:.3f}} m clear with its leaf open, {limit:g} wanted: make the opening wider"
    return all_at_least(widths, limit, message, "it has no door and no passage")


def entry_doors_swing_freely(subject: DesignSubject, limit: float) -> Measurement:
    """NKB002: deepest overlap of an entry door's swing with an appliance or its door, metres."""
    # Ref: NKBA planning guideline 2.
    doors = [(o.id, o.swept_area) for o in subject.facts.openings if o.swept_area is not None]
    if not doors:
        return not_applicable("it has no door with a leaf")
    worst, problems = 0.0, []
    fixtures = subject.facts.with_role(*APPLIANCES)
    solids = [*((f.name, f.footprint.corners, f.bottom, f.top) for f in fixtures), *_appliance_leaves(subject.facts)]
    for door, leaf in doors:
        for name, outline, bottom, top in solids:
            if _share_height(leaf.bottom, leaf.top, bottom, top):
                depth = penetration_depth(leaf.outline, outline)
                worst = max(worst, depth)
                if depth > limit:
                    problems.append((f"openings/{door}", f"its leaf swings {depth:.3f} m into {name}"))
    return Measurement(worst, tuple(problems))


def appliance_doors_swing_apart(subject: DesignSubject, limit: float) -> Measurement:
    """NKB003: deepest overlap of the swings of two appliances' doors, seen from above; metres."""
    # Ref: NKBA planning guideline 2.
    worst, problems = 0.0, []
    leaves = list(_appliance_leaves(subject.facts))
    if len({_fixture(name) for name, *_ in leaves}) < 2:
        return not_applicable("it has no two appliances that open")
    for (name, outline, bottom, top), (other, outline2, bottom2, top2) in itertools.combinations(leaves, 2):
        if _fixture(name) == _fixture(other) or not _share_height(bottom, top, bottom2, top2):
            continue
        depth = penetration_depth(outline, outline2)
        worst = max(worst, depth)
        if depth > limit:
            problems.append((f"fixtures/{name}", f"its way crosses that of {other} by {depth:.3f} m"))
    return Measurement(worst, tuple(problems))


# Name, outline seen from above, and heights of the lower and upper end, metres.
Solid = tuple[str, Corners, float, float]


def _appliance_leaves(facts: KitchenFacts) -> Iterator[Solid]:
    """Doors, flaps and drawers of appliances, called `<fixture>/<joint>`; not those that another one has to uncover."""
    for fixture in facts.with_role(*APPLIANCES):
        for joint in fixture.joints:
            leaf = joint.swept_area
            if leaf is not None and joint.behind is None:
                yield f"{fixture.name}/{joint.name}", leaf.outline, leaf.bottom, leaf.top


def _fixture(leaf: str) -> str:
    """Fixture of a leaf."""
    return leaf.split("/", maxsplit=1)[0]


def _share_height(bottom1: float, top1: float, bottom2: float, top2: float) -> bool:
    """True if two ranges of height share more than a centimetre."""
    return min(top1, top2) - max(bottom1, bottom2) > 0.01


# Aisles ---------------------------------------------------------------------------------------------------------------
# Find aisles that are too narrow to work or to walk in.

NO_AISLE = {
    AisleKind.WORK: "no two fronts face each other",
    AisleKind.WALK: "no way leads between two things, or a thing and a wall",
}


def work_aisles_are_wide_enough(subject: DesignSubject, limit: float) -> Measurement:
    """NKB004: narrowest work aisle of a kitchen that is not declared compact, metres."""
    # Ref: NKBA planning guideline 6: 42 inches for one cook.
    if subject.facts.compact:
        return not_applicable("its plan says that it is compact (NKB005)")
    return _narrowest(subject, limit, AisleKind.WORK)


def compact_work_aisles_are_wide_enough(subject: DesignSubject, limit: float) -> Measurement:
    """NKB005: narrowest work aisle of a kitchen that is declared compact, metres."""
    if not subject.facts.compact:
        return not_applicable("its plan does not say that it is compact (NKB004)")
    return _narrowest(subject, limit, AisleKind.WORK)


def walkways_are_wide_enough(subject: DesignSubject, limit: float) -> Measurement:
    """NKB006: narrowest walkway between fixtures of a kitchen and along walls, metres."""
    # Ref: NKBA planning guideline 7: 36 inches.
    return _narrowest(subject, limit, AisleKind.WALK)


def _narrowest(subject: DesignSubject, limit: float, kind: AisleKind) -> Measurement:
    aisles = [a for a in subject.facts.aisles if a.kind is kind]
    problems = tuple(
        (f"aisles/{a.first}", f"{a.width:.3f} m between {a.first} and {a.second}, {limit:g} wanted")
        for a in aisles
        if a.width < limit
    )
    return least((a.width for a in aisles), problems, NO_AISLE[kind])
