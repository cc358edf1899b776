"""Scenes as MJCF: names, poses, what is shared, weights, bytes."""

from __future__ import annotations

import hashlib
import warnings
from pathlib import Path

import mujoco
import numpy as np
import pytest
from lxml import etree

from casa_assets.formats.mjcf import document, kitchen
from casa_assets.formats.mjcf.kitchen import FOLDER, write
from casa_assets.formats.values import ROBOSUITE_GROUPS
from casa_assets.layouts.compose.cameras import look_at
from casa_assets.mesh.inertia import adjacent_links
from casa_assets.model.kitchen.scene import OUTER_FACE, Camera, Placement, Scene
from tests.support.asset.assets import microwave, textured_box
from tests.support.kitchen.scenes import Weight, body, corner, expected, in_form, put


def loaded(scene: Scene, folder: Path, weight: Weight = Weight.FULL) -> mujoco.MjModel:
    """The model; a warning of any kind is a failure."""
    path = put(write(in_form(scene, weight)), folder, scene) / "scene.xml"
    said: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(said.append)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            model = mujoco.MjModel.from_xml_path(str(path))
    finally:
        mujoco.set_mju_user_warning(before)
    assert said == []
    return model


def text(scene: Scene, weight: Weight = Weight.FULL) -> etree._Element:
    return etree.fromstring(write(in_form(scene, weight)).entries["scene.xml"])


def named(root: etree._Element, path: str) -> list[str]:
    return [str(e.get("name")) for e in root.findall(path)]


@pytest.fixture(scope="module")
def full(tmp_path_factory: pytest.TempPathFactory) -> mujoco.MjModel:
    return loaded(corner(), tmp_path_factory.mktemp("full"))


class TestPoses:
    @pytest.mark.parametrize("key", ["start", "closed", "open"])
    @pytest.mark.parametrize("weight", list(Weight))
    def test_every_body_stands_where_the_scene_puts_it(self, key: str, weight: Weight, tmp_path: Path) -> None:
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

    def test_a_scene_in_which_nothing_moves(self, tmp_path: Path) -> None:
        carton = textured_box().replace(base="fixed")
        scene = Scene(id="still", assets=(carton,), placements=(Placement(name="only", asset=carton.id),))
        model = loaded(scene, tmp_path)
        assert (model.nq, model.nkey, model.nbody) == (0, 3, 2)

    def test_an_empty_scene(self, tmp_path: Path) -> None:
        assert loaded(Scene(id="void", assets=(), placements=()), tmp_path).nbody == 1


class TestNames:
    @pytest.mark.parametrize("weight", list(Weight))
    def test_exclusions_are_those_of_each_placement_and_what_moves_beside_what_is_fixed(self, weight: Weight) -> None:
        pairs = [(e.get("body1"), e.get("body2")) for e in text(corner(), weight).findall("contact/exclude")]
        asset_of = corner().asset_of
        own = {
            (body(p.name, e.first), body(p.name, e.second))
            for p in corner().placements
            for e in asset_of[p.name].exclusions
        }
        near = {tuple(body(end.placement, end.link) for end in pair) for pair in adjacent_links(corner())}
        assert own <= set(pairs)
        # The light form has filters for the others. No pair is said twice, whatever comes first in it.
        beyond = near - {pair[::-1] for pair in own} - own if weight is Weight.FULL else set()
        assert set(pairs) == own | beyond
        assert len({frozenset(pair) for pair in pairs}) == len(pairs)
        assert ("second_oven", "second_oven__door") in pairs

    def test_a_placement_is_the_single_asset_with_longer_names(self) -> None:
        """Every geom and site of a placement is that of model.xml but for name, mesh and material."""
        asset = corner().asset_of["grill"]
        single = etree.fromstring(document.write(asset).entries["model.xml"])
        whole = etree.fromstring(write(corner(), groups=ROBOSUITE_GROUPS).entries["scene.xml"])
        (placed,) = (e for e in whole.iter("body") if e.get("name") == "grill")
        for tag in ("geom", "site", "joint"):
            ours = [_plain(e, "grill__") for e in placed.iter(tag)]
            theirs = [
                _plain(e, "") for e in next(e for e in single.iter("body") if e.get("name") == "object").iter(tag)
            ]
            assert ours == theirs


def _plain(element: etree._Element, prefix: str) -> dict[str, str]:
    attributes = {str(k): str(v) for k, v in element.attrib.items() if k not in ("mesh", "material")}
    assert attributes["name"].startswith(prefix)
    return attributes | {"name": attributes["name"].removeprefix(prefix)}


class TestShared:
    def test_each_thing_is_there_once(self) -> None:
        root, files = text(corner()), write(corner()).entries
        names = named(root, "asset/*")
        assert len(names) == len(set(names))
        meshes = {str(e.get("file")) for e in root.findall("asset/mesh")}
        pictures = {str(e.get("file")) for e in root.findall("asset/texture[@file]")}
        assert {f"../{p}" for p in files if p.startswith("assets/meshes")} == meshes
        assert {f"../{p}" for p in files if p.startswith("assets/textures")} == pictures
        assert len(pictures) == 1
        # Two mugs have the hulls of one; both ovens and both grills have carcass panels of the same bytes.
        assert len([m for m in named(root, "asset/mesh") if m.endswith("__convex")]) == 9
        assert named(root, "asset/material").count("grill_0123456789__lamp") == 1

    def test_meshes_are_called_by_their_content(self) -> None:
        for path, data in write(corner()).entries.items():
            if path.startswith("assets/meshes/"):
                assert path == f"assets/meshes/{hashlib.sha256(data).hexdigest()[:24]}.obj"

    def test_two_scenes_share_files(self) -> None:
        other = Scene(id="other", assets=(microwave(),), placements=(Placement(name="p", asset=microwave().id),))
        assert set(write(other).entries) - {"scene.xml"} <= set(write(corner()).entries)

    def test_where_the_shared_folder_is(self) -> None:
        root = etree.fromstring(write(corner(), shared="../../stock").entries["scene.xml"])
        assert all(str(e.get("file")).startswith("../../stock/") for e in root.findall("asset/mesh"))
        assert FOLDER == "assets"


class TestGroups:
    def test_a_key_hides_the_ceiling(self, full: mujoco.MjModel) -> None:
        def groups(name: str) -> set[int]:
            start, count = int(full.body(name).geomadr[0]), int(full.body(name).geomnum[0])
            seen = [g for g in range(start, start + count) if not full.geom_contype[g] and full.geom_rgba[g, 3] > 0]
            return {int(full.geom_group[g]) for g in seen}

        assert groups("ceiling") == {4}
        assert groups("wall") == {2}
        assert groups("grill") == {2}

    @pytest.mark.parametrize("weight", list(Weight))
    @pytest.mark.parametrize("robosuite", [False, True])
    def test_cameras_with_nothing_set_show_what_is_seen_alone(
        self, weight: Weight, robosuite: bool, tmp_path: Path
    ) -> None:
        """A camera of robosuite hides group 0 besides. Nobody shows the ceiling, so that one looks in from above."""
        model = loaded(corner(), tmp_path, weight)
        shown = mujoco.MjvOption().geomgroup.astype(bool)
        shown[0] &= not robosuite
        for geom in range(model.ngeom):
            name = model.geom(geom).name
            is_seen = "__reg_" not in name and (weight is Weight.LIGHT or not model.geom_contype[geom])
            is_seen &= not name.startswith("ceiling__")
            assert shown[model.geom_group[geom]] == is_seen, name

    def test_faces_that_look_out_of_the_room_are_hidden(self) -> None:
        box = textured_box()
        front, link = box.root.visuals[0].replace(label=None), box.root
        out = front.replace(name="back", label=OUTER_FACE)
        wall = box.replace(links=(link.replace(visuals=(front, out)), *box.links[1:]))
        scene = Scene(id="one", assets=(wall,), placements=(Placement(name="wall", asset=wall.id),))
        found = {str(e.get("name")): e.get("group") for e in text(scene).iter("geom")}
        assert (found[f"wall__{front.name}"], found["wall__back"]) == ("2", "4")


class TestFirstView:
    def test_is_that_of_the_overview(self, tmp_path: Path) -> None:
        eye = look_at((2.0, -4.0, 3.5), (0.3, 0.2, 1.0))
        scene = corner().replace(cameras=(Camera(name="overview", pose=eye, fov_y_deg=47.0),))
        model = loaded(scene, tmp_path)
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        lens = mujoco.MjvCamera()
        mujoco.mjv_defaultFreeCamera(model, lens)
        drawn = mujoco.MjvScene(model, 2000)
        mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, lens, mujoco.mjtCatBit.mjCAT_ALL, drawn)
        left, right = drawn.camera
        assert (left.pos + right.pos) / 2 == pytest.approx(eye.position, abs=0.01)
        assert left.forward == pytest.approx(-eye.rotation[:, 2], abs=1e-3)
        assert left.up == pytest.approx(eye.rotation[:, 1], abs=1e-3)
        assert model.vis.global_.fovy == 47

    def test_without_one_sees_the_middle(self, full: mujoco.MjModel) -> None:
        lower, upper = kitchen.scene_bounds(corner())
        assert full.stat.center == pytest.approx((lower + upper) / 2)
        assert full.stat.extent == pytest.approx(np.linalg.norm(upper - lower) / 2)


class TestRoom:
    def test_lights_and_cameras(self, full: mujoco.MjModel) -> None:
        assert [full.light(i).name for i in range(full.nlight)] == ["sun", "bulb", "spot"]
        kinds = mujoco.mjtLightType
        # A bulb is a spot whose cone holds all directions: the words of old MuJoCo have no third kind.
        assert list(full.light_type) == [kinds.mjLIGHT_DIRECTIONAL, kinds.mjLIGHT_SPOT, kinds.mjLIGHT_SPOT]
        assert (full.light("bulb").cutoff[0], full.light("bulb").exponent[0]) == (180, 0)
        assert list(full.light_castshadow) == [1, 1, 0]
        assert full.light("spot").cutoff[0] == 30
        assert full.vis.headlight.ambient == pytest.approx([0.3, 0.31, 0.32])
        assert full.camera("door").fovy[0] == 60

    def test_a_camera_at_a_wrist_sees_its_fingers(self, full: mujoco.MjModel) -> None:
        assert full.vis.map.znear * full.stat.extent == pytest.approx(0.015)
        assert (full.vis.global_.offwidth, full.vis.global_.offheight) == (1920, 1440)


class TestLight:
    def test_there_are_no_meshes_and_no_pictures(self, tmp_path: Path) -> None:
        assert list(write(in_form(corner(), Weight.LIGHT)).entries) == ["scene.xml"]
        model = loaded(corner(), tmp_path, Weight.LIGHT)
        assert model.nmesh == model.nmat == 0
        assert not (model.geom_type == mujoco.mjtGeom.mjGEOM_MESH).any()

    def test_what_collides_shows_itself(self) -> None:
        geoms = {str(e.get("name")): e for e in text(corner(), Weight.LIGHT).iter("geom")}
        # The glaze of the mug, and the mean of a picture of one half red, a quarter green and a quarter blue.
        assert geoms["mug__floor"].get("rgba") == geoms["mug__wall_0"].get("rgba") == "0.798 0.248 0.152 1"
        red, green, blue, alpha = (float(c) for c in str(geoms["wall__carton_0"].get("rgba")).split())
        assert red > green > 0.3
        assert green == pytest.approx(blue, abs=0.15)
        assert alpha == 1
        assert geoms["ceiling__carton_0"].get("group") == "4"
        assert geoms["wall__carton_0"].get("group") == "2"

    def test_masses_and_joints_stay(self, full: mujoco.MjModel, tmp_path: Path) -> None:
        light = loaded(corner(), tmp_path, Weight.LIGHT)
        assert light.nbody < full.nbody
        moving = [full.body(int(b)).name for b in full.jnt_bodyid]
        assert [light.body(int(b)).name for b in light.jnt_bodyid] == moving
        for name in moving:
            one, other = light.body(name).id, full.body(name).id
            assert light.body_subtreemass[one] == pytest.approx(full.body_subtreemass[other]), name
        assert light.jnt_range == pytest.approx(full.jnt_range)

    def test_light_does_not_try_fixed_things_with_what_moves_on_them(self, tmp_path: Path) -> None:
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

    def test_full_tries_everything_but_what_is_beside_each_other(self, full: mujoco.MjModel) -> None:
        assert set(full.geom_contype) == {0, 1}
        assert (full.geom_contype == full.geom_conaffinity).all()
        assert full.nexclude == len(text(corner()).findall("contact/exclude"))

    def test_what_stands_on_a_mesh_has_several_contacts_in_every_version(self, subtests: pytest.Subtests) -> None:
        for weight in list(Weight):
            with subtests.test(weight=weight):
                root = etree.fromstring(write(in_form(corner(), weight)).entries["scene.xml"])
                flag = root.find("option/flag")
                assert flag is not None
                assert flag.get("multiccd") == "enable"

    def test_effects_on_what_is_gone_are_gone(self) -> None:
        said = {str(e.get("name")): str(e.get("data")) for e in text(corner(), Weight.LIGHT).findall("custom/text")}
        assert "heat_glow" in said["grill__behavior"]
        assert "lamp_main" not in said["grill__behavior"]


def test_a_scene_runs(full: mujoco.MjModel) -> None:
    """Free things fall, nothing explodes."""
    data = mujoco.MjData(full)
    mujoco.mj_resetDataKeyframe(full, data, full.key("start").id)
    for _ in range(200):
        mujoco.mj_step(full, data)
    assert sum(w.number for w in data.warning) == 0
    assert np.abs(data.qvel).max() < 20
    assert data.body("mug").xpos[2] < 1.0 - 0.5
