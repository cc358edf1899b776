"""Joints of a kitchen that a robot is asked to open, and the check of those that it reaches.

Light to import: inverse kinematics (mink) is in `addons.robots`, imported only where robots are tried.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from casa_assets.checks.check import Measurement, not_applicable, not_run
from casa_assets.model.kitchen.robot import SceneRobots
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

FLOOR_ROBOT = "PandaOmron"  # RoboCasa's own robot; for the others numbers are reported and nothing is asked


@dataclass(frozen=True)
class Task:
    """A joint of a kitchen (its name in the MJCF) that a robot is to work, and the geom that a hand takes or presses.

    `behind`: joint of the door that has to be open first, or empty. `front`: unit vector out of the fixture, level.
    `places`: parking places, x, y (m), direction (rad): while it is shut, then once it is open.
    """

    fixture: str
    joint: str
    grip: str
    behind: str
    front: Vec3
    places: tuple[Vec3, ...]


def tasks_of(facts: Mapping[str, Any]) -> tuple[list[Task], list[str]]:
    """From scene.json, tasks for all joints that have a grip, and the joints of fixtures without parking places."""
    tasks: list[Task] = []
    without: list[str] = []
    for fixture in facts["fixtures"]:
        x, y = Pose(quaternion=fixture["quaternion"]).rotation[:2, 1]
        parking = facts["parking"].get(fixture["name"])
        for name, joint in fixture["joints"].items():
            if joint["grip"] is None:
                continue
            if parking is None:
                without.append(joint["name"])
                continue
            door = joint["behind"] or ""
            # Before the open door, where there is one.
            opened = parking["open"]
            rows = [opened.get(door.rpartition("__")[2])] if door else [parking["shut"], opened.get(name)]
            places = [(float(row["x"]), float(row["y"]), float(row["yaw"])) for row in rows if row is not None]
            task = Task(
                fixture=fixture["name"],
                joint=joint["name"],
                grip=joint["grip"],
                behind=door,
                front=(-float(x), -float(y), 0.0),
                places=tuple(dict.fromkeys(places)),
            )
            tasks.append(task)
    return tasks, without


def joints_are_reached(subject: SceneRobots, least: float) -> Measurement:
    """Share of the joints with a handle, knob, key or lever that PandaOmron reaches."""
    found = next((r for r in subject.robots if r.robot == FLOOR_ROBOT), None)
    if found is None:
        return not_run(f"{FLOOR_ROBOT} is not among the robots that were tried")
    if subject.only:
        return not_run(f"only some joints were tried: {', '.join(subject.only)}")
    if not found.joints:
        return not_applicable("nothing with a parking place has a handle, knob, key or lever")
    share = found.reached / len(found.joints)
    missed = [joint for joint in found.joints if not joint.reached]
    message = f"{FLOOR_ROBOT} does not get its hand there"
    problems = [(f"{j.fixture}/{j.joint}", f"{message}: {j.missed or 'unknown'}") for j in missed]
    return Measurement(share, tuple(problems) if share < least else ())
