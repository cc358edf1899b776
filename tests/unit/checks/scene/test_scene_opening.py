"""How scenes are opened, pulled and held, and what lies in a drawer: what the checks say of what is in the way."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

import mujoco
import numpy as np
import pytest

from casa_assets.checks.scene import opening, placement, rest
from casa_assets.checks.scene.formats import formats_agree
from casa_assets.core.numeric import Floats
from casa_assets.mesh.inertia import adjacent_links
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.asset.parts import Box
from casa_assets.model.kitchen.scene import Resting, Scene
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from tests.support.asset.cupboard import cupboard, link_changed, shape, with_shapes
from tests.support.kitchen.rooms import TO_THE_LEFT, at, block, in_all_forms, room, subject

LIMIT = 0.001
Fault = tuple[str, str]
IN_DRAWER = Resting(placement="thing_0", link="drawer", region="drawer_int")


def clashes(scene: Scene, folder: Path) -> list[Fault]:
    return list(opening.joints_open_without_collision(subject(scene, folder), LIMIT).problems)


def post(size: Vec3 = (0.05, 0.05, 0.7), kind: str = "wall_cabinet", base: Base = Base.FIXED) -> Asset:
    return block("post", size, base, kind)


class TestOpening:
    def test_says_which_joint_where_against_what_and_how_deep(self, tmp_path: Path) -> None:
        """The bar of the drawer, whose front is at y = -0.257, meets a post 0.2 m before it: two thirds of 0.3 m."""
        scene = room((cupboard(), at(0.0, 0.0, 0.0)), (post((0.6, 0.05, 0.7)), at(0.0, -0.257 - 0.2 - 0.025, 0.0)))
        found = clashes(scene, tmp_path)
        assert {p for p, _ in found} == {"joints/thing_0__drawer_slide", "joints/thing_0__door_hinge"}
        message = next(s for p, s in found if p.endswith("drawer_slide"))
        assert message.startswith("from 68% of its way thing_0__drawer")
        assert "thing_1__shape_0" in message

    def test_neighbours_clash_only_while_one_is_open_and_not_side_by_side(self, tmp_path: Path) -> None:
        box = cupboard()
        found = clashes(room((box, at(0.0, 0.0, 0.0)), (box, at(0.6, -0.55, 0.0, TO_THE_LEFT))), tmp_path)
        assert found
        assert all("stands open" in message for _, message in found)
        assert {p.split("__")[0] for p, _ in found} == {"joints/thing_0", "joints/thing_1"}
        for gap in (0.002, 0.5):
            assert clashes(room((box, at(0.0, 0.0, 0.0)), (box, at(0.6 + gap, 0.0, 0.0))), tmp_path / f"{gap}") == []

    @pytest.mark.parametrize(("deep", "clash"), [(0.0005, False), (0.002, True)])
    def test_a_corner_that_brushes_past(self, deep: float, clash: bool, tmp_path: Path) -> None:
        """The free end of the door swings past a post; only poses close to each other see it."""
        reach = float(np.hypot(0.55, 0.018))
        hinge = np.array([-0.275, -0.202])
        toward = np.array([np.sin(0.8), -np.cos(0.8)])
        near = hinge + (reach - deep) * toward
        # A thin post whose face looks at the hinge.
        pin = block("pin", (0.004, 0.004, 0.3), shapes=[(Box(size=(0.004, 0.004, 0.3)), (0.0, 0.0, 0.15))])
        half = 0.8 / 2
        x, y = near + 0.002 * toward
        pose = at(float(x), float(y), 0.0, (float(np.cos(half)), 0.0, 0.0, float(np.sin(half))))
        assert bool(clashes(room((cupboard(), at(0.0, 0.0, 0.0)), (pin, pose)), tmp_path)) == clash

    def test_what_touches_at_rest_may_touch_on(self, tmp_path: Path) -> None:
        """A felt that the drawer slides along, 2 mm deep all the way, is no clash of its way."""
        felt = shape("felt", (0.5, 0.3, 0.01), (0.0, -0.02, 0.4315))
        scene = room((with_shapes("object", felt), at(0.0, 0.0, 0.0)))
        found = subject(scene, tmp_path)
        sweeper = opening.JointSweeper(found, LIMIT)
        assert max(sweeper.depths_at_rest.values()) == pytest.approx(0.0015, abs=1e-4)
        pointers = [pointer for pointer, _ in opening.joints_open_without_collision(found, LIMIT).problems]
        assert not any(pointer.endswith("drawer_slide") for pointer in pointers)

    def test_filters_are_put_back(self, tmp_path: Path) -> None:
        found = subject(room((cupboard(), at(0.0, 0.0, 0.0)), (cupboard(), at(0.6, -0.55, 0.0, TO_THE_LEFT))), tmp_path)
        fields = ("geom_contype", "body_conaffinity", "exclude_signature")
        before = [getattr(found.model, field).copy() for field in fields]
        assert len(before[2]) > 0
        opening.joints_open_without_collision(found, LIMIT)
        for field, kept in zip(fields, before, strict=True):
            assert (getattr(found.model, field) == kept).all()


class TestPairsThatTheFileLeavesOut:
    """A simulator does not try a door against its frame and what is beside it; the checks do."""

    def test_a_door_5_mm_in_its_carcass(self, tmp_path: Path) -> None:
        # It has 5 mm of room to either side, and stands 2 mm before the carcass.
        pressed = link_changed("door", pose=cupboard().link("door").pose @ Pose(position=(-0.01, 0.02, 0.0)))
        found = subject(room((pressed, at(0.0, 0.0, 0.0))), tmp_path)
        left_out = mujoco.MjData(found.model)
        mujoco.mj_forward(found.model, left_out)
        assert left_out.ncon == 0
        for check in (rest.no_penetration_at_start, rest.no_penetration_after_settling):
            measured = check(found, LIMIT)
            assert measured.number == pytest.approx(0.005, abs=1e-4)
            assert "mm in thing_0__" in measured.problems[0][1]
        sane = subject(room((cupboard(), at(0.0, 0.0, 0.0))), tmp_path / "sane")
        assert rest.no_penetration_at_start(sane, LIMIT).problems == ()

    def test_a_post_right_before_the_door(self, tmp_path: Path) -> None:
        scene = room((cupboard(), at(0.0, 0.0, 0.0)), (post(), at(0.1, -0.257 - 0.06, 0.0)))
        found = subject(scene, tmp_path)
        left_out = {(m.placement, m.link) for m, f in adjacent_links(scene) if f.placement == "thing_1"}
        assert {("thing_0", "door"), ("thing_0", "drawer")} <= left_out
        pointers = {pointer for pointer, _ in opening.joints_open_without_collision(found, LIMIT).problems}
        assert pointers == {"joints/thing_0__door_hinge", "joints/thing_0__drawer_slide"}
        pulled = dict(opening.joints_open_by_hand(found, 0.95).problems)
        assert "it meets thing_1__shape_0" in pulled["joints/thing_0__door_hinge"]


class TestPulling:
    def test_parts_far_apart_are_pulled_together_and_come_as_far_as_alone(self, tmp_path: Path) -> None:
        box = cupboard()
        alone = opening.pull_all(subject(room((box, at(0.0, 0.0, 0.0))), tmp_path / "one"), 0.95)
        scene = room(*((box, at(1.0 * i - 1.0, 0.0, 0.0)) for i in range(3)))
        found = opening.pull_all(subject(scene, tmp_path / "three"), 0.95)
        assert len(found) == 12
        for name, (share, met) in found.items():
            assert share == pytest.approx(alone[name.replace(name.split("__")[0], "thing_0")][0], abs=0.06)
            assert met == ""

    @pytest.mark.parametrize("blocked", [False, True])
    def test_what_sleeps_meanwhile_changes_nothing(
        self, blocked: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        things = [(cupboard(), at(0.0, 0.0, 0.0)), (post(base=Base.FREE), at(1.0, 0.0, 0.0))]
        if blocked:
            things.append((post((0.6, 0.05, 0.7), base=Base.FREE), at(0.0, -0.4, 0.0)))
        found = subject(room(*things), tmp_path)
        before = found.model.opt.enableflags
        sleeping = opening.pull_all(found, 0.95)
        assert found.model.opt.enableflags == before
        monkeypatch.setattr(opening, "altered", lambda options, **_: nullcontext())
        for name, (share, met) in opening.pull_all(found, 0.95).items():
            assert sleeping[name][0] == pytest.approx(share, rel=1e-4)
            assert sleeping[name][1] == met


def test_the_deepest_of_each_pair_is_told_once(tmp_path: Path) -> None:
    pair = room((cupboard(), at(0.0, 0.0, 0.0)), (cupboard(), at(0.59, 0.0, 0.0)))
    found = placement.fixed_things_do_not_overlap(subject(pair, tmp_path), LIMIT)
    assert found.number == pytest.approx(0.01)
    assert [p for p, _ in found.problems] == ["placements/thing_0"]


def test_what_holds_a_fixed_thing(tmp_path: Path, subtests: pytest.Subtests) -> None:
    wall = block("wall", (2.0, 0.1, 2.5), kind="wall")
    base = block("base", (0.5, 0.5, 0.8), kind="base_cabinet")
    top = block("top", (0.6, 0.6, 0.03), kind="counter")
    shelf = block("shelf", (0.5, 0.2, 0.1), kind="open_shelf")
    upper = block("upper", (0.5, 0.5, 0.3))
    strips = {kind: block(kind, (0.05, 0.02, 0.6), kind=kind) for kind in ("filler", "wall_cabinet")}
    ground = (0.0, 0.0, 0.0)
    cases: list[tuple[str, tuple[tuple[Asset, Vec3], ...], list[str]]] = [
        *(
            (f"a shelf {gap} m from a wall", ((wall, ground), (shelf, (0.0, -0.15 - gap, 1.4))), floats)
            for gap, floats in ((0.0, []), (0.011, []), (0.013, ["thing_1"]))
        ),
        ("a base cabinet does not hang", ((wall, ground), (base, (0.0, -0.3, 0.05))), ["thing_1"]),
        ("a worktop on what stands", ((base, ground), (top, (0.0, 0.0, 0.8005))), []),
        ("a worktop over it", ((base, ground), (top, (0.0, 0.0, 0.81))), ["thing_1"]),
        ("a strip at a side", ((base, ground), (strips["filler"], (0.2755, 0.0, 0.7))), []),
        ("a cupboard at a side", ((base, ground), (strips["wall_cabinet"], (0.2755, 0.0, 0.7))), ["thing_1"]),
        ("on what floats", ((upper, (0.0, 0.0, 1.0)), (upper, (0.0, 0.0, 1.3))), ["thing_0", "thing_1"]),
    ]
    for number, (name, things, floats) in enumerate(cases):
        with subtests.test(name=name):
            scene = subject(room(*((asset, at(*place)) for asset, place in things)), tmp_path / str(number))
            found = placement.fixed_things_are_supported(scene, 0.0).problems
            assert [pointer for pointer, _ in found] == [f"placements/{one}" for one in floats]


def filled(height: float, resting: Resting | None = IN_DRAWER) -> Scene:
    """A cupboard with a box of that height on the floor of its drawer, which is 0.445 m above the ground."""
    box = block("box", (0.1, 0.1, height), Base.FREE, "carton")
    scene = room((cupboard(), at(0.0, 0.0, 0.0)), (box, at(0.1, 0.0, 0.4452)))
    placements = tuple(p.replace(resting=resting) if p.name == "thing_1" else p for p in scene.placements)
    return scene.replace(placements=placements)


@pytest.mark.parametrize(
    ("height", "resting", "clash"),
    [(0.05, IN_DRAWER, False), (0.05, None, True), (0.2, IN_DRAWER, True)],
)
def test_drawer_opens_with_what_fits_in_it(height: float, resting: Resting | None, clash: bool, tmp_path: Path) -> None:
    found = opening.joints_open_without_collision(subject(filled(height, resting), tmp_path), LIMIT)
    clashing = [message for pointer, message in found.problems if pointer == "joints/thing_0__drawer_slide"]
    assert bool(clashing) == clash
    if resting and clash:
        assert "thing_1" in clashing[0]


def resting(asset: Asset, where: Resting) -> Scene:
    scene = room((cupboard(), at(0.0, 0.0, 0.0)), (asset.replace(id="small_cupboard"), at(1.5, 0.0, 0.0)))
    kept = tuple(p.replace(resting=where) if p.name == "thing_1" else p for p in scene.placements)
    return scene.replace(placements=kept)


def moved(scene: Scene, folder: Path, body: str) -> tuple[Floats, mujoco.MjData]:
    """How far a body is from its place as the scene begins in the pose `open`, which both formats have alike."""
    files = in_all_forms(scene, folder)
    model = mujoco.MjModel.from_xml_path(str(files.scene_subject.mjcf))
    data, places = mujoco.MjData(model), []
    for pose in ("start", "open"):
        mujoco.mj_resetDataKeyframe(model, data, model.key(pose).id)
        mujoco.mj_kinematics(model, data)
        places.append(data.body(body).xpos.copy())
    assert formats_agree(files, 0.0).problems == ()
    return places[1] - places[0], data


def test_it_is_in_the_open_drawer_of_the_open_pose_with_all_its_links(tmp_path: Path) -> None:
    box, _ = moved(filled(0.05), tmp_path / "box", "thing_1")
    assert box == pytest.approx([0.0, -0.28, 0.0], abs=1e-6)
    jar = resting(cupboard().replace(base=Base.FREE), IN_DRAWER)
    assert moved(jar, tmp_path / "jar", "thing_1__drawer")[0] == pytest.approx([0.0, -0.28, 0.0], abs=1e-6)


def test_an_object_stays_closed_where_the_kitchen_is_open(tmp_path: Path) -> None:
    on_top = Resting(placement="thing_0", link=cupboard().root.name, region="top")
    _, data = moved(resting(cupboard(), on_top), tmp_path, "thing_1")
    assert data.joint("thing_0__drawer_slide").qpos[0] > 0.2
    assert data.joint("thing_1__drawer_slide").qpos[0] == 0.0
