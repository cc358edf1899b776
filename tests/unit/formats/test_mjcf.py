"""The MJCF writer: structure, names, numbers, bytes."""

from __future__ import annotations

import re

import numpy as np
from lxml import etree

from casa_assets.formats.mjcf import shapes, write
from casa_assets.formats.mjcf.document import full_inertia
from casa_assets.formats.values import numbers
from casa_assets.model.asset.asset import Asset, Inertial
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.pose import Pose
from tests.support.asset.assets import EVERY, ball, drawer_unit, rigid_mug, textured_box


def model(asset: Asset) -> etree._Element:
    return etree.fromstring(write(asset).entries["model.xml"])


def scene(asset: Asset) -> etree._Element:
    return etree.fromstring(write(asset).entries["scene.xml"])


def attributes(root: etree._Element, path: str) -> dict[str, str]:
    found = root.find(path)
    assert found is not None, path
    return {str(name): str(value) for name, value in found.attrib.items()}


class TestModel:
    def test_outer_region_bounds_the_colliders(self) -> None:
        assert attributes(model(ball()), ".//geom[@name='reg_bbox']") == {
            "name": "reg_bbox",
            "type": "box",
            "pos": "0 0 0.036",
            "size": "0.036 0.036 0.036",
            "group": "1",
            "contype": "0",
            "conaffinity": "0",
            "mass": "0",
            "rgba": "0 1 0 0",
        }


class TestCollider:
    def test_contact_is_said_in_full(self) -> None:
        found = attributes(model(textured_box()), ".//geom[@name='carton_0']")
        assert {k: found[k] for k in ("group", "contype", "conaffinity", "condim", "friction", "mass")} == {
            "group": "0",
            "contype": "1",
            "conaffinity": "1",
            "condim": "4",
            "friction": "0.4 0.005 0.0001",
            "mass": "0",
        }


class TestMesh:
    def test_values_are_read_back_as_the_same_float32(self) -> None:
        rng = np.random.default_rng(5)
        vertices = rng.normal(size=(200, 3)) * 10.0 ** rng.integers(-6, 3, size=(200, 1))
        text = shapes.obj_text(Mesh(vertices=vertices, faces=np.array([[0, 1, 2]]))).decode()
        read = [[float(n) for n in line.split()[1:]] for line in text.splitlines() if line.startswith("v ")]
        np.testing.assert_array_equal(np.array(read, dtype=np.float32), vertices.astype(np.float32))

    def test_the_same_mesh_twice_is_one_file_and_one_element(self) -> None:
        mug = rigid_mug()
        twin = mug.root.visuals[1].replace(name="twin")
        doubled = mug.replace(links=(mug.root.replace(visuals=(*mug.root.visuals, twin)),))
        files = write(doubled)
        assert files.entries.keys() == write(mug).entries.keys()
        root = etree.fromstring(files.entries["model.xml"])
        assert attributes(root, ".//geom[@name='twin']")["mesh"] == attributes(root, ".//geom[@name='grip']")["mesh"]
        names = [e.get("name") for e in root.findall("asset/mesh")]
        assert len(names) == len(set(names)) == 10

    def test_a_mesh_that_is_seen_and_touched_is_one_file_and_two_elements(self) -> None:
        unit = drawer_unit()
        drawer = unit.link("drawer")
        hull = drawer.colliders[0].shape
        assert hull.kind == "hull"
        seen = drawer.replace(visuals=(drawer.visuals[0].replace(mesh=hull.mesh),))
        root = model(unit.replace(links=(unit.root, seen, unit.link("knob"))))
        box, box_0 = (attributes(root, f".//geom[@name='{name}']")["mesh"] for name in ("box", "box_0"))
        assert box != box_0
        assert (
            attributes(root, f"asset/mesh[@name='{box}']")["file"]
            == attributes(root, f"asset/mesh[@name='{box_0}']")["file"]
        )


class TestInertial:
    def test_rounding_leaves_a_flat_plate_a_possible_body(self) -> None:
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


class TestScene:
    def test_free_asset_stands_on_the_floor(self) -> None:
        mug = rigid_mug()
        sunk = mug.replace(links=(mug.root.replace(pose=Pose(position=(0.1, 0.0, -0.5))),))
        root = scene(sunk)
        assert attributes(root, "worldbody/body[@name='object']")["pos"] == "0.1 0 0"
        assert root.findall("worldbody/body/freejoint")

    def test_floor_lets_the_friction_of_the_asset_act(self) -> None:
        floor = attributes(scene(drawer_unit()), ".//geom[@name='scene__floor']")
        assert floor["friction"] == "0.4 0.004 0.0001"

    def test_holds_the_same_bodies_as_the_model(self) -> None:
        def stripped(root: etree._Element) -> list[str]:
            body = root.find(".//body[@name='object']")
            assert body is not None
            for geom in body.iter("geom"):
                geom.attrib.pop("group")
            return [etree.tostring(part).decode() for part in body if part.tag != "freejoint"]

        for build in EVERY:
            normal = [re.sub(r"\s+", " ", text) for text in stripped(model(build()))]
            assert normal == [re.sub(r"\s+", " ", text) for text in stripped(scene(build()))]


class TestBytes:
    def test_numbers(self) -> None:
        assert numbers([-0.0, 1.0, 0.1 + 0.2, -1e-12, 1 / 3]) == "0 1 0.3 -1e-12 0.333333333"
