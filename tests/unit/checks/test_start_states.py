"""Start states are drawn at rest, in their places, the same each time; what cannot be drawn is told."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from casa_assets.checks.check import run
from casa_assets.checks.start_states import draw
from casa_assets.checks.start_states.draw import draw_states
from casa_assets.checks.start_states.stage import Stage, StatesSubject, settle, watch
from casa_assets.errors import CasaError
from casa_assets.model.issue import Report, Status
from casa_assets.model.kitchen.scene import StartStates
from tests.support.asset.examples import LIMITS, between, check_examples
from tests.support.kitchen.start_stages import (
    AGAINST_THE_WORKTOP,
    BOX_M,
    CUPBOARD,
    TOP_M,
    WORKTOP,
    scene_folder,
    wanted,
)

DRAWER = f"{CUPBOARD}__drawer_slide"


@cache
def whole_stage() -> Stage:
    with TemporaryDirectory() as root:
        return Stage(scene_folder(Path(root)))


@cache
def sound() -> StartStates:
    return draw_states(whole_stage(), wanted(count=2))


@pytest.fixture
def stage() -> Stage:
    return whole_stage()


@pytest.fixture(scope="module")
def states() -> StartStates:
    return draw_states(whole_stage(), wanted(count=4))


def number(states: StartStates, joint: str, row: int) -> list[float]:
    (found,) = (j for j in states.joints if j.name == joint)
    return [float(x) for x in states.qpos[row, found.address : found.address + found.width]]


def test_each_state_is_within_the_limits_with_what_was_asked_for_in_place(stage: Stage, states: StartStates) -> None:
    assert len(states) == 4
    assert all(len(notes.placed) == 2 and notes.parked == WORKTOP and not notes.opened for notes in states.notes)
    assert float(states.depth.max()) <= 0.001
    assert float(states.motion.max()) <= 0.005
    for x, y, yaw in states.base.tolist():
        assert (x, yaw) == pytest.approx((0.0, 1.5708), abs=1e-5)
        assert -0.4 <= y <= 0.2 + 1e-6
    rest = {joint.name: stage.at_rest[joint.address : joint.address + 7] for joint in stage.joints if joint.width == 7}
    for row, notes in enumerate(states.notes):
        for name, before in rest.items():
            x, y, z = number(states, name, row)[:3]
            place = notes.placed.get(name.removesuffix("__free"))
            if place is None:
                assert (x, y, z) == pytest.approx(before[:3], abs=0.001)
            elif place == f"{WORKTOP}/top":
                assert abs(x) < 0.8 - BOX_M / 2
                assert abs(y - 1.0) < 0.3 - BOX_M / 2
                assert z == pytest.approx(TOP_M, abs=0.001)
            else:
                assert place == f"{CUPBOARD}/drawer_int"
                assert z == pytest.approx(0.445, abs=0.002)


def test_the_same_seed_draws_the_same_and_each_state_stands_for_itself(stage: Stage, states: StartStates) -> None:
    again, other = (draw_states(stage, wanted(count=2, seed=seed)) for seed in (0, 1))
    assert again.qpos.tobytes() == states.qpos[:2].tobytes()
    assert not np.allclose(other.qpos, again.qpos)


def test_a_drawer_that_stands_open_carries_what_lies_in_it(stage: Stage) -> None:
    states = draw_states(stage, wanted(count=6, things=3, opened=1))
    assert any(place.startswith(CUPBOARD) for notes in states.notes for place in notes.placed.values())
    for row, notes in enumerate(states.notes):
        assert notes.opened == (DRAWER,)
        (pulled,) = number(states, DRAWER, row)
        assert 0.4 * 0.3 - 0.002 <= pulled <= 0.302
        for name in (name for name, place in notes.placed.items() if place.startswith(CUPBOARD)):
            assert abs(number(states, f"{name}__free", row)[1] - 1.179 + pulled) < 0.17


def test_what_falls_does_not_stay_and_what_is_pressed_in_is_deep(stage: Stage) -> None:
    states = stage.at_rest.copy()
    box = next(joint for joint in stage.joints if joint.width == 7)
    states[box.address + 2] += 0.02
    assert watch(stage, states).motion > 0.015
    states[box.address + 2] -= 0.023
    assert watch(stage, states).depth == pytest.approx(0.003, abs=1e-4)
    settled = settle(stage, states)
    assert settled is not None
    assert settled[box.address + 2] == pytest.approx(TOP_M, abs=0.001)


def test_what_cannot_be_drawn_is_an_error(stage: Stage, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    blocked = Stage(scene_folder(tmp_path, parked=AGAINST_THE_WORKTOP))
    assert blocked.in_the_way(blocked.parking[0].at) == WORKTOP
    for where, asked, told in [
        (stage, wanted(things=4), "4 things were to be put somewhere in each state, and it has 3"),
        (stage, wanted(opened=2), "2 doors were to stand open, and it has 1"),
        (blocked, wanted(count=1), "something stands where the robot parks"),
    ]:
        with pytest.raises(CasaError, match=told):
            draw_states(where, asked)
    monkeypatch.setattr(draw, "settle", lambda *_: None)
    with pytest.raises(CasaError, match=r"found in 40 draws of number 0: did not come to rest \(40\)"):
        draw_states(stage, wanted())


def test_of_a_stack_the_upper_thing_is_taken_first_and_none_is_left_in_the_air(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stage = Stage(scene_folder(tmp_path, stacked=True))
    assert stage.on_top == {"thing_2": {"thing_3"}}
    states = draw_states(stage, wanted(count=6, things=1))
    assert {name for notes in states.notes for name in notes.placed} == {"thing_3", "thing_4"}
    assert "thing_2" in {name for notes in draw_states(stage, wanted(things=2)).notes for name in notes.placed}
    monkeypatch.setattr(draw, "STAYED_M", 0.0001)
    with pytest.raises(CasaError, match="a thing fell over or off"):
        draw_states(stage, wanted(count=1, things=1))


@pytest.mark.parametrize("name", ["scene.xml", "scene.json"])
def test_a_folder_that_lacks_a_file_or_holds_nonsense_is_told(tmp_path: Path, name: str) -> None:
    folder = scene_folder(tmp_path)
    (folder / name).write_text("{nonsense", encoding="utf-8")
    with pytest.raises(CasaError, match="cannot be read"):
        Stage(folder)
    (folder / name).unlink()
    with pytest.raises(CasaError, match=f"{name}: is missing"):
        Stage(folder)


def higher(metres: float) -> StartStates:
    rows = sound().qpos.copy()
    box = next(joint for joint in sound().joints if joint.width == 7)
    rows[0, box.address + 2] += metres
    return sound().replace(qpos=rows)


def parked(y: float) -> StartStates:
    base = sound().base.copy()
    base[0, 1] = y
    return sound().replace(base=base)


def twins(apart: float) -> StartStates:
    base = np.repeat(sound().base[:1], 2, axis=0)
    base[1, 0] += apart
    return sound().replace(qpos=np.repeat(sound().qpos[:1], 2, axis=0), base=base)


EXAMPLES: dict[str, tuple[Callable[[], StartStates], Callable[[], StartStates]]] = {
    "STA001": (sound, lambda: sound().replace(scene_xml="0" * 64)),
    "STA002": between(higher, -0.0005, -0.0015),
    "STA003": between(higher, 0.004, 0.006),
    "STA004": between(parked, 0.34, 0.36),
    "STA005": between(twins, 0.06, 0.04),
}


def judged(states: StartStates) -> Report:
    return run(StatesSubject(states, whole_stage()), "room", LIMITS)


@pytest.mark.parametrize("code", EXAMPLES)
def test_each_code_is_tripped_by_its_fault_alone(code: str) -> None:
    check_examples(code, *(judged(make()) for make in EXAMPLES[code]))


def test_the_state_at_fault_is_named_and_states_of_another_scene_are_not_simulated() -> None:
    (issue,) = judged(parked(0.5)).issues
    assert (issue.pointer, issue.message) == ("states/0", "thing_0 stands in the robot; draw it again")
    joints = tuple(j.replace(name=f"{j.name}_x") for j in sound().joints)
    results = {r.code: r.status for r in judged(sound().replace(joints=joints)).results}
    expected = dict.fromkeys(("STA002", "STA003", "STA004"), Status.NOT_RUN)
    assert results == {"STA001": Status.FAILED, **expected, "STA005": Status.PASSED}
