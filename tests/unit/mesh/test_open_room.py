"""Open rooms: what a ball gets into from above or beside is one, dents and what is open only below are none."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.solid.solids import surface_of
from casa_assets.mesh.voxels import closed_shares, open_rooms
from casa_assets.model.record import Vec3
from tests.support.mesh.raw_models import MUG, turned
from tests.support.mesh.solids import block, box, welded

BOX = ((0.2, 0.12, 0.1), (0.0, 0.0, 0.05))


def hollowed(*cores: tuple[Vec3, Vec3]) -> tuple[Floats, Ints]:
    """A box without some boxes, each of a size and about a centre."""
    made = block(*BOX)
    for core in cores:
        made -= block(*core)
    return surface_of(made)


CRATE = hollowed(((0.18, 0.1, 0.1), (0.0, 0.0, 0.06)))


def test_the_compartments_of_a_shelf_are_rooms_of_their_own() -> None:
    shelf = hollowed(((0.18, 0.12, 0.038), (0.0, 0.01, 0.026)), ((0.18, 0.12, 0.038), (0.0, 0.01, 0.074)))
    assert len(open_rooms(*shelf).shares) == 2


def test_what_is_no_room(subtests: pytest.Subtests) -> None:
    for core in [
        ((0.18, 0.1, 0.1), (0.0, 0.0, 0.04)),
        ((0.18, 0.1, 0.08), (0.0, 0.0, 0.05)),
        ((0.18, 0.006, 0.1), (0.0, 0.0, 0.06)),
        ((0.05, 0.05, 0.02), (0.0, 0.0, 0.1)),
    ]:
        with subtests.test(core=core):
            assert open_rooms(*hollowed(core)).shares == ()


def test_faces_look_into_a_vessel_and_backs_into_a_gap() -> None:
    [facing] = open_rooms(*welded(turned(MUG, 32))).facing
    assert facing > 0.9
    points, faces = welded(box(*BOX))
    top = (points[faces][:, :, 2] > 0.09).all(axis=1)
    [facing] = open_rooms(points, faces[~top]).facing
    assert facing < 0.1


@pytest.mark.parametrize(
    ("size", "center", "low", "high"),
    [
        pytest.param((0.18, 0.1, 0.045), (0.0, 0.0, 0.032), 0.4, 0.6, id="filled by half"),
        pytest.param((0.19, 0.11, 0.002), (0.0, 0.0, 0.099), 0.95, 1.0, id="a thin lid"),
        pytest.param((0.18, 0.01, 0.09), (0.0, 0.0, 0.055), 0.0, 0.3, id="a wall across"),
    ],
)
def test_what_shapes_fill_or_close_off(size: Vec3, center: Vec3, low: float, high: float) -> None:
    found = open_rooms(*CRATE)
    assert closed_shares(found, *CRATE) == [pytest.approx(0.0, abs=0.02)]
    points, faces = welded(box(size, center))
    both = np.concatenate([CRATE[0], points]), np.concatenate([CRATE[1], faces + len(CRATE[0])])
    [share] = closed_shares(found, *both)
    assert low <= share <= high
