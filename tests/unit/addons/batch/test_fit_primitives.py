"""Fewer boxes that close the same space off, and a few boxes and cylinders around the primitives of a loose thing."""

from __future__ import annotations

import math

import numpy as np

from casa_assets.addons.batch.fit_primitives import (
    TOLERANCE_M,
    FitLimits,
    ReachableSpace,
    cover_boxes,
    fit_primitives,
    points_around,
)
from casa_assets.core.numeric import Floats
from casa_assets.mesh.solid.primitive import shape_bounds
from casa_assets.model.asset.parts import Box, Cylinder, Shape
from casa_assets.model.pose import Pose

Placed = tuple[Shape, Pose]


def box(size: tuple[float, float, float], at: tuple[float, float, float]) -> Placed:
    return Box(size=size), Pose(position=at)


def table() -> list[Placed]:
    legs = [box((0.05, 0.05, 0.7), (x, y, 0.35)) for x in (-0.5, 0.5) for y in (-0.3, 0.3)]
    return [box((1.1, 0.7, 0.04), (0.0, 0.0, 0.72)), *legs]


def jar(sides: int = 12, radius: float = 0.06, height: float = 0.2) -> list[Placed]:
    """A bottom, and walls of 3 mm in a ring."""
    walls = []
    for i in range(sides):
        turn = 2 * math.pi * i / sides
        pose = Pose(
            position=(radius * math.cos(turn), radius * math.sin(turn), height / 2),
            quaternion=(math.cos(turn / 2), 0.0, 0.0, math.sin(turn / 2)),
        )
        walls.append((Box(size=(0.003, 2.1 * radius * math.tan(math.pi / sides), height)), pose))
    return [(Cylinder(radius=radius, height=0.004), Pose(position=(0.0, 0.0, 0.002))), *walls]


def reach(placed: list[Placed]) -> np.ndarray:
    bounds = np.array([shape_bounds(shape, pose) for shape, pose in placed])
    return np.array([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)])


class TestFitPrimitives:
    def test_a_table_keeps_its_legs_apart_and_its_outline(self) -> None:
        found = fit_primitives(table(), FitLimits(most=5, empty_share=0.35))
        assert sorted(piece.covered for piece in found) == [(0,), (1,), (2,), (3,), (4,)]
        for most in (1, 2, 3):
            found = fit_primitives(table(), FitLimits(most, empty_share=0.35))
            assert len(found) <= most
            fitted = reach([(piece.shape, piece.pose) for piece in found])
            assert np.allclose(fitted, reach(table()), atol=0.005)

    def test_a_round_thing_becomes_a_cylinder(self) -> None:
        disc = Cylinder(radius=0.05, height=0.02)
        discs: list[Placed] = [(disc, Pose(position=(0.0, 0.0, 0.01 + 0.02 * i))) for i in range(5)]
        (piece,) = fit_primitives(discs, FitLimits(most=1, empty_share=0.35))
        assert isinstance(piece.shape, Cylinder)
        assert abs(piece.shape.radius - 0.05) < 0.001

    def test_a_vessel_becomes_walls_around_what_it_holds(self) -> None:
        inside = Box(size=(0.07, 0.07, 0.18)), Pose(position=(0.0, 0.0, 0.11))
        found = fit_primitives(jar(), FitLimits(most=4, empty_share=0.35, free=[inside]))
        assert len(found) <= 6
        low, high = shape_bounds(*inside)
        for piece in found:
            corners = shape_bounds(piece.shape, piece.pose)
            overlap = np.minimum(corners[1], high) - np.maximum(corners[0], low)
            assert overlap.min() <= 0.0021, "a wall reaches into what the jar holds"

    def test_a_leg_that_leans_does_not_stand_deeper_and_small_parts_that_change_nothing_are_left_out(self) -> None:
        lean = Pose(position=(0.0, 0.0, 0.3), quaternion=(0.99, 0.141, 0.0, 0.0))
        leg = [(Box(size=(0.04, 0.04, 0.6)), lean), box((0.03, 0.2, 0.03), (0.0, 0.0, 0.3))]
        (piece,) = fit_primitives(leg, FitLimits(most=1, empty_share=0.35))
        assert shape_bounds(piece.shape, piece.pose)[0, 2] >= reach(leg)[0, 2] - 0.001
        screw = box((0.01, 0.01, 0.01), (0.2, 0.1, 0.5))
        (piece,) = fit_primitives([box((1.0, 0.5, 1.0), (0.0, 0.0, 0.5)), screw], FitLimits(4, 0.35))
        assert piece.covered == (0,)

    def test_what_stands_on_it_is_not_reached_into(self) -> None:
        """A pan with a low middle, in which something stands."""
        rim = [box((0.3, 0.02, 0.1), (0.0, y, 0.05)) for y in (-0.14, 0.14)]
        floor = box((0.3, 0.26, 0.04), (0.0, 0.0, 0.02))
        standing = np.array([[[-0.05, -0.05, 0.08], [0.05, 0.05, 0.3]]])
        (piece,) = fit_primitives([floor, *rim], FitLimits(most=1, empty_share=1.0, neighbours=standing))
        assert shape_bounds(piece.shape, piece.pose)[1, 2] <= 0.08 + 1e-9


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
    def test_a_cabinet_is_reached_from_its_front_alone_and_what_stands_askew_closes_it_too(self) -> None:
        assert space_of(cabinet(0.0)).takes_room(*WITHIN)
        assert not space_of(cabinet(0.0, front=True)).takes_room(*WITHIN)
        walls = np.array(cabinet(0.0))
        turned = Pose(position=(0.3, -0.51, 0.4), quaternion=(0.9996, 0.0, 0.0282, 0.0))
        askew = ReachableSpace(walls, points_around(walls), [(Box(size=(0.7, 0.1, 0.9)), turned)])
        assert not askew.takes_room(*WITHIN)
        without_a_free_seed = ReachableSpace(walls, np.array([[0.3, -0.25, 0.009]]))
        assert without_a_free_seed.takes_room(*WITHIN), "everything free is reached"

    def test_a_gap_of_twelve_millimetres_is_closed(self) -> None:
        for gap, is_open in [(0.010, False), (0.014, True)]:
            walls = boxes(((-1, -1, 0), (0, 1, 1)), ((gap, -1, 0), (1, 1, 1)), ((-1, -1, -0.1), (1, 1, 0)))
            assert space_of(walls).takes_room(np.array([0.0, -0.5, 0.2]), np.array([gap, 0.5, 0.8])) is is_open


class TestCoverBoxes:
    def test_backs_and_bottoms_of_a_row_are_one_each_and_a_closed_row_is_one_box(self) -> None:
        row = np.array([*cabinet(0.0), *cabinet(0.6), *cabinet(1.2)])
        covers = cover_boxes(space_of(row))
        # Two outer sides, two pairs of inner ones, a bottom, a top and a back.
        assert len(row) == 15
        assert len(covers) == 7
        assert sorted(i for cover in covers for i in cover.covered) == list(range(15))
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
        row = [*cabinet(0.0, front=True), *shelf]
        (cover,) = cover_boxes(space_of(row))
        assert len(row) - 1 not in cover.covered
