"""Checks of whole scenes, how they are opened, pulled and held, and what lies in a drawer."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

import mujoco
import numpy as np
import pytest

from casa_assets.checks.scene import opening, placement, rest
from casa_assets.checks.scene.formats import formats_agree
from casa_assets.checks.scene.placement import visible_wall_shares
from casa_assets.checks.scene.subject import SceneSubject
from casa_assets.checks.table import TABLE, UNLOADED, run_scene
from casa_assets.core.numeric import Floats
from casa_assets.mesh.inertia import adjacent_links
from casa_assets.mesh.solid.solids import convex_hull
from casa_assets.model.asset.asset import Asset, Base, Drive
from casa_assets.model.asset.parts import Box, Hull, Mesh, Sphere
from casa_assets.model.issue import Status
from casa_assets.model.kitchen.scene import Camera, Resting, Scene
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from tests.support.asset.cupboard import cupboard, joint_changed, link_changed, shape, with_shapes
from tests.support.asset.examples import LIMITS, between, check_examples
from tests.support.kitchen.rooms import TO_THE_LEFT, at, block, in_all_forms, judged, room, subject

ROWS = {check.code: check for check in TABLE if check.subject is SceneSubject}
Change = tuple[str, str]
# A scene, and what is changed of its file.
Build = Callable[[], tuple[Scene, *tuple[Change, ...]]]
QUICK = ('timestep="0.002"', 'timestep="0.01"')
AHEAD, DOWN = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
CRATE: Vec3 = (0.2, 0.2, 0.2)
SMALL: Vec3 = (0.05, 0.05, 0.05)
SLICE = Box(size=(0.05, 0.05, 0.01))


def crate(base: Base = Base.FREE, size: Vec3 = CRATE, kind: str = "wall_cabinet") -> Asset:
    return block("crate", size, base, kind)


def lying(sunk: float = 0.0, gravity: float = 9.81) -> Scene:
    return room((crate(), at(0.0, 0.0, -sunk)), gravity=gravity)


def drawer(**changes: object) -> tuple[Scene]:
    return (room((joint_changed("drawer_slide", **changes), at(0.0, 0.0, 0.0))),)


def fixed(*places: Vec3) -> tuple[Scene]:
    return (room(*((crate(Base.FIXED), at(*place)) for place in places)),)


def round_a_corner(gap: float) -> Scene:
    """Two cupboards at right angles, with so much between their fronts and sides; both have drawers of 0.3 m."""
    return room((cupboard(), at(0.0, 0.0, 0.0)), (cupboard(), at(0.3 + gap + 0.2, -0.55, 0.0, TO_THE_LEFT)))


def grid(asset: Asset, count: int, apart: float = 0.09) -> Scene:
    side = int(np.ceil(np.sqrt(count)))
    start = -apart * (side - 1) / 2
    return room(*((asset, at(start + apart * (i % side), start + apart * (i // side), 0.0)) for i in range(count)))


def stacked(shape: Box | Hull, count: int, step: float = 0.01) -> Asset:
    size: Vec3 = (0.05, 0.05, step * count)
    return block("pile", size, shapes=[(shape, (0.0, 0.0, step * (i + 0.5))) for i in range(count)])


def cushion() -> Hull:
    """A hull of 62 vertices, 2 cm across."""
    turn = np.linspace(0.0, 2 * np.pi, 31)[:-1]
    ring = np.column_stack([0.01 * np.cos(turn), 0.01 * np.sin(turn)])
    points = [*((x, y, z) for x, y in ring for z in (-0.002, 0.002)), (0.0, 0.0, -0.004), (0.0, 0.0, 0.004)]
    vertices, faces = convex_hull(np.array(points))
    return Hull(mesh=Mesh(vertices=vertices, faces=faces))


def footed(feet: int) -> Asset:
    spread = np.linspace(-0.02, 0.02, feet)
    balls = [(Sphere(radius=0.005), (float(x), 0.02 * (-1) ** i, 0.005)) for i, x in enumerate(spread)]
    body = (Box(size=(0.05, 0.05, 0.03)), (0.0, 0.0, 0.03))
    return block("thing", SMALL, Base.FREE, shapes=[*balls, body])


def picture(side: int) -> Change:
    made = f'<texture name="big" type="2d" builtin="flat" width="{side}" height="{side}" rgb1="1 1 1"/>'
    return ("<asset>", f"<asset>{made}")


def looked_at(way: tuple[float, float, float, float]) -> Scene:
    wall = block("wall", (4.0, 0.1, 2.5), kind="wall")
    eye = Camera(name="eye", pose=at(0.0, -0.5, 1.5, way), fov_y_deg=40.0)
    return room((wall, at(0.0, 1.9, 0.0))).replace(cameras=(eye,))


# Code -> what it is silent on, and what trips it alone.
EXAMPLES: dict[str, tuple[Build, Build]] = {
    "SCN001": (lambda: (lying(),), lambda: (lying(), ("<statistic ", '<statistic meaninertia="1" '))),
    "SCN002": between(lambda sunk: (lying(sunk),), 0.0004, 0.0008),
    "SCN003": between(lambda gravity: (lying(gravity=gravity),), 20.0, 4000.0),
    # A spring draws it out; friction holds it up to 50 N/m.
    "SCN004": between(lambda n: drawer(drive=Drive(stiffness=n, damping=0.0, target=0.12)), 20.0, 90.0),
    "SCN005": between(lambda gap: (round_a_corner(gap),), 0.65, 0.1),
    "SCN006": between(lambda force: drawer(frictionloss=force), 8.0, 21.0),
    "SCN007": between(lambda deep: fixed((0.0, 0.0, 0.0), (0.2 - deep, 0.0, 0.0)), 0.0008, 0.0012),
    "SCN008": between(lambda height: fixed((0.0, 0.0, height)), 0.0015, 0.0025),
    "SCN009": between(lambda edge: fixed((1.9 + edge, 0.0, 0.0)), 0.004, 0.006),
    "SCN010": between(lambda count: (grid(block("brick", SMALL), count),), 390, 400),
    "SCN011": between(lambda height: (lying(-height),), 0.004, 0.006),
    "SCN012": between(lambda count: (grid(stacked(SLICE, 50), count),), 39, 40),
    "SCN013": between(lambda count: (grid(crate(size=SMALL), count), QUICK), 66, 67),
    "SCN014": between(lambda count: (grid(stacked(cushion(), 10), count),), 40, 52),
    "SCN015": between(lambda side: (lying(), picture(side)), 9000, 9400),
    "SCN016": between(lambda feet: (grid(footed(feet), 60), QUICK), 4, 6),
    "SCN023": between(lambda way: (looked_at(way),), AHEAD, DOWN),
}


@pytest.mark.parametrize("code", EXAMPLES)
def test_each_code_is_tripped_by_its_fault_alone(code: str, tmp_path: Path) -> None:
    good, bad = (make() for make in EXAMPLES[code])
    check_examples(code, judged(good[0], tmp_path / "good", *good[1:]), judged(bad[0], tmp_path / "bad", *bad[1:]))


def test_every_row_reports_its_number(tmp_path: Path) -> None:
    report = judged(room((cupboard(), at(0.0, 0.0, 0.0)), (crate(), at(0.0, 0.0, 0.7))), tmp_path)
    assert report.issues == ()
    assert [r.code for r in report.results] == sorted(ROWS)
    found = {r.code: r.number for r in report.results}
    assert (found["SCN010"], found["SCN012"], found["SCN013"]) == (8, 1 + 7 + 2 + 6 + 2 + 1, 4 + 6)
    assert found["SCN006"] == pytest.approx(1.0, abs=0.05)


def test_what_does_not_load_is_said_once(tmp_path: Path) -> None:
    report = judged(lying(), tmp_path, ("<worldbody>", '<worldbody><geom type="mesh" mesh="none"/>'))
    expected = dict.fromkeys(ROWS, Status.NOT_RUN) | {"SCN001": Status.FAILED}
    assert {r.code: r.status for r in report.results} == expected
    assert {r.reason for r in report.results} == {"", UNLOADED}
    assert [i.pointer for i in report.issues] == ["scene.xml"]


def test_waived_rows_do_not_run(tmp_path: Path) -> None:
    report = run_scene(subject(*fixed((0.0, 0.0, 0.1)), tmp_path), LIMITS, {"SCN008": "it hangs from a wire"})
    (waived,) = [r for r in report.results if r.code == "SCN008"]
    assert (waived.status, waived.waived, waived.reason) == (Status.NOT_RUN, True, "it hangs from a wire")
    assert report.issues == ()
    assert report.passed


def test_a_camera_looks_through_the_wall_that_it_is_behind_and_through_nothing_else(tmp_path: Path) -> None:
    """From behind the near wall, over half a metre of it, the far one is seen as if there were no other."""
    scene = looked_at(AHEAD)
    near = scene.placements[-1].replace(name="near", pose=at(0.0, -1.9, 0.0, (0.0, 0.0, 0.0, 1.0)))
    eye = scene.cameras[0].replace(pose=at(0.0, -4.5, 1.5, AHEAD))
    both = scene.replace(placements=(*scene.placements, near), cameras=(eye,))
    seen = visible_wall_shares(subject(both, tmp_path / "both"))
    assert seen["thing_0"] > 0.2
    assert seen["near"] == 0.0
    bare = visible_wall_shares(subject(scene, tmp_path / "bare"))["thing_0"]
    screen = block("screen", (2.0, 0.05, 2.4), kind="pantry")
    more = room((scene.assets[-1], at(0.0, 1.9, 0.0)), (screen, at(-1.0, 0.5, 0.0))).replace(cameras=scene.cameras)
    assert visible_wall_shares(subject(more, tmp_path / "more"))["thing_0"] == pytest.approx(bare / 2, rel=0.1)


def test_what_mujoco_warns_of_leaves_no_log_in_the_working_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    report = judged(lying(), tmp_path, ("<statistic ", '<statistic meaninertia="1" '))
    assert "SCN001" in {issue.code for issue in report.issues}
    assert list(here.iterdir()) == []


LIMIT = 0.001
OPEN_INTO = room((cupboard(), at(0.0, 0.0, 0.0)), (cupboard(), at(0.6, -0.55, 0.0, TO_THE_LEFT)))
IN_DRAWER = Resting(placement="thing_0", link="drawer", region="drawer_int")


def clashes(found: SceneSubject) -> dict[str, str]:
    """Pointer -> what is in the way of it."""
    return dict(opening.joints_open_without_collision(found, LIMIT).problems)


def post(size: Vec3 = (0.05, 0.05, 0.7), base: Base = Base.FIXED) -> Asset:
    return block("post", size, base)


class TestOpening:
    def test_says_which_joint_where_against_what_and_how_deep(self, tmp_path: Path) -> None:
        """The bar of the drawer, whose front is at y = -0.257, meets a post 0.2 m before it: two thirds of 0.3 m."""
        scene = room((cupboard(), at(0.0, 0.0, 0.0)), (post((0.6, 0.05, 0.7)), at(0.0, -0.257 - 0.2 - 0.025, 0.0)))
        found = clashes(subject(scene, tmp_path))
        assert found.keys() == {"joints/thing_0__drawer_slide", "joints/thing_0__door_hinge"}
        message = found["joints/thing_0__drawer_slide"]
        assert message.startswith("from 68% of its way thing_0__drawer")
        assert "thing_1__shape_0" in message

    def test_neighbours_clash_only_while_one_is_open_and_not_side_by_side(self, tmp_path: Path) -> None:
        found = clashes(subject(OPEN_INTO, tmp_path))
        assert all("stands open" in message for message in found.values())
        assert {pointer.split("__")[0] for pointer in found} == {"joints/thing_0", "joints/thing_1"}
        for gap in (0.002, 0.5):
            scene = room((cupboard(), at(0.0, 0.0, 0.0)), (cupboard(), at(0.6 + gap, 0.0, 0.0)))
            assert clashes(subject(scene, tmp_path / f"{gap}")) == {}

    @pytest.mark.parametrize(("deep", "clash"), [(0.0005, False), (0.002, True)])
    def test_a_corner_that_brushes_past(self, deep: float, clash: bool, tmp_path: Path) -> None:
        """The free end of the door swings past a post; only poses close to each other see it."""
        # A thin post whose face, 2 mm before its middle, looks at the hinge.
        apart = math.hypot(0.55, 0.018) - deep + 0.002
        x, y = -0.275 + apart * math.sin(0.8), -0.202 - apart * math.cos(0.8)
        pin = block("pin", (0.004, 0.004, 0.3))
        pose = at(x, y, 0.0, (math.cos(0.4), 0.0, 0.0, math.sin(0.4)))
        assert bool(clashes(subject(room((cupboard(), at(0.0, 0.0, 0.0)), (pin, pose)), tmp_path))) == clash

    def test_what_touches_at_rest_may_touch_on(self, tmp_path: Path) -> None:
        """A felt that the drawer slides along, 2 mm deep all the way, is no clash of its way."""
        felt = shape("felt", (0.5, 0.3, 0.01), (0.0, -0.02, 0.4315))
        found = subject(room((with_shapes("object", felt), at(0.0, 0.0, 0.0))), tmp_path)
        sweeper = opening.JointSweeper(found, LIMIT)
        assert max(sweeper.depths_at_rest.values()) == pytest.approx(0.0015, abs=1e-4)
        assert "joints/thing_0__drawer_slide" not in clashes(found)

    def test_filters_are_put_back(self, tmp_path: Path) -> None:
        found = subject(OPEN_INTO, tmp_path)
        fields = ("geom_contype", "body_conaffinity", "exclude_signature")
        before = [getattr(found.model, field).copy() for field in fields]
        assert len(before[2]) > 0
        assert clashes(found)
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
        assert clashes(found).keys() == {"joints/thing_0__door_hinge", "joints/thing_0__drawer_slide"}
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
        ("a shelf at a wall", ((wall, ground), (shelf, (0.0, -0.15, 1.4))), []),
        ("a shelf 11 mm from it", ((wall, ground), (shelf, (0.0, -0.161, 1.4))), []),
        ("a shelf 13 mm from it", ((wall, ground), (shelf, (0.0, -0.163, 1.4))), ["thing_1"]),
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
    return with_resting(room((cupboard(), at(0.0, 0.0, 0.0)), (box, at(0.1, 0.0, 0.4452))), resting)


def with_resting(scene: Scene, resting: Resting | None) -> Scene:
    *others, thing = scene.placements
    return scene.replace(placements=(*others, thing.replace(resting=resting)))


@pytest.mark.parametrize(
    ("height", "resting", "clash"), [(0.05, IN_DRAWER, False), (0.05, None, True), (0.2, IN_DRAWER, True)]
)
def test_drawer_opens_with_what_fits_in_it(height: float, resting: Resting | None, clash: bool, tmp_path: Path) -> None:
    told = clashes(subject(filled(height, resting), tmp_path)).get("joints/thing_0__drawer_slide", "")
    assert bool(told) == clash
    assert not (resting and clash) or "thing_1" in told


def resting(asset: Asset, where: Resting) -> Scene:
    other = asset.replace(id="small_cupboard")
    return with_resting(room((cupboard(), at(0.0, 0.0, 0.0)), (other, at(1.5, 0.0, 0.0))), where)


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
