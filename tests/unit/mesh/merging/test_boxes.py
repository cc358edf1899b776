"""Boxes that stand in a room: what can be reached between them, and fewer boxes that close the same space off."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.addons.batch.fit_primitives import TOLERANCE_M, ReachableSpace, cover_boxes, points_around
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.parts import Box
from casa_assets.model.pose import Pose

WITHIN = np.array([[0.2, -0.3, 0.3], [0.3, -0.2, 0.4]])


def boxes(*corners: tuple[tuple[float, float, float], tuple[float, float, float]]) -> Floats:
    """(N, 2, 3) corners."""
    return np.array(corners, dtype=np.float64)


def cabinet(x: float, width: float = 0.6, depth: float = 0.5, front: bool = False) -> list[Floats]:
    """Sides, bottom, top and back of 18 mm, with its left side at x; open to -y, or closed."""
    t, height = 0.018, 0.8
    sides = [((x, -depth, 0.0), (x + t, 0.0, height)), ((x + width - t, -depth, 0.0), (x + width, 0.0, height))]
    inner = (x + t, x + width - t)
    flat = [((inner[0], -depth, z), (inner[1], 0.0, z + t)) for z in (0.0, height - t)]
    back = [((inner[0], -t, t), (inner[1], 0.0, height - t))]
    closed = [((x, -depth - t, 0.0), (x + width, -depth, height))] if front else []
    return list(boxes(*sides, *flat, *back, *closed))


def space_of(found: Floats | list[Floats]) -> ReachableSpace:
    """The space around boxes, reached from all sides."""
    return ReachableSpace(np.array(found), points_around(np.array(found)))


class TestReachableSpace:
    @pytest.mark.parametrize("front", [False, True])
    def test_a_cabinet_is_reached_from_its_front_alone(self, front: bool) -> None:
        assert space_of(cabinet(0.0, front=front)).takes_room(*WITHIN) is not front

    def test_a_gap_of_twelve_millimetres_is_closed(self, subtests: pytest.Subtests) -> None:
        for gap, is_open in [(0.010, False), (0.014, True)]:
            with subtests.test(gap=gap, is_open=is_open):
                walls = boxes(((-1, -1, 0), (0, 1, 1)), ((gap, -1, 0), (1, 1, 1)), ((-1, -1, -0.1), (1, 1, 0)))
                space = space_of(walls)
                assert space.takes_room(np.array([0.0, -0.5, 0.2]), np.array([gap, 0.5, 0.8])) is is_open

    def test_what_stands_askew_closes_too(self) -> None:
        walls = cabinet(0.0)
        turned = Pose(position=(0.3, -0.51, 0.4), quaternion=(0.9996, 0.0, 0.0282, 0.0))
        space = ReachableSpace(np.array(walls), points_around(np.array(walls)), [(Box(size=(0.7, 0.1, 0.9)), turned)])
        assert not space.takes_room(*WITHIN)

    def test_where_no_seed_is_free_everything_free_is_reached(self) -> None:
        walls = np.array(cabinet(0.0))
        space = ReachableSpace(walls, np.array([[0.3, -0.25, 0.009]]))
        assert space.takes_room(*WITHIN)


class TestCoverBoxes:
    def test_backs_and_bottoms_of_a_row_are_one_each(self) -> None:
        row = np.array([*cabinet(0.0), *cabinet(0.6), *cabinet(1.2)])
        covers = cover_boxes(space_of(row))
        # Two outer sides, two pairs of inner ones, a bottom, a top and a back.
        assert len(row) == 15
        assert len(covers) == 7
        assert sorted(i for cover in covers for i in cover.covered) == list(range(15))

    def test_a_closed_row_is_one_box(self) -> None:
        row = np.array([*cabinet(0.0, front=True), *cabinet(0.6, front=True)])
        (cover,) = cover_boxes(space_of(row))
        assert np.allclose(cover.corners, [[0.0, -0.518, 0.0], [1.2, 0.0, 0.8]])

    def test_nothing_sticks_out(self) -> None:
        rng = np.random.default_rng(3)
        lower = rng.uniform(-1, 1, (40, 3))
        room = np.stack([lower, lower + rng.uniform(0.05, 0.6, (40, 3))], axis=1)
        space = space_of(room)
        for cover in cover_boxes(space):
            assert not space.takes_room(*cover.corners)
            for i in cover.covered:
                assert (cover.corners[0] <= room[i, 0] + TOLERANCE_M).all()
                assert (cover.corners[1] >= room[i, 1] - TOLERANCE_M).all()

    def test_what_nothing_can_touch_is_left_out(self) -> None:
        shelf = boxes(((0.018, -0.5, 0.4), (0.582, -0.018, 0.418)))
        row = np.array([*cabinet(0.0, front=True), *shelf])
        (cover,) = cover_boxes(space_of(row))
        assert len(row) - 1 not in cover.covered
