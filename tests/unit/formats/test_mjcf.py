"""MJCF of assets and scenes: structure, names, numbers and poses, the light form, pictures of the batch form."""

from __future__ import annotations

import itertools
from pathlib import Path

import mujoco
import numpy as np
import pytest
from lxml import etree
from pxr import Usd

from casa_assets.addons.batch.merged_form import BatchForms
from casa_assets.asset.lightweight import light_scene
from casa_assets.checks.readers.mujoco_facts import load_asset_file
from casa_assets.formats.mjcf import batch, document, kitchen, shapes, write
from casa_assets.formats.mjcf.document import full_inertia
from casa_assets.formats.values import ROBOSUITE_GROUPS, numbers
from casa_assets.model.asset.asset import Asset, Base, Inertial
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.kitchen.scene import OUTER_FACE, Placement, Scene
from casa_assets.model.pose import Pose
from tests.support.asset.articulated_assets import grill
from tests.support.asset.assets import drawer_unit, rigid_mug, textured_box
from tests.support.asset.packages import stage_of
from tests.support.kitchen.rooms import at, block, room
from tests.support.kitchen.scenes import Weight, corner, expected, in_form, put
from tests.support.mesh.meshes import texture


def xml(asset: Asset, file: str = "model.xml") -> etree._Element:
    return etree.fromstring(write(asset).entries[file])


def one(root: etree._Element, path: str) -> dict[str, str]:
    (found,) = root.findall(path)
    return {str(name): str(value) for name, value in found.attrib.items()}


def prim_of(asset: Asset, path: str) -> Usd.Prim:
    prim = stage_of(asset).GetDefaultPrim().GetPrimAtPath(path)
    assert prim, path
    return prim


def test_contact_is_written_in_full_and_the_floor_lets_it_act() -> None:
    found = one(xml(textured_box()), ".//geom[@name='carton_0']")
    assert [found[name] for name in ("group", "contype", "conaffinity", "condim", "mass")] == ["0", "1", "1", "4", "0"]
    assert found["friction"] == "0.4 0.005 0.0001"
    assert one(xml(drawer_unit(), "scene.xml"), ".//geom[@name='scene__floor']")["friction"] == "0.4 0.004 0.0001"


def test_values_are_read_back_as_the_same_float32() -> None:
    rng = np.random.default_rng(5)
    vertices = rng.normal(size=(200, 3)) * 10.0 ** rng.integers(-6, 3, size=(200, 1))
    text = shapes.obj_text(Mesh(vertices=vertices, faces=np.array([[0, 1, 2]]))).decode()
    read = [[float(n) for n in line.split()[1:]] for line in text.splitlines() if line.startswith("v ")]
    np.testing.assert_array_equal(np.array(read, dtype=np.float32), vertices.astype(np.float32))
    assert numbers([-0.0, 1.0, 0.1 + 0.2, -1e-12, 1 / 3]) == "0 1 0.3 -1e-12 0.333333333"


def test_a_mesh_is_one_file_and_an_element_for_all_that_show_it_and_one_for_what_is_touched() -> None:
    mug = rigid_mug()
    twin = mug.root.visuals[1].replace(name="twin")
    files = write(mug.replace(links=(mug.root.replace(visuals=(*mug.root.visuals, twin)),)))
    assert files.entries.keys() == write(mug).entries.keys()
    root = etree.fromstring(files.entries["model.xml"])
    assert one(root, ".//geom[@name='twin']")["mesh"] == one(root, ".//geom[@name='grip']")["mesh"]
    names = [e.get("name") for e in root.findall("asset/mesh")]
    assert len(names) == len(set(names)) == 10
    unit = drawer_unit()
    drawer = unit.link("drawer")
    hull = drawer.colliders[0].shape
    assert hull.kind == "hull"
    seen = drawer.replace(visuals=(drawer.visuals[0].replace(mesh=hull.mesh),))
    root = xml(unit.replace(links=(unit.root, seen, unit.link("knob"))))
    names = [one(root, f".//geom[@name='{name}']")["mesh"] for name in ("box", "box_0")]
    paths = {one(root, f"asset/mesh[@name='{name}']")["file"] for name in names}
    assert (len(set(names)), len(paths)) == (2, 1)


def test_rounding_leaves_a_flat_plate_a_possible_body() -> None:
    rng = np.random.default_rng(1)
    for _ in range(200):
        a, b = rng.uniform(1e-4, 1e-3, 2)
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        t = turn @ np.diag([a, b, a + b]) @ turn.T
        entries = (t[0, 0], t[1, 1], t[2, 2], t[0, 1], t[0, 2], t[1, 2])
        inertial = Inertial(mass=1.0, center_of_mass=(0.0, 0.0, 0.0), inertia=entries)
        xx, yy, zz, xy, xz, yz = (float(n) for n in numbers(full_inertia(inertial)).split())
        low, middle, high = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        assert low + middle >= high
        np.testing.assert_allclose([xx, yy, zz, xy, xz, yz], entries, atol=1e-7 * np.trace(t))


def test_a_free_base_is_on_the_floor_and_first_among_joints() -> None:
    mug = rigid_mug()
    root = xml(mug.replace(links=(mug.root.replace(pose=Pose(position=(0.1, 0.0, -0.5))),)), "scene.xml")
    assert one(root, "worldbody/body[@name='object']")["pos"] == "0.1 0 0"
    assert root.findall("worldbody/body/freejoint")
    loose = grill().replace(base=Base.FREE, contract=None, behavior=None)
    assert one(xml(loose, "scene.xml"), "keyframe/key[@name='open']")["qpos"] == "0 0 0 1 0 0 0 -1.3 0.15 0"
    assert one(xml(loose), "keyframe/key[@name='open']")["qpos"] == "-1.3 0.15 0"


def test_what_a_runtime_shows_is_in_a_group_that_cameras_see() -> None:
    seen = mujoco.MjvOption().sitegroup
    for name, path, shown in (("heat_glow", "object/sites", 1), ("plate_place", "object/sites", 0)):
        group = int(one(xml(grill()), f".//site[@name='{name}']")["group"])
        assert seen[group] == shown
        assert prim_of(grill(), f"{path}/{name}").GetAttribute("mjc:group").Get() == group


def test_corners_span_the_region_on_its_body() -> None:
    asset = grill()
    for name, prefix in (("main", "ext"), ("int", "int")):
        (region,) = [r for r in asset.regions if r.name == name]
        sites = [one(xml(asset), f".//site[@name='{prefix}_{end}']") for end in ("p0", "px", "py", "pz")]
        first, *ends = (np.array([float(n) for n in site["pos"].split()]) for site in sites)
        sides = np.array(ends) - first
        assert sides == pytest.approx(np.diag(region.size), abs=1e-8)
        assert first + sides.sum(axis=0) / 2 == pytest.approx(np.array(region.pose.position), abs=1e-8)


def test_closed_is_there_in_usd_even_where_nobody_says_it_and_a_raised_root_stays() -> None:
    asset = grill()
    variants = prim_of(asset.replace(keyframes=asset.keyframes[1:]), "object").GetParent().GetVariantSet("pose")
    assert variants.GetVariantNames() == ["closed", "on", "open"]
    assert variants.GetVariantSelection() == "closed"
    raised = asset.replace(links=(asset.root.replace(pose=Pose(position=(0.1, 0.0, 0.2))), *asset.links[1:]))
    assert list(prim_of(raised, "object").GetAttribute("xformOp:translate").Get()) == [0.1, 0.0, 0.2]
    assert list(prim_of(raised, "rack").GetAttribute("xformOp:translate").Get()) == pytest.approx([0.06, 0.0, 0.3])


def loaded(scene: Scene, folder: Path, weight: Weight = Weight.FULL) -> mujoco.MjModel:
    """The model; a warning of any kind is a failure."""
    found = load_asset_file(put(kitchen.write(in_form(scene, weight)), folder, scene) / "scene.xml")
    assert (found.error, found.warnings) == ("", ())
    return found.model


def geoms(scene: Scene, weight: Weight = Weight.FULL) -> dict[str, etree._Element]:
    root = etree.fromstring(kitchen.write(in_form(scene, weight)).entries["scene.xml"])
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
    whole = etree.fromstring(kitchen.write(corner(), groups=ROBOSUITE_GROUPS).entries["scene.xml"])
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
    types, kin = light.body_contype, light.body_conaffinity
    for one_name, others, meets in (
        ("unit__drawer", ("unit", "second_oven"), False),
        ("unit__drawer", ("oven__door",), True),
        ("mug", ("unit__drawer", "unit", "tilted_mug", "loose_oven"), True),
        ("loose_oven__door", ("wall",), True),  # the free oven's parts keep the bits of a robot, and so meet all else
    ):
        for a, b in ((light.body(one_name).id, light.body(other).id) for other in others):
            assert bool(types[a] & kin[b] or types[b] & kin[a]) is meets, one_name


def compiled(tile: tuple[float, float] | None) -> mujoco.MjModel:
    """A board that stands, with a picture that `box_mesh` draws once on each side, wherever `tile` says it repeats."""
    pixels = np.zeros((400, 600, 3), dtype=np.uint8)
    pixels[:200] = 200
    oak = Material(id="paint", base_color_texture=texture("grain", pixels), tile_m=tile)
    board = block("board", (1.2, 0.02, 0.6)).replace(materials=(oak,))
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
    model, plain, name = compiled((0.3, 0.2)), compiled(None), "thing_0__shape_0"
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
