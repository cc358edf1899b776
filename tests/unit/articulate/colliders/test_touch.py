"""What is touched of a taken-apart thing: frames stay open, edges are handles, coarse shapes give way."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.articulate.build_colliders import GRIP_WIDTH_M, add_edge_grip
from casa_assets.articulate.link_shapes import (
    LinkSolid,
    box_cloud,
    clear_moving_parts,
    convex_clouds,
    hull_closes_opening,
    is_empty_region,
    is_frame,
)
from casa_assets.articulate.plan import PartKind
from tests.unit.articulate.blocks import box, disc, together

Z = np.array([0.0, 0.0, 1.0])


def cloud(low: tuple[float, float, float], high: tuple[float, float, float]) -> np.ndarray:
    return box_cloud(np.array(low), np.array(high))


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


def test_a_board_and_a_block_close_nothing() -> None:
    for high in ((0.6, 0.02, 1.0), (0.6, 0.5, 1.0)):
        points, faces = box((0, 0, 0), high)
        assert not hull_closes_opening(points, faces)


def test_a_disc_without_thickness_is_touched_over_all_of_its_outline() -> None:
    points, faces = disc((0, 0, 0), 0.15, 0.0, 32)
    (found,) = convex_clouds(points, faces, 8)
    assert np.ptp(found[:, 0]) == pytest.approx(0.3, abs=1e-6)
    assert np.ptp(found[:, 1]) == pytest.approx(0.002, abs=1e-6)
    # Its corners are free: it is a disc, not a box.
    assert np.linalg.norm(found[:, [0, 2]], axis=1).max() < 0.16


def test_a_door_without_a_handle_is_taken_by_its_free_edge() -> None:
    door = LinkSolid(0, [cloud((0.0, -0.02, 0.0), (0.4, 0.0, 0.6))], [], True, -Z, np.array([0.0, -0.003, 0.3]), 1.57)
    add_edge_grip(door, PartKind.DOOR)
    (grip,) = door.grips
    assert grip[:, 0].min() == pytest.approx(0.4 - GRIP_WIDTH_M)
    assert grip[:, 0].max() == pytest.approx(0.4)
    assert max(c[:, 0].max() for c in door.clouds) == pytest.approx(0.4 - GRIP_WIDTH_M)


def test_a_drawer_without_a_handle_is_taken_by_the_upper_edge_of_its_front() -> None:
    front, side = cloud((0.0, 0.0, 0.0), (0.4, 0.02, 0.2)), cloud((0.0, 0.02, 0.0), (0.01, 0.5, 0.25))
    drawer = LinkSolid(0, [front, side], [], False, np.array([0.0, -1.0, 0.0]), np.zeros(3), 0.3)
    add_edge_grip(drawer, PartKind.DRAWER)
    (grip,) = drawer.grips
    assert grip[:, 2].max() == pytest.approx(0.2)
    assert grip[:, 1].max() == pytest.approx(0.02)


def test_what_has_a_handle_or_is_no_front_keeps_its_shapes() -> None:
    bar = cloud((0.35, -0.05, 0.2), (0.37, -0.03, 0.4))
    held = LinkSolid(0, [cloud((0, -0.02, 0), (0.4, 0, 0.6))], [bar], True, -Z, np.zeros(3), 1.57)
    knob = LinkSolid(
        0, [cloud((0, -0.02, 0), (0.04, 0, 0.04))], [], True, np.array([0.0, -1.0, 0.0]), np.zeros(3), 6.28
    )
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
