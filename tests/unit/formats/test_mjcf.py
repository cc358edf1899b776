"""The MJCF writer: structure, names, numbers, bytes."""

from __future__ import annotations

import hashlib
import re

import numpy as np
import pytest
from lxml import etree

from casa_assets.formats.mjcf import shapes, write
from casa_assets.formats.mjcf.document import full_inertia
from casa_assets.formats.values import numbers
from casa_assets.model.asset.asset import Asset, Inertial, Region
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.pose import Pose
from tests.support.asset.assets import EVERY, ball, drawer_unit, microwave, rigid_mug, textured_box
from tests.support.mesh.meshes import box_mesh


def model(asset: Asset) -> etree._Element:
    return etree.fromstring(write(asset).entries["model.xml"])


def scene(asset: Asset) -> etree._Element:
    return etree.fromstring(write(asset).entries["scene.xml"])


def attributes(root: etree._Element, path: str) -> dict[str, str]:
    found = root.find(path)
    assert found is not None, path
    return {str(name): str(value) for name, value in found.attrib.items()}


class TestModel:
    def test_has_the_shape_that_robocasa_looks_for(self, subtests: pytest.Subtests) -> None:
        for build in EVERY:
            with subtests.test(build=build.__name__):
                root = model(build())
                assert [(e.tag, e.get("name")) for e in root.findall("worldbody/*")] == [("body", None)]
                assert [e.get("name") for e in root.findall("worldbody/body/body")] == ["object"]
                assert root.findall(".//freejoint") == []
                assert all(geom.get("group") for geom in root.iter("geom"))
                assert all(len(body.findall("inertial")) == 1 for body in root.iter("body") if body.get("name"))

    def test_outer_body_carries_the_measures(self) -> None:
        sites = {e.get("name"): e.get("pos") for e in model(rigid_mug()).findall("worldbody/body/site")}
        assert sites == {
            "bottom_site": "0 0 0",
            "top_site": "0 0 0.095",
            "horizontal_radius_site": "0.0525 0.04 0",
        }

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

    def test_outer_region_of_the_asset_wins(self, subtests: pytest.Subtests) -> None:
        for name in ["bbox", "main"]:
            with subtests.test(name=name):
                named = ball().replace(regions=(Region(name=name, size=(0.1, 0.1, 0.1)),))
                regions = [e.get("name") for e in model(named).iter("geom") if str(e.get("name")).startswith("reg_")]
                assert regions == [f"reg_{name}"]


class TestJoint:
    def test_hinge_is_in_radians_and_limited(self) -> None:
        assert attributes(model(microwave()), ".//body[@name='door']/joint") == {
            "name": "microjoint",
            "type": "hinge",
            "pos": "0 -0.02 0",
            "axis": "0 0 1",
            "limited": "true",
            "range": "-1.57079633 0",
            "damping": "0.5",
            "frictionloss": "0.3",
            "armature": "0.01",
            "solimplimit": "0.9999 0.9999 0.001 0.5 2",
            "solimpfriction": "0.9999 0.9999 0.001 0.5 2",
        }


class TestCollider:
    def test_sizes_are_those_that_the_loader_accepts(self) -> None:
        assert attributes(model(ball()), ".//geom[@type='sphere']")["size"] == "0.036 0.036 0.036"
        assert attributes(model(rigid_mug()), ".//geom[@type='cylinder']")["size"] == "0.04 0.003"
        assert attributes(model(rigid_mug()), ".//geom[@type='capsule']")["size"] == "0.005 0.025"
        assert attributes(model(textured_box()), ".//geom[@name='carton_0']")["size"] == "0.1 0.03 0.06"

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

    def test_hulls_are_convex_and_bounded(self) -> None:
        mesh_name = attributes(model(rigid_mug()), ".//geom[@name='wall_0']")["mesh"]
        found = attributes(model(rigid_mug()), f"asset/mesh[@name='{mesh_name}']")
        assert (found["inertia"], found["maxhullvert"]) == ("convex", "64")


class TestMesh:
    def test_values_are_read_back_as_the_same_float32(self) -> None:
        rng = np.random.default_rng(5)
        vertices = rng.normal(size=(200, 3)) * 10.0 ** rng.integers(-6, 3, size=(200, 1))
        text = shapes.obj_text(Mesh(vertices=vertices, faces=np.array([[0, 1, 2]]))).decode()
        read = [[float(n) for n in line.split()[1:]] for line in text.splitlines() if line.startswith("v ")]
        np.testing.assert_array_equal(np.array(read, dtype=np.float32), vertices.astype(np.float32))

    def test_one_index_names_all(self, subtests: pytest.Subtests) -> None:
        for uv, normals, corner in [
            (True, True, "1/1/1"),
            (True, False, "1/1"),
            (False, True, "1//1"),
            (False, False, "1"),
        ]:
            with subtests.test(uv=uv, normals=normals, corner=corner):
                full = box_mesh((1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
                some = Mesh(
                    vertices=full.vertices,
                    faces=full.faces,
                    uv=full.uv if uv else None,
                    normals=full.normals if normals else None,
                )
                lines = shapes.obj_text(some).decode().splitlines()
                assert next(line for line in lines if line.startswith("f ")).split()[1] == corner
                kinds = {"v": 24, "vt": 24 * uv, "vn": 24 * normals, "f": 12}
                assert {kind: sum(line.startswith(kind + " ") for line in lines) for kind in kinds} == kinds

    def test_file_name_is_the_hash_of_the_content(self) -> None:
        for path, data in write(rigid_mug()).entries.items():
            if path.startswith("meshes/"):
                assert path.endswith(f"_{hashlib.sha256(data).hexdigest()[:12]}.obj")

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


class TestMaterial:
    def test_highlights_are_legal(self, subtests: pytest.Subtests) -> None:
        for roughness in [0.0, 0.01, 0.3, 1.0]:
            for metallic in [0.0, 0.5, 1.0]:
                with subtests.test(metallic=metallic, roughness=roughness):
                    mug = rigid_mug()
                    shiny = mug.replace(materials=(Material(id="glaze", metallic=metallic, roughness=roughness),))
                    found = attributes(model(shiny), "asset/material")
                    assert all(
                        0 <= float(found[name]) <= 1 for name in ("specular", "shininess", "metallic", "roughness")
                    )

    def test_picture_is_written_and_maps_are_left_to_usd(self) -> None:
        files = write(textured_box())
        pictures = [path for path in files.entries if path.startswith("textures/")]
        assert len(pictures) == 1
        root = etree.fromstring(files.entries["model.xml"])
        texture = attributes(root, "asset/texture")
        assert (texture["type"], texture["file"]) == ("2d", pictures[0])
        assert attributes(root, "asset/material")["texture"] == texture["name"]
        assert root.findall(".//layer") == []

    def test_names_tell_contents_apart(self) -> None:
        mug = rigid_mug()
        other = mug.replace(materials=(mug.materials[0].replace(roughness=0.9),))
        first, second = (attributes(model(a), "asset/material")["name"] for a in (mug, other))
        assert first != second
        assert re.fullmatch(r"glaze_[0-9a-f]{12}", first)


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

    def test_paths_are_relative_and_named_files_exist(self, subtests: pytest.Subtests) -> None:
        for build in EVERY:
            with subtests.test(build=build.__name__):
                files = write(build())
                for name in ("model.xml", "scene.xml"):
                    root = etree.fromstring(files.entries[name])
                    named = {str(e.get("file")) for e in root.iter("mesh", "texture") if e.get("file")}
                    assert named == files.entries.keys() - {"model.xml", "scene.xml"}
