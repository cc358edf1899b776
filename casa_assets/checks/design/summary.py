"""What is known of a kitchen's floor, for scene files and reports: parking places, tasks, the grade."""

from __future__ import annotations

from typing import Any

from casa_assets.checks.design.floor_map import RADIUS
from casa_assets.checks.design.grade import grade
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.model.floor import Parking


def summary(subject: DesignSubject) -> dict[str, Any]:
    """As JSON has it.

    Returns:
        base_radius: of the robot, metres.
        parking: fixture -> `shut`, and `open` by joint: `x`, `y`, `yaw` of the middle of the base (yaw: radians to the
            left of the x axis) and its `stance`; None where the base does not get to.
        aisles, tasks, grade: as their records have them.
    """
    lots = subject.lots
    parking: dict[str, dict[str, Any]] = {name: {"shut": _place(p), "open": {}} for name, p in lots.shut.items()}
    for (name, joint), place in lots.open.items():
        parking[name]["open"][joint] = _place(place)
    return {
        "base_radius": RADIUS,
        "parking": parking,
        "aisles": [a.model_dump(mode="json") for a in subject.facts.aisles],
        "tasks": [t.model_dump(mode="json") for t in subject.tasks],
        "grade": grade(subject).model_dump(mode="json"),
    }


def _place(place: Parking | None) -> dict[str, Any] | None:
    if place is None:
        return None
    return {"x": place.at[0], "y": place.at[1], "yaw": place.yaw, "stance": place.stance.value}
