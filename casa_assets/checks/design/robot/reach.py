"""Find fixtures and doorways that a robot's base cannot reach."""

from __future__ import annotations

from casa_assets.checks.check import Measurement, not_applicable
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.model.kitchen.plan import OpeningKind

BARE = "it has no fixture to park before"


def fixtures_are_reachable(subject: DesignSubject, limit: float) -> Measurement:
    """NAV001: number of fixtures that a base cannot park before, coming from a doorway or an open side."""
    if not subject.lots.shut:
        return not_applicable(BARE)
    lost = [name for name, place in subject.lots.shut.items() if place is None]
    message = "no base of 0.30 m radius can park before it: leave floor free there, and a way to it"
    return Measurement(float(len(lost)), tuple((f"fixtures/{n}", message) for n in lost) if len(lost) > limit else ())


def opened_fixtures_are_reachable(subject: DesignSubject, limit: float) -> Measurement:
    """NAV002: number of fixtures that a base cannot park before while one of their doors or drawers is open.

    Fixtures that are not reached with all shut are the business of `fixtures_are_reachable`.
    """
    lots = subject.lots
    if not lots.open:
        return not_applicable("nothing in it opens")
    lost = [key for key, place in lots.open.items() if place is None and lots.shut[key[0]] is not None]
    message = "no base of 0.30 m radius can stand before, beside or behind it once it is open"
    problems = tuple((f"fixtures/{name}/{joint}", message) for name, joint in lost)
    return Measurement(float(len(lost)), problems if len(lost) > limit else ())


def entries_lead_in(subject: DesignSubject, limit: float) -> Measurement:
    """NAV003: number of doors and passages from which a base does not get on to the kitchen's floor."""
    ways = [w for w in subject.facts.openings if w.kind is not OpeningKind.WINDOW]
    if not ways:
        return not_applicable("it has no door and no passage")
    blocked = [w.id for w in ways if not subject.floor.leads_in(w.start, w.end)]
    message = "what stands before it leaves no way for a base of 0.30 m radius"
    return Measurement(
        float(len(blocked)), tuple((f"openings/{n}", message) for n in blocked) if len(blocked) > limit else ()
    )
