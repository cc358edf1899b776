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
        tasks: each of the 25 atomic tasks -> whether it is `afforded`, with which fixtures, joints, sites and regions,
            how much free worktop and floor there is, and at which rate things can be put; else what it `wants`.
    """
    places: dict[str, dict[str, Any]] = {
        name: {"shut": _place(place), "open": {}} for name, place in subject.parking.shut.items()
    }
    for (name, joint), place in subject.parking.open.items():
        places[name]["open"][joint] = _place(place)
    return {"base_radius": BASE_RADIUS_M, "parking": places, "tasks": {t.task: _task(t) for t in subject.tasks}}


def _task(task: Afforded) -> dict[str, Any]:
    if task.wants:
        return {"afforded": False, "wants": task.wants}
    row = task.model_dump(mode="json", exclude={"number", "task", "tightest", "wants"})
    return {"afforded": True, **row}


def _place(place: ParkingPlace | None) -> dict[str, Any] | None:
    if place is None:
        return None
    return {"x": place.position[0], "y": place.position[1], "yaw": place.yaw, "side": place.side.value}
