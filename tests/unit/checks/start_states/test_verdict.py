"""The checks of start states: each is silent on what is right, and alone in speaking where one thing is wrong."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from casa_assets import registry
from casa_assets.checks.check import run
from casa_assets.checks.start_states.draw import draw_states
from casa_assets.checks.start_states.stage import Stage, StatesSubject
from casa_assets.model.issue import Report, Status
from casa_assets.model.kitchen.scene import StartStates
from tests.support.kitchen.start_stages import scene_folder, wanted

LIMITS = registry.load().limits


@cache
def stage() -> Stage:
    with TemporaryDirectory() as root:
        return Stage(scene_folder(Path(root)))


@cache
def sound() -> StartStates:
    return draw_states(stage(), wanted(count=2))


def higher(metres: float) -> StartStates:
    """The first box of the first state so much higher than it rests."""
    rows = sound().qpos.copy()
    box = next(joint for joint in sound().joints if joint.width == 7)
    rows[0, box.address + 2] += metres
    return sound().replace(qpos=rows)


def parked(y: float) -> StartStates:
    base = sound().base.copy()
    base[0, 1] = y
    return sound().replace(base=base)


def twins(apart: float) -> StartStates:
    """A second state that is the first one but for where the robot parks."""
    base = np.repeat(sound().base[:1], 2, axis=0)
    base[1, 0] += apart
    return sound().replace(qpos=np.repeat(sound().qpos[:1], 2, axis=0), base=base)


EXAMPLES: dict[str, tuple[Callable[[], StartStates], Callable[[], StartStates]]] = {
    "STA001": (sound, lambda: sound().replace(scene_xml="0" * 64)),
    "STA002": (lambda: higher(-0.0005), lambda: higher(-0.0015)),
    "STA003": (lambda: higher(0.004), lambda: higher(0.006)),
    "STA004": (lambda: parked(0.34), lambda: parked(0.36)),
    "STA005": (lambda: twins(0.06), lambda: twins(0.04)),
}


def judged(states: StartStates) -> Report:
    return run(StatesSubject(states, stage()), "room", LIMITS)


@pytest.mark.parametrize("code", EXAMPLES)
def test_good_is_silent_and_bad_trips(code: str) -> None:
    good, bad = EXAMPLES[code]
    assert judged(good()).issues == ()
    assert {issue.code for issue in judged(bad()).issues} == {code}


def test_the_state_at_fault_is_named() -> None:
    (issue,) = judged(parked(0.5)).issues
    assert (issue.pointer, issue.message) == ("states/0", "thing_0 stands in the robot; draw it again")


def test_states_of_another_scene_are_not_simulated() -> None:
    joints = tuple(j.replace(name=f"{j.name}_x") for j in sound().joints)
    results = {r.code: r.status for r in judged(sound().replace(joints=joints)).results}
    assert results == {
        "STA001": Status.FAILED,
        **dict.fromkeys(("STA002", "STA003", "STA004"), Status.NOT_RUN),
        "STA005": Status.PASSED,
    }
