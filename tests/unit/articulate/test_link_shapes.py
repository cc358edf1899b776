"""What is touched of a thing: shapes give way, frames stay open, edges are handles, thin links have shapes."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from casa_assets.articulate.assemble import drop_empty_links
from casa_assets.articulate.build_colliders import GRIP_WIDTH_M, add_edge_grip
from casa_assets.articulate.link_shapes import (
    CLEARANCE_M,
    MIN_THICKNESS_M,
    LinkSolid,
    box_cloud,
    clear_moving_parts,
    convex_clouds,
    fit_shape,
    hull_closes_opening,
    is_empty_region,
    is_frame,
)
from casa_assets.articulate.plan import Articulation, PartKind, PartPlan
from casa_assets.articulate.segment.fragments import WeldedMesh, weld_triangles
from casa_assets.model.asset.parts import Hull
from tests.unit.articulate.blocks import Floats, box, carcass, disc, together
from tests.unit.articulate.fragmented import AS_IT_IS, plan_of, slides


def cloud(low: tuple[float, float, float], high: tuple[float, float, float]) -> np.ndarray:
    return box_cloud(np.array(low), np.array(high))


def slider(shape: np.ndarray, far: float) -> LinkSolid:
    """Slides along -y, carried by the body."""
    return LinkSolid(0, [shape], [], axis=np.array([0.0, -1.0, 0.0]), anchor=np.zeros(3), max_travel=far)


def test_faces_that_touch_are_parted() -> None:
    wall = LinkSolid(None, [cloud((-0.5, 0.0, 0.0), (0.5, 0.3, 0.02))], [])
    drawer = slider(cloud((-0.4, -0.1, 0.018), (0.4, 0.3, 0.2)), 0.3)
    clear_moving_parts([wall, drawer])
    top = max(float(c[:, 2].max()) for c in wall.clouds if c[:, 0].min() < 0.0 < c[:, 0].max())
    # What hangs before the wall at rest only moves away from it.
    bottom = min(float(c[:, 2].min()) for c in drawer.clouds if c[:, 1].max() > 0.01)
    assert bottom - top >= CLEARANCE_M - 1e-9


def test_what_stands_in_the_way_is_left() -> None:
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


def test_shapes_leave_a_cavity_open_and_keep_to_their_number() -> None:
    vertices, faces, _ = together(*carcass(0.5, 0.4, 0.3))
    for most in (5, 12):
        clouds = convex_clouds(vertices, faces, most)
        assert 1 < len(clouds) <= most
        middle = np.array([0.25, 0.1, 0.15])
        assert not any(((c.min(axis=0) < middle) & (middle < c.max(axis=0))).all() for c in clouds)


def _disc(radius: float) -> Floats:
    """A flat disc that is tilted against all axes, as single precision holds it."""
    angle = np.arange(24) / 24 * 2 * np.pi
    flat = np.stack([np.cos(angle) * radius, np.sin(angle) * radius, 0 * angle], axis=1)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    return (flat @ turn).astype(np.float32).astype(np.float64)


def test_a_tilted_sheet_has_a_shape_with_a_volume(subtests: pytest.Subtests) -> None:
    for cloud in [_disc(0.3), _disc(0.0005), _disc(0.3)[:2], _disc(0.3)[:1]]:
        with subtests.test(cloud=cloud):
            shape, pose = fit_shape(cloud + 0.2)
            assert isinstance(shape, Hull)
            vertices = " ".join(f"{v:.9g}" for v in shape.mesh.vertices.ravel())
            model = mujoco.MjModel.from_xml_string(
                f'<mujoco><asset><mesh name="m" vertex="{vertices}"/></asset>'
                '<worldbody><geom type="mesh" mesh="m"/></worldbody></mujoco>'
            )
            assert model.ngeom == 1
            placed = shape.mesh.vertices + np.array(pose.position)
            beyond = np.maximum(
                placed.max(axis=0) - (cloud + 0.2).max(axis=0), (cloud + 0.2).min(axis=0) - placed.min(axis=0)
            )
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


def gasket() -> tuple[np.ndarray, np.ndarray]:
    points, faces, _ = together(
        box((0, 0, 0), (0.6, 0.004, 0.02)),
        box((0, 0, 0.98), (0.6, 0.004, 1.0)),
        box((0, 0, 0.02), (0.02, 0.004, 0.98)),
        box((0.58, 0, 0.02), (0.6, 0.004, 0.98)),
    )
    return points, faces


def test_a_hull_round_a_gasket_would_close_its_door() -> None:
    assert hull_closes_opening(*gasket())
    assert is_frame(*gasket())
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


def test_a_place_is_air_where_what_is_seen_bounds_it_on_one_side_alone() -> None:
    place = np.array([[0.0, 0.0, 0.0], [0.05, 0.06, 0.4]])
    spread = np.random.default_rng(1).uniform(0.0, 1.0, (400, 2))
    wall = np.column_stack([np.zeros(400), 0.06 * spread[:, 0], 0.4 * spread[:, 1]])
    other = wall + np.array([0.05, 0.0, 0.0])
    assert is_empty_region(wall, [place])
    assert not is_empty_region(np.concatenate([wall, other]), [place])
    assert not is_empty_region(wall + np.array([0.025, 0.0, 0.0]), [place])
    assert not is_empty_region(None, [place])
