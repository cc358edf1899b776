"""Start states in the shared structure: settled, asleep, and none in which a locked joint stands open."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from casa_assets.addons.batch.shared_model import SharedModel, addresses, share
from casa_assets.addons.batch.start_positions import AWAKE, LOCKED, MOVED, start_positions
from casa_assets.errors import CasaError
from casa_assets.model.kitchen.scene import StartStates, StateJoint, StateNotes
from tests.unit.addons.batch.small_kitchens import specs

JOINTS = (("base__hinge", 1), ("locked__slide", 1), ("plate__free", 7))
REST = [0.0, 0.0, 0.7, -0.3, 0.92, 1.0, 0.0, 0.0, 0.0]


@pytest.fixture(scope="module")
def shared() -> SharedModel:
    return share(specs())[0]


def states(*rows: tuple[list[float], tuple[str, ...]]) -> StartStates:
    ends = np.cumsum([0, *(width for _, width in JOINTS)])
    joints = [StateJoint(name=n, address=int(at), width=w) for (n, w), at in zip(JOINTS, ends[:-1], strict=True)]  # type: ignore[arg-type]
    return StartStates(
        key="k",
        scene="l_small__coastal",
        scene_xml="0" * 64,
        mujoco="4.0.0",
        seed=0,
        limits=(0.001, 0.005),
        envelope=(),
        joints=tuple(joints),
        notes=tuple(StateNotes(placed={}, parked="base", opened=opened) for _, opened in rows),
        qpos=np.array([row for row, _ in rows], dtype=np.float32),
        base=np.array([[number, 2.0, 0.5] for number in range(len(rows))], dtype=np.float32),
        depth=np.zeros(len(rows), dtype=np.float32),
        motion=np.zeros(len(rows), dtype=np.float32),
    )


def changed(**values: float) -> list[float]:
    row = list(REST)
    for name, value in values.items():
        row[int(name[1:])] = value
    return row


def test_joints_stand_where_the_state_says_at_rest_and_asleep(shared: SharedModel) -> None:
    found = start_positions(shared, states((changed(q0=-0.6, q2=0.6), ("base__hinge",)), (REST, ())), 16)
    assert found.qpos[0, addresses(shared.model, shared.joints["base__hinge"])] == pytest.approx([-0.6], abs=1e-3)
    plate = found.qpos[0, addresses(shared.model, shared.joints["plate__free"])]
    assert plate[:3] == pytest.approx([0.6, -0.3, 0.92], abs=1e-3)
    assert list(found.states) == [0, 1]
    assert found.base[0] == pytest.approx([0.0, 2.0, 0.5])
    assert (found.asleep >= 0).all()
    data = mujoco.MjData(shared.model)
    data.qpos[:] = found.qpos[1]
    mujoco.mj_step(shared.model, data, nstep=200)
    assert np.abs(data.qpos - found.qpos[1]).max() < 1e-4


def test_states_with_a_locked_joint_open_or_that_fall_are_left_out(shared: SharedModel) -> None:
    for row, reasons in (((changed(q1=0.2), ("locked__slide",)), {LOCKED}), ((changed(q4=1.3), ()), {MOVED, AWAKE})):
        found = start_positions(shared, states(row, (REST, ())), 16)
        assert list(found.states) == [1]
        assert list(found.refused.values()) == [1]
        assert found.refused.keys() <= reasons
    assert len(start_positions(shared, states(*[(REST, ())] * 5), 2)) == 2, "no more than asked for"


def test_without_states_there_is_the_kitchen_as_built(shared: SharedModel) -> None:
    found = start_positions(shared, None, 16, (1.0, -2.0, 0.3))
    assert list(found.states) == [-1]
    assert found.base[0] == pytest.approx([1.0, -2.0, 0.3])
    assert found.qpos[0, addresses(shared.model, shared.joints["corner__slide"])] == pytest.approx([-0.1], abs=1e-3)


def test_a_kitchen_that_never_rests_is_told_by_name() -> None:
    specs_ = specs()[:1]
    # A thing that floats in the air falls for a metre.
    specs_[0].keys[0].qpos = [0, -0.1, 1, -0.3, 0.92, 1, 0, 0, 0, 0, 0.7, -1.5, 1.5, 1, 0, 0, 0]
    (one,) = share(specs_)
    with pytest.raises(CasaError, match="first: nothing is at rest in the batch form"):
        start_positions(one, None, 16)
