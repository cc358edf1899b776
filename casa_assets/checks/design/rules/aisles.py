"""Find aisles that are too narrow to work or to walk in."""

from __future__ import annotations

from casa_assets.checks.check import Measurement, least, not_applicable
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.model.kitchen.floor import AisleKind

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
    """NKB006: narrowest walkway between what stands in a kitchen and along walls, metres."""
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
