"""Check start states that were written: they fit their scene, nothing is pressed into anything, nothing moves."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from casa_assets.checks.check import Measurement, all_at_most, count, not_applicable, not_run
from casa_assets.checks.start_states.stage import Stage, Watched, watch
from casa_assets.core.numeric import Floats
from casa_assets.model.kitchen.scene import StartStates

MM_PER_M = 1000.0
NO_STATES, OTHER_SCENE = "it holds no state", "they are of another scene.xml (STA001)"


@dataclass(frozen=True, eq=False)
class StatesSubject:
    """Start states and the scene of the folder that holds them; a subject is equal to itself alone."""

    states: StartStates
    stage: Stage

    @cached_property
    def misfits(self) -> tuple[str, ...]:
        """In what the states are not of this scene."""
        found = []
        if self.states.scene_xml != self.stage.digest:
            found.append("were made for a scene.xml of other content")
        if self.states.joints != self.stage.joints:
            found.append("name joints or places in qpos that scene.xml does not have")
        return tuple(found)

    @cached_property
    def watched(self) -> tuple[Watched, ...]:
        """Behaviour of each state in 2 s in which nobody touches it, simulated again."""
        return tuple(watch(self.stage, row) for row in self.rows)

    @cached_property
    def rows(self) -> Floats:
        """(states, nq) as MuJoCo takes them."""
        return self.states.qpos.astype(np.float64)


def states_fit_their_scene(subject: StatesSubject) -> Measurement:
    """STA001: number of ways in which the file does not fit scene.xml."""
    return count(("start_states.npz", f"they {text}; draw them again") for text in subject.misfits)


def states_have_no_deep_contact(subject: StatesSubject, limit: float) -> Measurement:
    """STA002: deepest contact in any state at its start and in the 2 s after it, metres."""
    if subject.misfits:
        return not_run(OTHER_SCENE)
    depths = {f"states/{k}": seen.depth * MM_PER_M for k, seen in enumerate(subject.watched)}
    found = all_at_most(depths, limit * MM_PER_M, "shapes are {:.2f} mm in each other; draw it again", NO_STATES)
    return _in_metres(found)


def states_stay_put(subject: StatesSubject, limit: float) -> Measurement:
    """STA003: farthest that anything moves in 2 s in any state, metres."""
    if subject.misfits:
        return not_run(OTHER_SCENE)
    moved = {f"states/{k}": seen.motion * MM_PER_M for k, seen in enumerate(subject.watched)}
    found = all_at_most(moved, limit * MM_PER_M, "something moves {:.1f} mm by itself; draw it again", NO_STATES)
    return _in_metres(found)


def states_leave_room_for_the_robot(subject: StatesSubject, limit: float) -> Measurement:
    """STA004: number of states in which the robot, at its base pose, overlaps something."""
    if subject.misfits:
        return not_run(OTHER_SCENE)
    if not len(subject.states):
        return not_applicable(NO_STATES)
    problems = []
    for k, (row, base) in enumerate(zip(subject.rows, subject.states.base, strict=True)):
        subject.stage.show(row)
        thing = subject.stage.in_the_way(base.astype(np.float64))
        if thing is not None:
            problems.append((f"states/{k}", f"{thing} stands in the robot; draw it again"))
    return count(problems, allowed=limit)


def states_differ(subject: StatesSubject, limit: float) -> Measurement:
    """STA005: farthest that joints, things and robot differ between the two states that are most alike, m or rad."""
    if len(subject.states) < 2:
        return not_applicable("it holds fewer than two states")
    rows = np.concatenate([subject.rows, subject.states.base.astype(np.float64)], axis=1)
    least, problems = np.inf, []
    for k in range(1, len(rows)):
        apart = np.abs(rows[:k] - rows[k]).max(axis=1)
        twin = int(apart.argmin())
        least = min(least, float(apart[twin]))
        if apart[twin] < limit:
            problems.append((f"states/{k}", f"is the same as state {twin} within {apart[twin]:.3f}; draw it again"))
    return Measurement(float(least), tuple(problems))


def _in_metres(found: Measurement) -> Measurement:
    if found.number is None:
        return found
    return Measurement(found.number / MM_PER_M, found.problems)
