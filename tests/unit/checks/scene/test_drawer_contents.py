"""What lies in a drawer goes along with it: in checks, and in the named poses of both formats."""

from __future__ import annotations

from pathlib import Path

import mujoco
import pytest

from casa_assets.checks.scene.formats import formats_agree
from casa_assets.checks.scene.opening import joints_open_without_collision
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.kitchen.scene import Resting, Scene
from tests.support.asset.cupboard import cupboard
from tests.support.kitchen.rooms import at, block, in_all_forms, room, subject

LIMIT = 0.001
IN_DRAWER = Resting(placement="thing_0", link="drawer", region="drawer_int")


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
    found = joints_open_without_collision(subject(filled(height, resting), tmp_path), LIMIT)
    told = [message for pointer, message in found.problems if pointer == "joints/thing_0__drawer_slide"]
    assert bool(told) == clash
    if resting and clash:
        assert "thing_1" in told[0]


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
