"""From the bytes of a file to an Asset: a link to each part, in metres, closed at zero, named for runtimes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from casa_assets.articulate.assemble import MAX_DENSITY_KG_M3, SHEET_GAP_M
from casa_assets.articulate.build_colliders import build_colliders
from casa_assets.articulate.frame import metres_per_unit
from casa_assets.articulate.kinds import rename_for_runtime
from casa_assets.articulate.plan import Articulation, PartKind
from casa_assets.articulate.run.build import ArticulateRequest, build
from casa_assets.articulate.segment.fragments import weld_triangles
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.mesh.solid.solids import hull_volume
from casa_assets.mesh.surface import signed_volume
from casa_assets.model.asset.parts import JointKind
from casa_assets.model.pose import Pose
from casa_assets.model.registry.category import SizeRange
from tests.unit.articulate.blocks import Floats, Ints, box, carcass, drawers, microwave, together
from tests.unit.articulate.fragmented import AS_IT_IS, plan_of, slides

pytestmark = pytest.mark.content("code", "articulate", keep=0)


def obj(path: Path, vertices: Floats, faces: Ints) -> Path:
    """An OBJ file of some triangles."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def wish(mesh: Path, out: Path, category: str = "microwave") -> ArticulateRequest:
    """With the axes given."""
    return ArticulateRequest(mesh, out, category=category, up=(0.0, 0.0, 1.0), front=(0.0, -1.0, 0.0))


def test_a_microwave_becomes_an_asset_that_opens_under_the_names_of_its_kind(tmp_path: Path) -> None:
    built = build(wish(obj(tmp_path / "mw.obj", *microwave()[:2]), tmp_path))
    asset, found = built.asset, built.articulation
    assert [k.name for k in asset.links] == ["object", *(p.name for p in found.parts)]
    assert len(asset.joints) == 6
    door = asset.joint_of("door_0")
    assert door is not None
    assert door.kind is JointKind.HINGE
    assert door.range == pytest.approx((0.0, np.pi / 2), abs=1e-5)
    assert door.grip == "door_0_handle_main"
    assert np.ptp(asset.bounds, axis=0) == pytest.approx([0.5, 0.43, 0.3], abs=1e-5)
    assert asset.bounds[0] == pytest.approx([-0.25, -0.215, 0.0], abs=1e-5)
    middle = np.array([0.0, 0.0, 0.15])
    for collider in asset.root.colliders:  # its cavity stays open
        points = tessellate(collider.shape, collider.pose)[0]
        assert not ((points.min(axis=0) < middle) & (middle < points.max(axis=0))).all(), collider.name
    named, joints = rename_for_runtime(asset, found, "microwave")
    joint = named.joint_of("door")
    assert joint is not None
    assert joint.name == joints["door_0"] == "microjoint"
    assert joint.axis == pytest.approx((0.0, 0.0, 1.0))
    assert joint.range == pytest.approx((-np.pi / 2, 0.0), abs=1e-5)
    assert joint.grip == "door_handle_main"
    assert {s.name for s in named.states} == {"microjoint_closed", "microjoint_open"}
    main = next(r for r in named.regions if r.name == "main")
    # The handle, the knob and the buttons stand out of the region by which it is placed.
    assert main.size == pytest.approx((0.5, 0.4, 0.3), abs=1e-3)
    assert joints["knob_0"] == "knob_0_joint"


def test_links_together_show_all_that_the_file_has(tmp_path: Path) -> None:
    vertices, faces, _ = drawers()
    asset = build(wish(obj(tmp_path / "d.obj", vertices, faces), tmp_path)).asset
    assert sum(len(v.mesh.faces) for k in asset.links for v in k.visuals) == len(faces)
    assert all(k.colliders for k in asset.links)
    total = sum(k.inertial.mass for k in asset.links)
    assert total == pytest.approx(asset.mass)


def test_parts_of_a_file_that_wind_inwards_are_written_outwards(tmp_path: Path) -> None:
    vertices, faces, _ = microwave()
    asset = build(wish(obj(tmp_path / "mw.obj", vertices, faces[:, ::-1]), tmp_path)).asset
    volumes = [signed_volume(v.mesh.vertices, v.mesh.faces) for link in asset.links for v in link.visuals]
    assert min(volumes) > 0.0


def test_no_link_of_a_tiny_thing_weighs_more_than_steel(tmp_path: Path) -> None:
    asset = build(replace(wish(obj(tmp_path / "mw.obj", *microwave()[:2]), tmp_path), size_m=0.03)).asset
    for link in asset.links:
        volume = sum(hull_volume(tessellate(c.shape, c.pose)[0]) for c in link.colliders)
        assert link.inertial.mass <= MAX_DENSITY_KG_M3 * volume * (1 + 1e-6)


def test_a_drawer_behind_the_front_of_another_waits_for_it() -> None:
    front, tub = box((0.0, -0.02, 0.0), (0.5, 0.0, 0.3)), box((0.02, 0.0, 0.02), (0.48, 0.4, 0.1))
    inner, beside = box((0.05, 0.01, 0.15), (0.45, 0.4, 0.25)), box((0.5, -0.02, 0.0), (0.9, 0.4, 0.3))
    vertices, faces, owner = together(*carcass(1.0, 0.5, 0.4), front, tub, inner, beside)
    mesh = weld_triangles(vertices, faces)
    rows = [np.flatnonzero((owner == 5) | (owner == 6)), np.flatnonzero(owner == 7), np.flatnonzero(owner == 8)]
    joint = slides((0.25, 0.2, 0.1))
    parts = tuple(plan_of(f"drawer_{i}", PartKind.DRAWER, own, joint) for i, own in enumerate(rows))
    found = build_colliders(vertices, mesh, Articulation(frame=AS_IT_IS, parts=parts), "steel")
    assert [link.blocking_part for link in found] == [None, None, 0, None]


def test_a_rack_of_wires_is_touched_as_a_basket() -> None:
    wires = [box((x, 0.0, 0.0), (x + 0.003, 0.4, 0.003)) for x in np.linspace(0.0, 0.5, 36)]
    wires += [box((0.0, y, z), (0.503, y + 0.003, z + 0.003)) for y in (0.0, 0.397) for z in (0.04, 0.08, 0.12)]
    vertices, faces, _ = together(*wires)
    mesh = weld_triangles(vertices, faces)
    joint, every = slides((0.25, 0.2, 0.06)), np.arange(len(faces))
    rack = plan_of("rack", PartKind.TRAY, every, joint).replace(grip=every)
    found = build_colliders(vertices, mesh, Articulation(frame=AS_IT_IS, parts=(rack,)), "steel")[1]
    assert {c.label for c in found.colliders} == {"rack"}
    assert len(found.colliders) <= 12
    # One finds a floor in its middle, and no lid.
    shapes = [c.pose.apply(tessellate(c.shape, Pose())[0]) + np.array(joint.anchor) for c in found.colliders]
    at = (0.25, 0.2)
    (over,) = (p[:, 2] for p in shapes if ((p.min(axis=0)[:2] < at) & (p.max(axis=0)[:2] > at)).all())
    assert over.max() < 0.05


def test_units_make_a_thing_of_its_usual_size(subtests: pytest.Subtests) -> None:
    for longest, stated, unit in [
        (0.5, None, 1.0),
        (50.0, None, 0.01),
        (500.0, None, 0.001),
        (0.5, 1.0, 1.0),
        (1.0, None, 0.52),
        (7e5, None, 0.52 / 7e5),
    ]:
        with subtests.test(longest=longest, stated=stated, unit=unit):
            span = SizeRange(low=0.43, typical=0.52, high=0.8)
            assert metres_per_unit(longest, stated, span)[0] == pytest.approx(unit)


def test_no_two_faces_of_a_link_coincide(tmp_path: Path) -> None:
    vertices, faces, _ = microwave()
    mesh = obj(tmp_path / "double.obj", vertices, np.concatenate([faces, faces[:, ::-1], faces[:4]]))
    asset = build(wish(mesh, tmp_path)).asset
    count = 0
    for link in asset.links:
        middles = np.concatenate([v.mesh.vertices[v.mesh.faces].mean(axis=1) for v in link.visuals])
        gap, _ = cKDTree(middles).query(middles, k=2)
        assert gap[:, 1].min() > 0.7 * SHEET_GAP_M
        count += len(middles)
    assert count >= 2 * len(faces), "both sides stay"
    assert np.abs(np.ptp(asset.bounds, axis=0) - [0.5, 0.43, 0.3]).max() <= 2 * SHEET_GAP_M + 1e-6


def test_two_doors_are_those_of_a_fridge_and_its_freezer(tmp_path: Path) -> None:
    parts = [
        *carcass(0.6, 0.6, 1.8),
        box((0.002, -0.05, 0.002), (0.598, 0.0, 1.2)),
        box((0.54, -0.09, 0.4), (0.555, -0.05, 0.9)),
        box((0.002, -0.05, 1.21), (0.598, 0.0, 1.798)),
        box((0.54, -0.09, 1.3), (0.555, -0.05, 1.7)),
    ]
    built = build(wish(obj(tmp_path / "f.obj", *together(*parts)[:2]), tmp_path, "refrigerator"))
    asset, joints = rename_for_runtime(built.asset, built.articulation, "refrigerator")
    assert sorted(joints.values()) == ["freezer_door_joint", "fridge_door_joint"]
    assert asset.asset_from_link("freezer_door").position[2] > asset.asset_from_link("fridge_door").position[2]


def test_a_thing_of_no_known_kind_keeps_its_names(tmp_path: Path) -> None:
    built = build(wish(obj(tmp_path / "x.obj", *drawers()[:2]), tmp_path, ""))
    asset, joints = rename_for_runtime(built.asset, built.articulation, "object")
    assert sorted(joints.values()) == ["drawer_0_joint", "drawer_1_joint"]
    assert asset.joints == built.asset.joints
