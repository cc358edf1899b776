"""Rules of room to work and to walk."""

from __future__ import annotations

from casa_assets.checks.check import Measured
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.model.floor import AisleKind


def is_roomy(subject: DesignSubject, limit: float | None) -> Measured:
    """Fronts that face each other leave `limit` metres, in kitchens that are not declared compact; the narrowest."""
    # Ref: NKBA planning guideline 6: 42 inches for one cook.
    return Measured() if subject.facts.compact else _narrowest(subject, limit, AisleKind.WORK)


def is_roomy_enough(subject: DesignSubject, limit: float | None) -> Measured:
    """The same in kitchens that are declared compact; metres of the narrowest."""
    return _narrowest(subject, limit, AisleKind.WORK) if subject.facts.compact else Measured()


def lets_pass(subject: DesignSubject, limit: float | None) -> Measured:
    """Ways between what stands in a kitchen, and along walls, are `limit` metres wide; metres of the narrowest."""
    # Ref: NKBA planning guideline 7: 36 inches.
    return _narrowest(subject, limit, AisleKind.WALK)


def _narrowest(subject: DesignSubject, limit: float | None, kind: AisleKind) -> Measured:
    assert limit is not None
    aisles = [a for a in subject.facts.aisles if a.kind is kind]
    problems = tuple(
        (f"aisles/{a.one}", f"{a.width:.3f} m between {a.one} and {a.other}, {limit:g} wanted")
        for a in aisles
        if a.width < limit
    )
    return Measured(min((a.width for a in aisles), default=None), problems)
