"""Summarize a kitchen's floor for scene files: parking places, and tasks with their fixtures."""

from __future__ import annotations

from typing import Any

from casa_assets.checks.design.robot.floor_map import BASE_RADIUS_M
from casa_assets.checks.design.robot.task_view import Afforded
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.model.kitchen.floor import ParkingPlace


def whereabouts(subject: DesignSubject) -> dict[str, Any]:
    """As JSON has it; all numbers are rounded.

    Returns:
        base_radius: of the robot, metres.
        parking: fixture -> `shut`, and `open` by joint: `x`, `y`, `yaw` of the middle of the base (yaw: radians to the
            left of the x axis) and the `side` of the fixture that it stands at; None where the base does not get to.
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
