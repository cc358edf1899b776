"""MJCF: structure, names and numbers, and what a stateful fixture has beyond a rigid thing; its poses in USD."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from lxml import etree
from pxr import Usd

from casa_assets.formats.mjcf import shapes, write
from casa_assets.formats.mjcf.document import full_inertia
from casa_assets.formats.values import numbers
from casa_assets.model.asset.asset import Asset, Base, Inertial
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.pose import Pose
from tests.support.asset.articulated_assets import grill
from tests.support.asset.assets import drawer_unit, rigid_mug, textured_box
from tests.support.asset.packages import stage_of


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


def test_the_same_mesh_twice_is_one_file_and_one_element() -> None:
    mug = rigid_mug()
    twin = mug.root.visuals[1].replace(name="twin")
    files = write(mug.replace(links=(mug.root.replace(visuals=(*mug.root.visuals, twin)),)))
    assert files.entries.keys() == write(mug).entries.keys()
    root = etree.fromstring(files.entries["model.xml"])
    assert one(root, ".//geom[@name='twin']")["mesh"] == one(root, ".//geom[@name='grip']")["mesh"]
    names = [e.get("name") for e in root.findall("asset/mesh")]
    assert len(names) == len(set(names)) == 10


def test_a_mesh_that_is_seen_and_touched_is_one_file_and_two_elements() -> None:
    unit = drawer_unit()
    drawer = unit.link("drawer")
    hull = drawer.colliders[0].shape
    assert hull.kind == "hull"
    seen = drawer.replace(visuals=(drawer.visuals[0].replace(mesh=hull.mesh),))
    root = xml(unit.replace(links=(unit.root, seen, unit.link("knob"))))
    names = [one(root, f".//geom[@name='{name}']")["mesh"] for name in ("box", "box_0")]
    files = [one(root, f"asset/mesh[@name='{name}']")["file"] for name in names]
    assert (len(set(names)), len(set(files))) == (2, 1)


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
