"""Checks of assets, their looks, and of what is built: each code is silent on what is right, and speaks alone."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from casa_assets.checks.asset import visual
from casa_assets.checks.check import Package, run
from casa_assets.checks.motion import joints, simulation
from casa_assets.checks.table import TABLE
from casa_assets.model.asset.asset import Asset, Collider, Drive, State
from casa_assets.model.asset.parts import Box, Sphere
from casa_assets.model.issue import Report
from casa_assets.model.pose import Pose
from tests.support.asset import box_assets as boxes
from tests.support.asset import cupboard as made
from tests.support.asset.asset_parts import box_inertial
from tests.support.asset.assets import ball, category, drawer_unit, microwave, textured_box
from tests.support.asset.examples import between, check_examples
from tests.support.asset.packages import LIMITS, codes, judged, number, packed, written
from tests.support.mesh.meshes import box_mesh

Build = Callable[[], Asset]


def pressed_against_a_soft_stop() -> Asset:
    """The spring of its key is held by a limit as soft as MuJoCo's own."""
    return made.joint_changed("key_press", limit_impedance=(0.9, 0.95, 0.001, 0.5, 2.0), limit_margin=0.0)


def sprung(stiffness: float, target: float) -> Asset:
    """Its drawer has a spring."""
    return made.joint_changed("drawer_slide", drive=Drive(stiffness=stiffness, damping=0.0, target=target))


def hung() -> Asset:
    """Its drawer falls out."""
    return made.joint_changed("drawer_slide", axis=(0.0, 0.0, -1.0))


def framed_handle(gap: float) -> Asset:
    """The handle of its drawer lies on a block, with a ledge so much above it, metres."""
    block = made.shape("block", (0.3, 0.022, 0.06), (0.0, -0.231, 0.515))
    ledge = made.shape("ledge", (0.3, 0.036, 0.02), (0.0, -0.238, 0.532 + gap))
    return made.with_shapes("drawer", block, ledge)


# Code -> what it is silent on, and what trips it alone.
OF_BUILT: dict[str, tuple[Build, Build]] = {
    "AST017": (made.cupboard, lambda: made.with_mass_within(0.05)),
    "VIS009": between(made.pictured_at, 1.01, 1.03),
    "VIS010": between(made.with_trim, 0.0005, 0.0),
    "KIN001": between(made.caught_by, -0.00005, 0.00045),
    "KIN002": (made.cupboard, lambda: made.joint_changed("drawer_slide", damping=200.0)),
    "KIN003": between(lambda n: made.joint_changed("drawer_slide", frictionloss=n), 0.3, 0.1),
    "KIN004": between(lambda n: made.joint_changed("key_press", frictionloss=n), 0.5, 2.5),
    "KIN005": between(made.with_pointer, 0.06, 0.16),
    "KIN006": between(lambda n: sprung(n, 0.0), 15.0, 40.0),
    "KIN007": (made.cupboard, lambda: made.joint_changed("drawer_slide", grip=None)),
    "KIN008": between(lambda x: made.joint_changed("door_hinge", axis=(x, 0.0, math.sqrt(1 - x * x))), 0.0, 0.001),
    "KIN009": (microwave, lambda: microwave().replace(joints=(microwave().joints[0].replace(damping=200.0),))),
    "KIN010": (made.cupboard, pressed_against_a_soft_stop),
    "KIN011": between(framed_handle, 0.015, 0.009),
    "HOL001": (made.cupboard, lambda: made.filled_to(0.1)),
}


@pytest.mark.parametrize("code", OF_BUILT)
def test_each_code_is_tripped_by_its_fault_alone(code: str, tmp_path: Path) -> None:
    check_examples(code, *(judged(make(), tmp_path) for make in OF_BUILT[code]))


def test_good_is_silent_in_both_formats_and_what_came_as_a_mesh_is_left_to_the_other_rows(tmp_path: Path) -> None:
    good = made.cupboard()
    for subject in (good, written(good, tmp_path)):
        assert run(subject, good.id, LIMITS).issues == ()
    rows = [check for check in TABLE if check.code.startswith(("AST017", "VIS009", "VIS010", "KIN", "HOL"))]
    for asset in (microwave(), drawer_unit()):
        for subject in (asset, packed(asset, tmp_path)):
            assert run(subject, asset.id, LIMITS, table=rows).issues == ()


class TestForce:
    @pytest.mark.parametrize("make", [lambda: sprung(60.0, 0.12), hung], ids=["sprung", "hung"])
    def test_a_drawer_that_opens_by_itself(self, make: Build, tmp_path: Path) -> None:
        (found,) = (issue for issue in judged(make(), tmp_path).issues if issue.code == "KIN003")
        assert (found.pointer, "opens by itself" in found.message) == ("joints/drawer_slide", True)

    @pytest.mark.parametrize(("share", "moves"), [(0.9, False), (1.1, True)])
    @pytest.mark.parametrize("name", ["door_hinge", "drawer_slide", "knob_turn", "key_press"])
    def test_the_least_force_is_the_one_that_moves_it(
        self, name: str, share: float, moves: bool, tmp_path: Path
    ) -> None:
        """What the formula says is what the simulator does."""
        asset = made.cupboard()
        motion = simulation.motion_model_of(packed(asset, tmp_path))
        data = mujoco.MjData(motion.contactless)
        joint = {j.name: j for j in asset.joints}[name]
        effort = joints.starting_force(motion, data, asset, joint) * joints.hand_effort(asset, joint) / joints.PULL_N
        mujoco.mj_resetData(motion.contactless, data)
        data.qfrc_applied[motion.dof[name]] = math.copysign(share * effort, simulation.open_end(joint))
        mujoco.mj_step(motion.contactless, data, nstep=500)
        # A tenth less lets it yield a little, since stops and friction are soft.
        assert (float(data.qpos[motion.address[name]]) / simulation.open_end(joint) > 0.02) == moves

    def test_nobody_turns_harder_than_the_cap_and_a_key_need_not_stay_pressed(self, tmp_path: Path) -> None:
        """A named pose in which a key is held down is no pose of rest for it."""
        long = made.with_grip("door_hinge", Box(size=(0.014, 0.014, 0.14)), pose=Pose(position=(1.5, -0.048, 0.0)))
        assert joints.hand_effort(long, long.joints[0]) == joints.MAX_TORQUE_NM
        whole = made.cupboard()
        opened = whole.keyframes[1]
        held = opened.joints[0].replace(joint="key_press", value=0.004)
        pressed = whole.replace(keyframes=(whole.keyframes[0], opened.replace(joints=(*opened.joints, held))))
        assert codes(pressed, tmp_path) == set()


class TestClearance:
    def test_excluded_pairs_count(self, tmp_path: Path) -> None:
        """Loaders drop what a model excludes; the row for what came as a mesh heeds it."""
        bar = made.shape("bar", (0.02, 0.2, 0.02), (-0.2, -0.3, 0.2))
        barred = made.with_shapes("object", bar)
        assert {"KIN005", "MJC009"} <= codes(barred, tmp_path)
        excluded = barred.replace(exclusions=({"first": "object", "second": "door"},))
        assert codes(excluded, tmp_path) & {"KIN005", "MJC009"} == {"KIN005"}

    @pytest.mark.parametrize("at", np.linspace(-0.1, -0.112, 7))
    def test_thin_parts_that_pass_between_two_poses_meet(self, at: float, tmp_path: Path) -> None:
        """A fin of 4 mm on the drawer passes one of 4 mm on the carcass; poses are 12 mm apart."""
        fin = made.shape("fin", (0.02, 0.004, 0.04), (0.26, 0.0, 0.5))
        stop = made.shape("stop", (0.02, 0.004, 0.04), (0.272, float(at), 0.5))
        drawer = made.with_shapes("drawer", fin)
        both = drawer.replace(links=(made.with_shapes("object", stop).root, *drawer.links[1:]))
        (found,) = [i for i in judged(both, tmp_path).issues if i.code == "KIN005"]
        assert (found.pointer, "fin" in found.message and "stop" in found.message) == ("joints/drawer_slide", True)

    def test_a_rack_comes_out_of_an_open_oven(self, tmp_path: Path) -> None:
        """A board comes out of the lower room where the door has to open first, and else runs into the door."""

        def oven(behind: str | None) -> Asset:
            whole = made.cupboard()
            grip = made.shape("rack_grip", (0.3, 0.3, 0.01), (0.0, -0.02, 0.1)).replace(label="rack")
            look = whole.link("key").visuals[0]
            rack = whole.link("drawer").replace(
                name="rack",
                visuals=(look.replace(name="rack_look", mesh=box_mesh((0.3, 0.3, 0.01), (0.0, -0.02, 0.1))),),
                colliders=(grip,),
                inertial=box_inertial(1.0, (0.3, 0.3, 0.01), (0.0, -0.02, 0.1)),
            )
            slide = whole.joints[1].replace(name="rack_slide", child="rack", grip="rack_grip", behind=behind)
            regions = tuple(r for r in whole.regions if r.name != "int")
            return whole.replace(links=(*whole.links, rack), joints=(*whole.joints, slide), regions=regions)

        assert codes(oven("door_hinge"), tmp_path) == set()
        assert {"KIN001", "KIN005", "MJC009"} <= codes(oven(None), tmp_path)


def test_other_grips_that_are_wrong(subtests: pytest.Subtests) -> None:
    buried = Pose(position=(0.0, -0.211, 0.515))
    for asset, message in [
        (made.with_grip("knob_turn", made.ball_of(0.04), label="panel"), "labelled 'panel'"),
        (made.joint_changed("door_hinge", grip="drawer_handle"), "does not move with it"),
        (made.with_grip("knob_turn", made.ball_of(0.09)), "no gripper holds that"),
        (made.with_grip("key_press", Box(size=(0.03, 0.001, 0.03))), "no gripper holds that"),
        (made.with_grip("door_hinge", Box(size=(0.003, 0.003, 0.14))), "find no hold"),
        (made.with_grip("drawer_slide", Box(size=(0.1, 0.014, 0.014)), pose=buried), "buried"),
    ]:
        with subtests.test(message=message):
            (issue,) = [i for i in run(asset, asset.id, LIMITS).issues if i.code == "KIN007"]
            assert message in issue.message


class TestInterior:
    def test_mass_beside_the_hull(self) -> None:
        """Within the box around a bent thing, but outside its hull."""
        inertial = made.cupboard().link("door").inertial.replace(center_of_mass=(0.02, -0.05, 0.18))
        (issue,) = run(made.link_changed("door", inertial=inertial), "cupboard", LIMITS).issues
        assert (issue.code, issue.pointer) == ("AST017", "links/door/inertial")

    def test_a_block_that_hangs_from_the_top_and_a_solid_drawer(self, tmp_path: Path) -> None:
        (issue,) = judged(made.filled_to(-0.1), tmp_path).issues
        assert (issue.code, issue.pointer) == ("HOL001", "regions/int")
        assert "does not pass" in issue.message
        solid = made.with_shapes("drawer", made.shape("matter", (0.3, 0.2, 0.06), (0.0, -0.02, 0.475)))
        assert [(i.code, i.pointer) for i in judged(solid, tmp_path).issues] == [("HOL001", "regions/drawer_int")]

    def test_a_region_without_a_floor_and_a_slot_that_gets_a_smaller_ball(self, tmp_path: Path) -> None:
        whole = made.cupboard()
        high = whole.regions[1].replace(pose=Pose(position=(0.0, -0.01, 0.3)), size=(0.54, 0.36, 0.2))
        bad = whole.replace(regions=(whole.regions[0], high, whole.regions[2]))
        (issue,) = judged(bad, tmp_path).issues
        assert (issue.code, issue.pointer) == ("HOL001", "regions/int")
        assert number("HOL001", bad, tmp_path) == pytest.approx(0.18, abs=0.005)
        slot = whole.regions[1].replace(pose=Pose(position=(0.0, -0.01, 0.06)), size=(0.2, 0.03, 0.08))
        walls = (made.shape(f"w_{k}", (0.2, 0.01, 0.08), (0.0, (-0.031, 0.011)[k], 0.06)) for k in range(2))
        toaster = made.with_shapes("object", *walls).replace(regions=(whole.regions[0], slot, whole.regions[2]))
        assert codes(toaster, tmp_path) == set()


class TestLooks:
    def test_a_picture_without_coordinates(self) -> None:
        panel = made.cupboard().link("door").visuals[0]
        bare = made.link_changed("door", visuals=(panel.replace(mesh=panel.mesh.replace(uv=None)),))
        (issue,) = (i for i in run(bare, bare.id, LIMITS).issues if i.code == "VIS009")
        assert "no texture coordinates" in issue.message

    def test_what_flickers(self, subtests: pytest.Subtests) -> None:
        for asset, flickers in [
            (made.with_trim(0.0, "oak"), False),  # the same finish without a picture looks the same
            (made.with_trim(0.01), False),  # lies on the door: the faces that touch look at each other
            (made.with_trim(0.00025), False),
            (made.with_trim(0.0001), True),
            (made.with_trim(-0.0001), True),
        ]:
            with subtests.test(flickers=flickers):
                assert ("VIS010" in {i.code for i in run(asset, asset.id, LIMITS).issues}) == flickers

    def test_flicker_is_found_wherever_it_is(self, subtests: pytest.Subtests) -> None:
        """No place or direction falls between the bins that faces are sorted into."""
        asset = made.with_trim(0.0)
        for shift, turn in itertools.product(np.arange(12) * 0.0001, (0.0, 0.3, math.pi / 4)):
            with subtests.test(turn=turn, shift=shift):
                at, turned = (-0.275, -0.202 + float(shift), 0.205), (math.cos(turn / 2), 0.0, 0.0, math.sin(turn / 2))
                door = asset.link("door").replace(pose=Pose(position=at, quaternion=turned))
                moved = asset.replace(links=tuple(door if k.name == "door" else k for k in asset.links))
                found = visual.coplanar_faces_do_not_overlap(moved, LIMITS["flicker_m2"]).number
                assert found == pytest.approx(0.4 * 0.02, rel=1e-6)


ROWS = {check.code: check for check in TABLE if check.code.startswith(("AST", "VIS"))}

SIDE = boxes.side()

# Code -> what it is silent on, and what trips it alone.
OF_ASSETS: dict[str, tuple[Build, Build]] = {
    "AST001": between(boxes.plain_box, (4.9, 1.0, 1.0), (5.1, 1.0, 1.0)),
    "AST002": between(boxes.plain_box, (0.2, 0.1, 0.0006), (0.2, 0.1, 0.0004)),
    "AST003": between(boxes.as_dense_as, 19.0, 21.0),
    "AST004": between(boxes.as_dense_as, 0.06, 0.04),
    "AST005": between(boxes.sliced, 32, 33),
    "AST006": between(boxes.cornered, 64, 72),
    "AST007": between(boxes.dented, 0.0, 2e-5),
    "AST008": between(boxes.balanced_at, 0.099, 0.101),
    "AST009": between(boxes.short_by, 0.0039, 0.0041),
    "AST010": (lambda: boxes.plain_box(up=0.0009), lambda: boxes.plain_box(up=0.0011)),
    "AST011": between(boxes.licensed, "CC0-1.0", "unknown"),
    "AST012": (boxes.plain_box, boxes.touched),
    "AST013": (lambda: boxes.plain_box((0.3, 0.3, 0.3), 60.0), lambda: boxes.plain_box((0.3, 0.3, 0.3), 80.0)),
    "AST014": (lambda: boxes.plain_box((1.1, 0.3, 0.3), 20.0), lambda: boxes.plain_box((1.3, 0.3, 0.3), 20.0)),
    "AST015": (lambda: boxes.opening(0.0, 1.5, True), lambda: boxes.opening(-1.5, 1.5, True)),
    "AST016": between(boxes.gapped, 0.002, 0.1),
    "AST018": between(boxes.plugged, 0.02, 0.04),
    "VIS001": (textured_box, boxes.with_sliver),
    "VIS002": (lambda: boxes.shown(SIDE), lambda: boxes.shown(boxes.turned(SIDE, faces=False))),
    "VIS003": (lambda: boxes.lined(0.01), boxes.half_turned),
    "VIS004": between(boxes.finer_ball, 600, 700),
    "VIS005": (lambda: boxes.pictured(4), lambda: boxes.pictured(4, unwrapped=False)),
    "VIS006": between(boxes.pictured, 2048, 2049),
    "VIS007": between(boxes.with_fin, 4, 3),
    "VIS008": (lambda: boxes.shown(boxes.side(1), boxes.side(2)), lambda: boxes.shown(SIDE, SIDE)),
}


def told_of(asset: Asset) -> Report:
    return run(asset, asset.id, LIMITS, table=ROWS.values())


def told_as(code: str, asset: Asset) -> Report:
    """With the rows that look at packages where the code is one of theirs; they look at no file."""
    package = Package(asset, category(asset), Path("nowhere"))
    whole = told_of(asset)
    return whole + run(package, asset.id, LIMITS, table=ROWS.values()) if ROWS[code].subject is Package else whole


def codes_alone(asset: Asset) -> set[str]:
    return {issue.code for issue in told_of(asset).issues}


EXAMPLES: dict[str, tuple[Build, Build]] = {**OF_BUILT, **OF_ASSETS}


@pytest.mark.parametrize("code", OF_ASSETS)
def test_each_code_of_assets_is_tripped_by_its_fault_alone(code: str, tmp_path: Path) -> None:
    """The good one is silent on every row of its subject, files included."""
    good, bad = (make() for make in OF_ASSETS[code])
    check_examples(code, told_as(code, good), told_as(code, bad), parted=True)
    subject = good if ROWS[code].subject is Asset else written(good, tmp_path)
    assert run(subject, good.id, LIMITS).issues == ()


# Code -> a second way to trip it alone; without one what looks odd and is right.
ALSO: list[tuple[str, Build]] = [
    ("AST007", boxes.opened),
    ("AST008", lambda: boxes.spread_over(0.21)),
    ("AST009", lambda: boxes.short_by(0.05, (2.0, 1.0, 1.0))),
    ("AST009", lambda: boxes.short_by(0.012, (2.0, 1.0, 1.0)).replace(provenance=made.cupboard().provenance)),
    ("AST011", lambda: boxes.licensed("")),
    ("AST015", lambda: boxes.opening(0.1, 1.5, False)),
    ("VIS002", lambda: boxes.shown(SIDE.replace(normals=2 * np.asarray(SIDE.normals)))),
    ("VIS003", lambda: boxes.shown(boxes.turned(SIDE))),
    ("VIS005", lambda: boxes.pictured(4).replace(links=boxes.shown(SIDE.replace(uv=0 * np.asarray(SIDE.uv))).links)),
    ("VIS006", lambda: boxes.pictured(64, stated_px=32)),
    ("VIS008", lambda: boxes.shown(SIDE, SIDE.replace(faces=np.roll(SIDE.faces[::-1], 1, axis=1)))),
    ("", lambda: boxes.short_by(0.035, (2.0, 1.0, 1.0))),
    ("", lambda: boxes.spread_over(0.19)),
    ("", lambda: boxes.opening(-1.5, 0.0, True)),
    ("", lambda: boxes.opening(-1.5, 1.5, False)),
    ("", lambda: boxes.shown(SIDE.replace(normals=None))),
    ("", lambda: boxes.shown(SIDE, boxes.turned(SIDE))),  # seen from both sides
    *(("", make) for make in (ball, textured_box, microwave)),
]


def test_other_ways_to_be_wrong_and_what_is_right_though_odd(subtests: pytest.Subtests) -> None:
    for code, make in ALSO:
        with subtests.test(code=code, make=make):
            assert codes_alone(make()) == ({code} if code else set())


def test_every_link_is_looked_at_and_a_state_asks_for_an_end_at_zero() -> None:
    oven = microwave()
    door = oven.link("door").replace(inertial=box_inertial(80.0, (0.38, 0.02, 0.28), (0.19, -0.01, 0.0)))
    (issue,) = told_of(oven.replace(links=(oven.root, door))).issues
    assert (issue.code, issue.pointer) == ("AST003", "links/door/inertial")
    knob = boxes.opening(-1.5, 1.5, False)
    stated = knob.replace(states=(State(name="on", joint="microjoint", value="on", interval=(0.5, 1.0)),))
    assert (codes_alone(knob), codes_alone(stated)) == (set(), {"AST015"})


def test_what_is_neither_seen_nor_touched_does_not_stop_the_checks() -> None:
    assert told_as("AST014", boxes.linked(visuals=(), colliders=())).issues == ()
    touched = Collider(name="ball", shape=Sphere(radius=0.1), substance="cardboard")
    assert "AST009" not in codes_alone(boxes.linked(visuals=(), colliders=(touched,)))
