"""A kitchen as checks of design and ways see it; what a robot does not reach; a summary of it for scene files."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from casa_assets.checks.check import Measurement, count, least, not_applicable
from casa_assets.checks.design.robot.floor_map import BASE_RADIUS_M, FloorMap, ParkingPlaces, find_parking
from casa_assets.checks.design.robot.task_view import Afforded, AtomicTask, TaskView
from casa_assets.checks.design.robot.tasks import afforded, atomic_tasks
from casa_assets.model.kitchen.floor import KitchenFacts, ParkingPlace
from casa_assets.model.kitchen.plan import OpeningKind

# Subject --------------------------------------------------------------------------------------------------------------
# A kitchen as the checks of design, ways and tasks see it: its facts, and what is worked out of them once.


@dataclass(frozen=True, eq=False)
class DesignSubject:
    """A kitchen's facts; a subject is equal to itself alone.

    Attributes:
        facts: from layouts.facts.facts_of.
        seed: of the samples with which tasks are tried.
    """

    facts: KitchenFacts
    seed: int = 0

    @cached_property
    def floor(self) -> FloorMap:
        """The floor as a grid."""
        return FloorMap(self.facts)

    @cached_property
    def parking(self) -> ParkingPlaces:
        """Parking places of a robot's base."""
        return find_parking(self.facts, self.floor)

    @cached_property
    def tasks(self) -> tuple[Afforded, ...]:
        """Fixtures, joints, sites and regions that the kitchen offers for each task."""
        return afforded(self.facts, self.floor, self.parking, self.seed)

    @cached_property
    def atomic_tasks(self) -> tuple[AtomicTask, ...]:
        """With what the tasks of RoboCasa v1.0 can be done."""
        return atomic_tasks(TaskView(self.facts, self.floor, self.parking))


# Summary --------------------------------------------------------------------------------------------------------------
# Summarize a kitchen's floor for scene files: parking places, and tasks with their fixtures.


def whereabouts(subject: DesignSubject) -> dict[str, Any]:
    """JSON data about the floor of a kitchen for scene files; all numbers are rounded.

    Returns:
        base_radius: of the robot, metres.
        parking: fixture -> `shut`, and `open` by joint: `x`, `y`, `yaw` of the middle of the base (yaw: radians to the
            left of the x axis) and the `side` of the fixture that it is at; None if the base cannot get there.
        robocasa_v1: each of the 65 atomic tasks of RoboCasa v1.0, by its name there -> whether it is `afforded`, with
            which fixtures; else what it `wants`. Objects to put are the library's.
        tasks: each of the 25 atomic tasks of v0.2 -> whether it is `afforded`, with which fixtures, joints, sites and
            regions, how much free worktop and floor there is, and at which rate things can be put; else what it
            `wants`.
    """
    places: dict[str, dict[str, Any]] = {
        name: {"shut": _place(place), "open": {}} for name, place in subject.parking.shut.items()
    }
    for (name, joint), place in subject.parking.open.items():
        places[name]["open"][joint] = _place(place)
    return {
        "base_radius": BASE_RADIUS_M,
        "parking": places,
        "tasks": {t.task: _task(t) for t in subject.tasks},
        "robocasa_v1": {
            t.task: {"afforded": False, "wants": t.wants}
            if t.wants
            else {"afforded": True, "fixtures": list(t.fixtures)}
            for t in subject.atomic_tasks
        },
    }


def _task(task: Afforded) -> dict[str, Any]:
    if task.wants:
        return {"afforded": False, "wants": task.wants}
    row = task.model_dump(mode="json", exclude={"number", "task", "tightest", "wants"})
    return {"afforded": True, **row}


def _place(place: ParkingPlace | None) -> dict[str, Any] | None:
    if place is None:
        return None
    return {"x": place.position[0], "y": place.position[1], "yaw": place.yaw, "side": place.side.value}


# Reach ----------------------------------------------------------------------------------------------------------------
# Find fixtures, doorways and tasks that are out of a robot's reach.


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
