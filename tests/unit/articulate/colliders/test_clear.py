"""Shapes give way to what passes them where they only touch, and not where something really stands in the way."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.articulate.link_shapes import CLEARANCE_M, LinkSolid, box_cloud, clear_moving_parts, convex_clouds
from tests.unit.articulate.blocks import carcass, together


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
