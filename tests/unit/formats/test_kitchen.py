"""Scenes as MJCF: names, poses, what is shared, weights, bytes."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from lxml import etree

from casa_assets.checks.readers.mujoco_facts import load_asset_file
from casa_assets.formats.mjcf import document
from casa_assets.formats.mjcf.kitchen import write
from casa_assets.formats.values import ROBOSUITE_GROUPS
from casa_assets.model.kitchen.scene import OUTER_FACE, Placement, Scene
from tests.support.asset.assets import textured_box
from tests.support.kitchen.scenes import Weight, corner, expected, in_form, put


def loaded(scene: Scene, folder: Path, weight: Weight = Weight.FULL) -> mujoco.MjModel:
    """The model; a warning of any kind is a failure."""
    found = load_asset_file(put(write(in_form(scene, weight)), folder, scene) / "scene.xml")
    assert (found.error, found.warnings) == ("", ())
    return found.model


def geoms(scene: Scene, weight: Weight = Weight.FULL) -> dict[str, etree._Element]:
    root = etree.fromstring(write(in_form(scene, weight)).entries["scene.xml"])
    return {str(e.get("name")): e for e in root.iter("geom")}


@pytest.mark.parametrize("key", ["start", "closed", "open"])
@pytest.mark.parametrize("weight", list(Weight))
def test_every_body_stands_where_the_scene_puts_it(key: str, weight: Weight, tmp_path: Path) -> None:
    model = loaded(corner(), tmp_path, weight)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key(key).id)
    mujoco.mj_kinematics(model, data)
    truth = expected(corner(), key)
    there = [model.body(i).name for i in range(1, model.nbody)]
    assert len(set(there)) == len(there)
    # In the light form a body is one with what it is fixed to, so only those that move have to be there.
    moving = {model.body(int(b)).name for b in model.jnt_bodyid}
    assert (moving if weight is Weight.LIGHT else set(truth)) <= set(there) <= set(truth)
    for name, pose in ((n, truth[n]) for n in there):
        assert data.body(name).xpos == pytest.approx(pose.position, abs=1e-8), name
        assert data.body(name).xmat.reshape(3, 3) == pytest.approx(pose.rotation, abs=1e-8), name


def test_a_placement_is_the_single_asset_with_longer_names() -> None:
    """Every geom and site of a placement is that of model.xml but for name, mesh and material."""
    asset = corner().asset_of["grill"]
    single = etree.fromstring(document.write(asset).entries["model.xml"])
    whole = etree.fromstring(write(corner(), groups=ROBOSUITE_GROUPS).entries["scene.xml"])
    (placed,) = (e for e in whole.iter("body") if e.get("name") == "grill")
    for tag in ("geom", "site", "joint"):
        ours = [_plain(e, "grill__") for e in placed.iter(tag)]
        theirs = [_plain(e, "") for e in next(e for e in single.iter("body") if e.get("name") == "object").iter(tag)]
        assert ours == theirs


def _plain(element: etree._Element, prefix: str) -> dict[str, str]:
    attributes = {str(k): str(v) for k, v in element.attrib.items() if k not in ("mesh", "material")}
    assert attributes["name"].startswith(prefix)
    return attributes | {"name": attributes["name"].removeprefix(prefix)}


def test_faces_that_look_out_of_the_room_are_hidden() -> None:
    box = textured_box()
    front, link = box.root.visuals[0].replace(label=None), box.root
    out = front.replace(name="back", label=OUTER_FACE)
    wall = box.replace(links=(link.replace(visuals=(front, out)), *box.links[1:]))
    scene = Scene(id="one", assets=(wall,), placements=(Placement(name="wall", asset=wall.id),))
    assert [geoms(scene)[f"wall__{name}"].get("group") for name in (front.name, "back")] == ["2", "4"]


def test_what_collides_shows_itself() -> None:
    light = geoms(corner(), Weight.LIGHT)
    # The glaze of the mug, and the mean of a picture of one half red, a quarter green and a quarter blue.
    assert light["mug__floor"].get("rgba") == light["mug__wall_0"].get("rgba") == "0.798 0.248 0.152 1"
    red, green, blue, alpha = (float(c) for c in str(light["wall__carton_0"].get("rgba")).split())
    assert red > green > 0.3
    assert green == pytest.approx(blue, abs=0.15)
    assert alpha == 1
    assert [light[f"{name}__carton_0"].get("group") for name in ("ceiling", "wall")] == ["4", "2"]


def test_light_does_not_try_fixed_things_with_what_moves_on_them(tmp_path: Path) -> None:
    light = loaded(corner(), tmp_path, Weight.LIGHT)

    def meets(one: str, other: str) -> bool:
        a, b = light.body(one).id, light.body(other).id
        types, kin = light.body_contype, light.body_conaffinity
        return bool(types[a] & kin[b] or types[b] & kin[a])

    assert not meets("unit", "unit__drawer")
    assert not meets("second_oven", "unit__drawer")
    assert meets("unit__drawer", "oven__door")
    assert all(meets("mug", other) for other in ("unit__drawer", "unit", "tilted_mug", "loose_oven"))
    # The free oven's parts keep the bits that a robot has, and so meet all else.
    assert meets("loose_oven__door", "wall")


def test_a_scene_runs(tmp_path: Path) -> None:
    """Free things fall, nothing explodes."""
    full = loaded(corner(), tmp_path)
    data = mujoco.MjData(full)
    mujoco.mj_resetDataKeyframe(full, data, full.key("start").id)
    for _ in range(200):
        mujoco.mj_step(full, data)
    assert sum(w.number for w in data.warning) == 0
    assert np.abs(data.qvel).max() < 20
    assert data.body("mug").xpos[2] < 1.0 - 0.5
