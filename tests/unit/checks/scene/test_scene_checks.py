"""Checks of whole scenes: each code is silent on what is right, and alone in speaking where one thing is wrong."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from casa_assets.checks.scene.placement import visible_wall_shares
from casa_assets.checks.scene.subject import SceneSubject
from casa_assets.checks.table import TABLE, UNLOADED, run_scene
from casa_assets.mesh.solid.solids import convex_hull
from casa_assets.model.asset.asset import Asset, Base, Drive
from casa_assets.model.asset.parts import Box, Hull, Mesh, Sphere
from casa_assets.model.issue import Status
from casa_assets.model.kitchen.scene import Camera, Scene
from casa_assets.model.record import Vec3
from tests.support.asset.cupboard import cupboard, joint_changed
from tests.support.asset.examples import LIMITS, between, check_examples
from tests.support.kitchen.rooms import TO_THE_LEFT, at, block, judged, room, subject

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
    return block(
        "thing", (0.05, 0.05, 0.05), Base.FREE, shapes=[*balls, (Box(size=(0.05, 0.05, 0.03)), (0.0, 0.0, 0.03))]
    )


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
    assert {r.code: r.status for r in report.results} == {
        code: Status.FAILED if code == "SCN001" else Status.NOT_RUN for code in ROWS
    }
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
