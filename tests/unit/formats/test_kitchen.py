"""Scenes as MJCF: names, poses, the light form, and pictures on boxes of the batch form at their true size."""

from __future__ import annotations

import itertools
from pathlib import Path

import mujoco
import numpy as np
import pytest
from lxml import etree

from casa_assets.addons.batch.merged_form import BatchForms
from casa_assets.asset.lightweight import light_scene
from casa_assets.checks.readers.mujoco_facts import load_asset_file
from casa_assets.formats.mjcf import batch, document
from casa_assets.formats.mjcf.kitchen import write
from casa_assets.formats.values import ROBOSUITE_GROUPS
from casa_assets.model.asset.material import Material
from casa_assets.model.kitchen.scene import OUTER_FACE, Placement, Scene
from tests.support.asset.assets import textured_box
from tests.support.kitchen.rooms import at, block, room
from tests.support.kitchen.scenes import Weight, corner, expected, in_form, put
from tests.support.mesh.meshes import texture


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


# A board that stands, 1.2 m wide and 0.6 m high: its picture is 0.3 m wide and 0.2 m high.
BOARD = (1.2, 0.02, 0.6)
TILE = (0.3, 0.2)


def compiled(tile: tuple[float, float] | None) -> mujoco.MjModel:
    """A board with a picture that `box_mesh` draws once on each side, wherever `tile` says it repeats."""
    pixels = np.zeros((400, 600, 3), dtype=np.uint8)
    pixels[:200] = 200
    oak = Material(id="paint", base_color_texture=texture("grain", pixels), tile_m=tile)
    board = block("board", BOARD).replace(materials=(oak,))
    files = batch.write(BatchForms(light_scene(room((board, at(0.0, 0.0, 0.0))))).form())
    entries = {path.replace("assets/", "../assets/"): data for path, data in files.entries.items()}
    return mujoco.MjModel.from_xml_string(entries.pop(batch.FILE).decode(), assets=entries)


def corners(model: mujoco.MjModel, geom: int) -> set[tuple[float, ...]]:
    """Of a box, in its body, mm."""
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    signs = np.array(list(itertools.product((-1, 1), repeat=3)))
    points = (signs * model.geom_size[geom]) @ turn.reshape(3, 3).T + model.geom_pos[geom]
    return {tuple(point) for point in (points * 1000).round(3) + 0.0}


def test_a_picture_repeats_by_its_true_size_and_the_box_is_where_it_was() -> None:
    model, plain, name = compiled(TILE), compiled(None), "thing_0__shape_0"
    geom = model.geom(name).id
    material = int(model.geom_matid[geom])
    assert model.mat_texuniform[material]
    # MuJoCo multiplies by half of the length.
    times = model.mat_texrepeat[material] * model.geom_size[geom][:2]
    assert times == pytest.approx([1.2 / 0.3, 0.6 / 0.2])
    assert model.geom_size[geom][2] == pytest.approx(0.01), "the side with the picture is the top of the box"
    assert plain.nmat == 0
    assert not np.allclose(model.geom(name).size, plain.geom(name).size)
    assert corners(model, geom) == corners(plain, plain.geom(name).id)
