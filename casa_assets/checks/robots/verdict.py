"""Check that robots can work a kitchen, from what was found with inverse kinematics."""

from __future__ import annotations

from casa_assets.checks.check import Measurement, not_applicable, not_run
from casa_assets.model.kitchen.robot import SceneRobots

FLOOR_ROBOT = "PandaOmron"  # RoboCasa's own robot; for the others numbers are told and nothing is asked


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
    problems = [
        (f"{j.fixture}/{j.joint}", f"{FLOOR_ROBOT} does not get its hand there: {j.missed or 'unknown'}")
        for j in missed
    ]
    return Measurement(share, tuple(problems) if share < least else ())
