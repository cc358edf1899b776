"""The box under hulls that stand on a flat foot: where there is one, how large it is, and where there is none."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.core.numeric import Floats
from casa_assets.ingest.collision.fit import FOOT_M, on_flat_foot
from casa_assets.ingest.draft import PlacedShape
from casa_assets.mesh.solid.primitive import shape_bounds
from casa_assets.mesh.solid.solids import Solid, convex_hull
from casa_assets.model.asset.parts import Box, Hull, Mesh
from tests.support.mesh.solids import solid


def hull(points: Floats) -> PlacedShape:
    vertices, faces = convex_hull(points)
    return PlacedShape(shape=Hull(mesh=Mesh(vertices=vertices, faces=faces)))


def prism(sides: int, radius: float, height: float, x: float = 0.0) -> Floats:
    """(2 * sides, 3) corners of an upright prism that stands on z = 0."""
    angles = np.arange(sides) * 2 * np.pi / sides
    ring = np.stack([radius * np.cos(angles) + x, radius * np.sin(angles)], axis=1)
    return np.concatenate([np.column_stack([ring, np.full(sides, z)]) for z in (0.0, height)])


def around(*shapes: PlacedShape) -> Solid:
    found = Solid()
    for shape in shapes:
        assert isinstance(shape.shape, Hull)
        found += solid(shape.shape.mesh)
    return found


def test_a_hull_on_a_flat_foot_stands_on_a_box_within_its_outline() -> None:
    can = hull(prism(24, 0.05, 0.1))
    raised, box = on_flat_foot([can], around(can))
    assert isinstance(box.shape, Box)
    low, high = shape_bounds(box.shape, box.pose)
    assert low[2] == pytest.approx(0.0)
    assert high[2] == pytest.approx(FOOT_M)
    assert np.hypot(*box.shape.size[:2]) <= 2 * 0.05 + 1e-9
    assert min(box.shape.size[:2]) > 0.06
    # What is above the foot is as it was; the box alone touches the floor.
    bounds = shape_bounds(raised.shape, raised.pose)
    assert bounds[0, 2] == pytest.approx(FOOT_M / 2)
    assert bounds[1] == pytest.approx([0.05, 0.05, 0.1])


def test_a_turned_foot_gets_a_turned_box() -> None:
    angle = np.pi / 6
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])
    corners = np.array([(x, y, z) for x in (-0.1, 0.1) for y in (-0.02, 0.02) for z in (0.0, 0.05)]) @ turn.T
    _, box = on_flat_foot([hull(corners)], None)
    assert isinstance(box.shape, Box)
    assert sorted(box.shape.size) == pytest.approx([FOOT_M, 0.04, 0.2], rel=1e-3)


def test_what_has_no_flat_foot_stays_as_it_is(subtests: pytest.Subtests) -> None:
    for shapes in [
        # Legs: what is between them is no foot.
        [hull(prism(8, 0.01, 0.1, x)) for x in (-0.1, 0.1)],
        # An edge, and a tip.
        [hull(np.array([(-0.1, 0, 0), (0.1, 0, 0), (0, 0.05, 0.1), (0, -0.05, 0.1)], dtype=np.float64))],
        [hull(np.concatenate([[(0.0, 0.0, 0.0)], prism(12, 0.05, 0.1)[12:]]))],
        # A box stands by itself.
        [PlacedShape(shape=Box(size=(0.1, 0.1, 0.1)))],
    ]:
        with subtests.test(shapes=shapes):
            whole = None if isinstance(shapes[0].shape, Box) else around(*shapes)
            assert on_flat_foot(shapes, whole) == tuple(shapes)
