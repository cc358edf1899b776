"""From the bytes of a file to an Asset: links in metres, named for runtimes; what is touched of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.spatial import cKDTree

from casa_assets.articulate.assemble import MAX_DENSITY_KG_M3, SHEET_GAP_M, drop_empty_links
from casa_assets.articulate.build_colliders import GRIP_WIDTH_M, add_edge_grip, build_colliders
from casa_assets.articulate.frame import metres_per_unit
from casa_assets.articulate.link_shapes import (
    CLEARANCE_M,
    MIN_THICKNESS_M,
    LinkSolid,
    box_cloud,
    clear_moving_parts,
    convex_clouds,
    fit_shape,
    hull_closes_opening,
    is_frame,
)
from casa_assets.articulate.plan import Articulation, PartKind, PartPlan
from casa_assets.articulate.run.build import ArticulateRequest, build
from casa_assets.articulate.runtime.names import rename_for_runtime
from casa_assets.articulate.segment.fragments import WeldedMesh, weld_triangles
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.mesh.solid.solids import hull_volume
from casa_assets.mesh.surface import signed_volume
from casa_assets.model.asset.parts import Hull, JointKind
from casa_assets.model.pose import Pose
from casa_assets.model.registry.category import SizeRange
from tests.unit.articulate.blocks import (
    AS_IT_IS,
    Floats,
    Ints,
    box,
    carcass,
    disc,
    drawers,
    microwave,
    plan_of,
    slides,
    together,
)

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
    assert joint.name == joints["door_0"] == "microjoint"
    assert joint.axis == pytest.approx((0.0, 0.0, 1.0))
    assert joint.range == pytest.approx((-np.pi / 2, 0.0), abs=1e-5)
    assert joint.grip == "door_handle_main"
    assert {s.name for s in named.states} == {"microjoint_closed", "microjoint_open"}
    main = next(r for r in named.regions if r.name == "main")
    # The handle, the knob and the buttons stand out of the region by which it is placed.
    assert main.size == pytest.approx((0.5, 0.4, 0.3), abs=1e-3)
    assert joints["knob_0"] == "knob_0_joint"


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
    _, blocking = build_colliders(vertices, mesh, Articulation(frame=AS_IT_IS, parts=parts), "steel")
    assert blocking == [None, 0, None]


def test_a_rack_of_wires_is_touched_as_a_basket() -> None:
    wires = [box((x, 0.0, 0.0), (x + 0.003, 0.4, 0.003)) for x in np.linspace(0.0, 0.5, 36)]
    wires += [box((0.0, y, z), (0.503, y + 0.003, z + 0.003)) for y in (0.0, 0.397) for z in (0.04, 0.08, 0.12)]
    vertices, faces, _ = together(*wires)
    mesh = weld_triangles(vertices, faces)
    joint, every = slides((0.25, 0.2, 0.06)), np.arange(len(faces))
    rack = plan_of("rack", PartKind.TRAY, every, joint).replace(grip=every)
    (_, found), _ = build_colliders(vertices, mesh, Articulation(frame=AS_IT_IS, parts=(rack,)), "steel")
    assert {c.label for c in found} == {"rack"}
    assert len(found) <= 12
    # One finds a floor in its middle, and no lid.
    shapes = [c.pose.apply(tessellate(c.shape, Pose())[0]) + np.array(joint.anchor) for c in found]
    at = (0.25, 0.2)
    (over,) = (p[:, 2] for p in shapes if ((p.min(axis=0)[:2] < at) & (p.max(axis=0)[:2] > at)).all())
    assert over.max() < 0.05


def test_units_make_a_thing_of_its_usual_size() -> None:
    span = SizeRange(low=0.43, typical=0.52, high=0.8)
    for longest, stated, unit in [
        (0.5, None, 1.0),
        (50.0, None, 0.01),
        (500.0, None, 0.001),
        (0.5, 1.0, 1.0),
        (1.0, None, 0.52),
        (7e5, None, 0.52 / 7e5),
    ]:
        assert metres_per_unit(longest, stated, span)[0] == pytest.approx(unit), (longest, stated)


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
    assert sum(len(v.mesh.faces) for k in asset.links for v in k.visuals) == len(drawers()[1])
    assert all(k.colliders for k in asset.links)
    assert sum(k.inertial.mass for k in asset.links) == pytest.approx(asset.mass)
    assert asset.joints == built.asset.joints


def cloud(low: tuple[float, float, float], high: tuple[float, float, float]) -> np.ndarray:
    return box_cloud(np.array(low), np.array(high))


def slider(shape: np.ndarray, far: float) -> LinkSolid:
    """Slides along -y, carried by the body."""
    return LinkSolid(0, [shape], [], axis=np.array([0.0, -1.0, 0.0]), anchor=np.zeros(3), max_travel=far)


def test_faces_that_touch_are_parted_and_what_stands_in_the_way_is_left() -> None:
    wall = LinkSolid(None, [cloud((-0.5, 0.0, 0.0), (0.5, 0.3, 0.02))], [])
    drawer = slider(cloud((-0.4, -0.1, 0.018), (0.4, 0.3, 0.2)), 0.3)
    clear_moving_parts([wall, drawer])
    top = max(float(c[:, 2].max()) for c in wall.clouds if c[:, 0].min() < 0.0 < c[:, 0].max())
    # What hangs before the wall at rest only moves away from it.
    bottom = min(float(c[:, 2].min()) for c in drawer.clouds if c[:, 1].max() > 0.01)
    assert bottom - top >= CLEARANCE_M - 1e-9
    post = LinkSolid(None, [cloud((-0.1, -0.4, 0.0), (0.1, -0.2, 0.4))], [])
    drawer = slider(cloud((-0.4, -0.1, 0.0), (0.4, 0.3, 0.3)), 0.3)
    clear_moving_parts([post, drawer])
    assert len(post.clouds) == len(drawer.clouds) == 1
    assert np.ptp(drawer.clouds[0], axis=0) == pytest.approx([0.8, 0.4, 0.3])


def test_what_turns_round_gets_room_for_its_corners_in_every_pose() -> None:
    """A square knob beside a plate of the same depth: at rest its side lies 1 mm away, its corners reach farther."""
    plate = LinkSolid(None, [cloud((0.021, -0.02, -0.1), (0.2, 0.0, 0.1))], [])
    knob = LinkSolid(0, [cloud((-0.02, -0.02, -0.02), (0.02, 0.0, 0.02))], [], turns=True, spins=True, is_whole=True)
    knob.axis, knob.anchor, knob.max_travel = np.array([0.0, -1.0, 0.0]), np.zeros(3), 2 * np.pi
    clear_moving_parts([plate, knob])
    reach = 0.02 * np.sqrt(2.0)
    for shape in plate.clouds:
        low, high = shape.min(axis=0), shape.max(axis=0)
        nearest = np.clip(np.zeros(3), low, high)[[0, 2]]
        assert np.linalg.norm(nearest) >= reach - 1e-9
    assert max(c[:, 0].max() for c in plate.clouds) == pytest.approx(0.2)


def _disc(radius: float) -> Floats:
    """A flat disc that is tilted against all axes, as single precision holds it."""
    angle = np.arange(24) / 24 * 2 * np.pi
    flat = np.stack([np.cos(angle) * radius, np.sin(angle) * radius, 0 * angle], axis=1)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    return (flat @ turn).astype(np.float32).astype(np.float64)


def test_a_tilted_sheet_has_a_shape_with_a_volume() -> None:
    for sheet in [_disc(0.3), _disc(0.0005), _disc(0.3)[:2], _disc(0.3)[:1]]:
        points = sheet + 0.2
        shape, pose = fit_shape(points)
        assert isinstance(shape, Hull)
        vertices = " ".join(f"{v:.9g}" for v in shape.mesh.vertices.ravel())
        model = mujoco.MjModel.from_xml_string(
            f'<mujoco><asset><mesh name="m" vertex="{vertices}"/></asset>'
            '<worldbody><geom type="mesh" mesh="m"/></worldbody></mujoco>'
        )
        assert model.ngeom == 1
        placed = shape.mesh.vertices + np.array(pose.position)
        beyond = np.maximum(placed.max(axis=0) - points.max(axis=0), points.min(axis=0) - placed.min(axis=0))
        assert beyond.max() <= MIN_THICKNESS_M / 2 * np.sqrt(3) + 1e-6


def _part(name: str, faces: list[int], parent: str = "") -> PartPlan:
    return plan_of(name, PartKind.DOOR, np.array(faces, dtype=np.int64), slides((0.0, 0.0, 0.0)), parent)


def _plan(*parts: PartPlan) -> tuple[Articulation, WeldedMesh]:
    vertices, faces, _ = together(box((0, 0, 0), (1, 1, 1)), box((2, 0, 0), (3, 3, 3)))
    return Articulation(frame=AS_IT_IS, parts=parts), weld_triangles(vertices, faces)


def test_a_part_without_faces_is_no_part_and_what_it_carried_stays() -> None:
    plan, mesh = _plan(_part("a", [0, 1]), _part("b", [], "a"), _part("c", [2, 3], "b"))
    kept = drop_empty_links(plan, mesh).parts
    assert [(p.name, p.parent) for p in kept] == [("a", ""), ("c", "a")]
    plan, mesh = _plan(_part("a", [0, 1, 2]), _part("b", [1, 2, 3]), _part("same", [4, 5]), _part("twin", [4, 5]))
    kept = drop_empty_links(plan, mesh).parts
    assert [(p.name, p.faces.tolist()) for p in kept] == [("a", [0]), ("b", [1, 2, 3]), ("twin", [4, 5])]
    # Where parts take all faces the largest is the body.
    plan, mesh = _plan(_part("small", list(range(12))), _part("large", list(range(12, 24))))
    assert [p.name for p in drop_empty_links(plan, mesh).parts] == ["small"]
    plan, mesh = _plan(_part("all", list(range(24))))
    assert drop_empty_links(plan, mesh).parts == ()


Z = np.array([0.0, 0.0, 1.0])


def test_a_hull_round_a_gasket_would_close_its_door() -> None:
    level = [box((0, 0, z), (0.6, 0.004, z + 0.02)) for z in (0, 0.98)]
    upright = [box((x, 0, 0.02), (x + 0.02, 0.004, 0.98)) for x in (0, 0.58)]
    points, faces, _ = together(*level, *upright)
    assert hull_closes_opening(points, faces)
    assert is_frame(points, faces)
    for high in ((0.6, 0.02, 1.0), (0.6, 0.5, 1.0)):  # neither does one round a board or a block
        assert not hull_closes_opening(*box((0, 0, 0), high))


def test_a_disc_without_thickness_is_touched_over_all_of_its_outline() -> None:
    points, faces = disc((0, 0, 0), 0.15, 0.0, 32)
    (found,) = convex_clouds(points, faces, 8)
    assert np.ptp(found[:, 0]) == pytest.approx(0.3, abs=1e-6)
    assert np.ptp(found[:, 1]) == pytest.approx(0.002, abs=1e-6)
    # Its corners are free: it is a disc, not a box.
    assert np.linalg.norm(found[:, [0, 2]], axis=1).max() < 0.16


def test_a_front_without_a_handle_is_taken_by_the_edge_that_opens() -> None:
    door = LinkSolid(0, [cloud((0.0, -0.02, 0.0), (0.4, 0.0, 0.6))], [], True, -Z, np.array([0.0, -0.003, 0.3]), 1.57)
    add_edge_grip(door, PartKind.DOOR)
    (grip,) = door.grips
    assert grip[:, 0].min() == pytest.approx(0.4 - GRIP_WIDTH_M)
    assert grip[:, 0].max() == pytest.approx(0.4)
    assert max(c[:, 0].max() for c in door.clouds) == pytest.approx(0.4 - GRIP_WIDTH_M)
    front, side = cloud((0.0, 0.0, 0.0), (0.4, 0.02, 0.2)), cloud((0.0, 0.02, 0.0), (0.01, 0.5, 0.25))
    drawer = LinkSolid(0, [front, side], [], False, np.array([0.0, -1.0, 0.0]), np.zeros(3), 0.3)
    add_edge_grip(drawer, PartKind.DRAWER)
    (grip,) = drawer.grips
    assert grip[:, 2].max() == pytest.approx(0.2)
    assert grip[:, 1].max() == pytest.approx(0.02)
    bar, knob = cloud((0.35, -0.05, 0.2), (0.37, -0.03, 0.4)), slider(cloud((0, -0.02, 0), (0.04, 0, 0.04)), 6.28)
    held = LinkSolid(0, [cloud((0, -0.02, 0), (0.4, 0, 0.6))], [bar], True, -Z, np.zeros(3), 1.57)
    knob.turns = True
    add_edge_grip(held, PartKind.DOOR)
    add_edge_grip(knob, PartKind.KNOB)
    assert len(held.grips) == 1
    assert held.grips[0] is bar
    assert knob.grips == []


def test_a_rack_that_slides_out_notches_the_lip_of_its_mouth_and_not_a_post_before_it() -> None:
    rack = cloud((-0.23, 0.0, 0.2), (0.23, 0.4, 0.21))
    lip, post = cloud((0.224, -0.02, 0.0), (0.25, -0.018, 0.4)), cloud((-0.01, -0.03, 0.0), (0.01, -0.01, 0.4))
    body = LinkSolid(None, [lip, post], [])
    slides = LinkSolid(0, [rack], [], False, np.array([0.0, -1.0, 0.0]), np.zeros(3), 0.3, is_behind_front=True)
    clear_moving_parts([body, slides])
    assert any((c == post).all() for c in body.clouds if c.shape == post.shape)
    left = [c for c in body.clouds if c[:, 0].min() > 0.1]
    assert len(left) == 3
    assert all(c[:, 2].max() <= 0.2 or c[:, 2].min() >= 0.21 or c[:, 0].min() >= 0.23 for c in left)
