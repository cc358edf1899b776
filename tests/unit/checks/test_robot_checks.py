"""The check of robots, the tasks that it is made from, and the grasps that are tried: all without mink or a robot."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest

from casa_assets.addons.robots import certify as certifying
from casa_assets.addons.robots.grips import TAKEN_M, Grip, pinches, presses
from casa_assets.addons.robots.workspace import handle_of, leg_angles
from casa_assets.checks.check import run
from casa_assets.checks.robots import tasks_of
from casa_assets.errors import CasaError, UnknownId
from casa_assets.model.issue import Status
from casa_assets.model.kitchen.robot import JointReach, Legs, Miss, RobotCertificate, SceneRobots
from casa_assets.registry.tables import load_robot, robot_names
from tests.support.asset.examples import LIMITS, check_examples


def certificate(reached: int, of: int, robot: str = "PandaOmron") -> SceneRobots:
    names = [f"doors_{k}" for k in range(of)]
    joints = tuple(JointReach(fixture=n, joint=f"{n}__doorhinge", reached=k < reached) for k, n in enumerate(names))
    found = RobotCertificate(robot=robot, shape="one arm", drives=True, joints=joints)
    return SceneRobots(scene="l_small__coastal", key="k", scene_key="s", robots=(found,))


EXAMPLES: dict[str, tuple[Callable[[], Any], Callable[[], Any]]] = {
    "ROB001": (lambda: certificate(19, 20), lambda: certificate(18, 20))
}


def test_good_is_silent_and_each_joint_out_of_reach_is_named() -> None:
    good, bad = (run(make(), "l_small__coastal", LIMITS) for make in EXAMPLES["ROB001"])
    check_examples("ROB001", good, bad, parted=True)
    found = certificate(3, 5)
    (robot,) = found.robots
    missed = robot.joints[4].model_copy(update={"missed": Miss.BLOCKED})
    robot = robot.model_copy(update={"joints": (*robot.joints[:4], missed)})
    report = run(found.model_copy(update={"robots": (robot,)}), "l_small__coastal", LIMITS)
    assert [issue.pointer for issue in report.issues] == ["doors_3/doors_3__doorhinge", "doors_4/doors_4__doorhinge"]
    assert "in the way" in report.issues[1].message
    assert not report.passed


def test_status_where_there_is_nothing_to_reach_or_only_some_joints_or_another_robot_were_tried() -> None:
    some = certificate(1, 5).model_copy(update={"only": ("*drawer*",)})
    for found, status, number in (
        (certificate(0, 0), Status.NOT_APPLICABLE, None),
        (certificate(2, 2, "Tiago"), Status.NOT_RUN, None),
        (certificate(2, 2), Status.PASSED, 1.0),
        (some, Status.NOT_RUN, None),
    ):
        (result,) = run(found, found.scene, LIMITS).results
        assert (result.status, result.number) == (status, number)
    assert not run(some, some.scene, LIMITS).passed


def test_legs_bend_so_that_feet_stay_where_they_are() -> None:
    legs = Legs(angles={"hip": (0.0, -1.0), "knee": (0.0, 2.0), "ankle": (0.0, -1.0)}, length=0.7, lean=(0.2, 0.95))
    heights = np.array((0.0, -0.1, -0.25))
    angles, slopes = leg_angles(legs, heights)
    leans = -angles[:, 0]
    assert 0.7 * np.cos(leans) == pytest.approx(0.7 * np.cos(0.2) + heights)
    assert angles.sum(axis=1) == pytest.approx(0.0)  # soles stay level
    assert leans[0] == pytest.approx(0.2)
    ahead, _ = leg_angles(legs, heights - 1e-6)
    assert (angles - ahead) / 1e-6 == pytest.approx(slopes, rel=1e-3)


def test_tasks_have_the_places_of_the_closed_fixture_and_of_its_open_door() -> None:
    """A cupboard with a door that looks along -y, a rack behind it, and a window that nobody parks at."""
    place = {"side": "front", "x": 1.0, "y": -1.0, "yaw": 1.5708}
    aside = {"side": "left", "x": 0.4, "y": -1.2, "yaw": 0.8}
    joints: dict[str, dict[str, Any]] = {"cupboard": {}, "window": {}}
    for fixture, name, grip, behind in (
        ("cupboard", "door", "cupboard__handle", None),
        ("cupboard", "rack", "cupboard__handle", "cupboard__door"),
        ("cupboard", "flap", None, None),
        ("window", "sash", "window__handle", None),
    ):
        joints[fixture][name] = {"name": f"{fixture}__{name}", "grip": grip, "behind": behind}
    fixtures = [{"name": name, "quaternion": [1.0, 0.0, 0.0, 0.0], "joints": own} for name, own in joints.items()]
    facts = {"fixtures": fixtures, "parking": {"cupboard": {"shut": place, "open": {"door": aside}}}}
    tasks, without = tasks_of(facts)
    assert [(t.joint, t.behind, t.places) for t in tasks] == [
        ("cupboard__door", "", ((1.0, -1.0, 1.5708), (0.4, -1.2, 0.8))),
        ("cupboard__rack", "cupboard__door", ((0.4, -1.2, 0.8),)),
    ]
    assert tasks[0].front == pytest.approx((0.0, -1.0, 0.0))
    assert without == ["window__sash"]


def box(*half: float) -> Grip:
    return Grip(np.zeros(3), np.eye(3), np.array(half), np.array((0.0, -1.0, 0.0)))


def test_a_bar_is_held_across_its_length_and_a_hand_comes_from_the_front_first() -> None:
    grasps = pinches(box(0.08, 0.006, 0.006), 0.075, None)
    assert grasps[0].rotation[:, 2] == pytest.approx((0.0, 1.0, 0.0))
    assert all(abs(g.rotation[0, 0]) < 1e-9 and g.width == pytest.approx(0.012) for g in grasps)
    assert all(g.pivots and np.linalg.det(g.rotation) == pytest.approx(1.0) for g in grasps)
    # Near its front, so that the tips keep clear of what is behind.
    for depth in [0.003, 0.006, 0.017]:
        grasp = pinches(box(0.08, depth, 0.006), 0.075, None)[0]
        assert grasp.position[1] == pytest.approx(min(0.0, TAKEN_M - depth)), depth


def test_a_handle_is_its_grip_and_what_touches_it_on_the_same_body() -> None:
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody><body name="drawer">
        <geom name="front" type="box" size="0.3 0.01 0.1"/>
        <geom name="lip" type="box" size="0.03 0.003 0.01" pos="0 -0.04 0"/>
        <geom name="dome" type="box" size="0.03 0.015 0.007" pos="0 -0.025 0.017"/>
        <geom name="second" type="box" size="0.03 0.003 0.01" pos="0.2 -0.04 0"/>
        </body></worldbody></mujoco>"""
    )
    handles = frozenset({"lip", "dome", "second"})
    assert handle_of(model, handles, "lip") == ["lip", "dome"]
    assert handle_of(model, handles, "front") == ["front"]


def test_what_is_wider_than_the_hand_is_held_by_its_edge_or_not_at_all() -> None:
    plate = pinches(box(0.2, 0.15, 0.005), 0.075, None)
    assert {round(g.width, 4) for g in plate} == {0.01}
    assert all(g.position[1] == pytest.approx(-0.135) for g in plate)
    assert pinches(box(0.1, 0.1, 0.1), 0.075, None) == []


def test_a_hand_comes_to_a_knob_on_a_hob_from_above_and_presses_a_key_along_its_motion_first() -> None:
    """Whichever way the knob's axis points, and however little it leans."""
    for sign in [1.0, -1.0]:
        grasps = pinches(box(0.019, 0.019, 0.008), 0.075, sign * np.array((0.0, 1e-9, 1.0)))
        assert grasps
        assert all(grasp.rotation[2, 2] < -0.8 for grasp in grasps)
    pressed = presses(box(0.02, 0.003, 0.01), np.array((0.0, 1.0, 0.0)))
    assert pressed[0].rotation[:, 2] == pytest.approx((0.0, 1.0, 0.0))
    assert all(g.position == pytest.approx((0.0, -0.003, 0.0)) and g.width == 0.0 for g in pressed)


def test_robots_of_the_registry_are_whole_and_an_unknown_one_is_named() -> None:
    robots = [load_robot(name) for name in robot_names()]
    assert "PandaOmron" in {robot.id for robot in robots}
    assert all(robot.arms and robot.home for robot in robots)
    with pytest.raises(UnknownId, match="PandaOmron"):
        load_robot("PandaOmro")


def test_what_is_missing_is_told_with_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(CasaError, match=r"pip install --no-deps robosuite==1\.5\.2.*--models"):
        certifying.find_robot_models()
