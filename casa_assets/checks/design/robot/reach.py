"""Find fixtures, doorways and tasks that are out of a robot's reach."""

from __future__ import annotations

from casa_assets.checks.check import Measurement, count, least, not_applicable
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.model.kitchen.plan import OpeningKind


def fixtures_are_reachable(subject: DesignSubject, limit: float) -> Measurement:
    """NAV001: number of fixtures that a base cannot park before, coming from a doorway or an open side."""
    places = subject.parking.shut
    if not places:
        return not_applicable("it has no fixture to park before")
    message = "no base of 0.30 m radius can park before it: leave floor free there, and a way to it"
    return count(((f"fixtures/{name}", message) for name, place in places.items() if place is None), allowed=limit)


def opened_fixtures_are_reachable(subject: DesignSubject, limit: float) -> Measurement:
    """NAV002: number of fixtures that a base cannot park before while one of their doors or drawers is open.

    `fixtures_are_reachable` reports fixtures that are not reached with all shut.
    """
    parking = subject.parking
    if not parking.open:
        return not_applicable("nothing in it opens")
    message = "no base of 0.30 m radius can stand before, beside or behind it once it is open"
    problems = (
        (f"fixtures/{name}/{joint}", message)
        for (name, joint), place in parking.open.items()
        if place is None and parking.shut[name] is not None
    )
    return count(problems, allowed=limit)


def entries_lead_in(subject: DesignSubject, limit: float) -> Measurement:
    """NAV003: number of doors and passages from which a base does not get on to the kitchen's floor."""
    entries = [o for o in subject.facts.openings if o.kind is not OpeningKind.WINDOW]
    if not entries:
        return not_applicable("it has no door and no passage")
    message = "what stands before it leaves no way for a base of 0.30 m radius"
    blocked = (o.id for o in entries if not subject.floor.leads_in(o.start, o.end))
    return count(((f"openings/{name}", message) for name in blocked), allowed=limit)


def tasks_are_supported(subject: DesignSubject, limit: float) -> Measurement:
    """TSK001: number of the 25 tasks that lack fixtures, joints or sites that a base gets to.

    Only a plan that says so has to support them all: a kitchen without a microwave is no fault of a kitchen.
    """
    if not subject.facts.all_tasks:
        return not_applicable("its plan does not say `all_tasks: true`")
    return count(((f"tasks/{t.task}", f"it wants {t.wants}") for t in subject.tasks if t.wants), allowed=limit)


def task_objects_find_room(subject: DesignSubject, limit: float) -> Measurement:
    """TSK002: least share, over the tasks, of sampled objects that can be placed.

    `tasks_are_supported` reports tasks that lack something else.
    """
    rates = [(t.task, t.rate, t.tightest) for t in subject.tasks if t.rate is not None]
    message = "of 200 things only {:.1%} found room within reach at {}; {:.0%} wanted: clear it, or make it larger"
    problems = tuple((f"tasks/{task}", message.format(rate, at, limit)) for task, rate, at in rates if rate < limit)
    return least((rate for _, rate, _ in rates), problems, "it has what it takes for no task (TSK001)")
