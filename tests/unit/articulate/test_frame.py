"""Up, front, the turn and the kind of things that stand anywhere in their files."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from casa_assets import registry
from casa_assets.articulate.frame import (
    given_frame,
    guess_frame,
)
from casa_assets.articulate.kinds import (
    KIND_NAMES,
    KIND_TRAITS,
    kind_named,
)
from casa_assets.articulate.segment.fragments import WeldedMesh, weld_triangles
from casa_assets.articulate.segment.orthographic import SIDES
from tests.unit.articulate.blocks import Floats, Ints, box, carcass, disc, drawers, microwave, together

pytestmark = pytest.mark.content("code", "articulate", keep=0)


UP, FACING = np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0])
Y_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


def yaw(degrees: float) -> Floats:
    """A turn about z."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


def oven() -> tuple[Floats, Ints, Ints]:
    """A range: a door with a level bar at its top, four knobs above it, and feet."""
    return together(
        *carcass(0.6, 0.6, 0.85),
        box((0.01, -0.03, 0.12), (0.59, 0.0, 0.66)),
        box((0.06, -0.08, 0.6), (0.54, -0.06, 0.62)),
        box((0.06, -0.06, 0.6), (0.08, -0.03, 0.62)),
        box((0.52, -0.06, 0.6), (0.54, -0.03, 0.62)),
        *(disc((x, -0.04, 0.75), 0.025, 0.04) for x in (0.12, 0.24, 0.36, 0.48)),
        *(box((x, y, -0.03), (x + 0.04, y + 0.04, 0.0)) for x in (0.02, 0.54) for y in (0.02, 0.54)),
    )


THINGS = {"drawers": drawers, "microwave": microwave, "oven": oven}


def turned(name: str, rotation: Floats, scale: float = 1.0) -> WeldedMesh:
    """One of THINGS in another pose, with other units, moved."""
    vertices, faces, _ = THINGS[name]()
    return weld_triangles(vertices @ rotation.T * scale + np.array([3.0, -2.0, 7.0]) * scale, faces)


def test_the_front_is_found_from_any_side(subtests: pytest.Subtests) -> None:
    poses = ((0.0, np.eye(3)), (90.0, Y_UP), (180.0, np.eye(3)), (-27.0, Y_UP), (33.3, np.eye(3)))
    for name, (degrees, stands) in product(("drawers", "oven"), poses):
        with subtests.test(name=name, degrees=degrees, stands=stands):
            rotation = stands @ yaw(degrees)
            found = guess_frame(turned(name, rotation, 100.0))
            assert found.rotation[2] == pytest.approx(rotation @ UP, abs=2e-3)
            assert found.rotation[1] == pytest.approx(-rotation @ FACING, abs=2e-3)
            assert 0.0 < found.confidence <= 1.0
            assert found.runner_up


@pytest.mark.parametrize("degrees", [0.0, 2.0, 41.0])
def test_the_thing_fills_its_box(degrees: float) -> None:
    mesh = turned("microwave", yaw(degrees), 10.0)
    frame = guess_frame(mesh, up=UP.tolist(), front=(yaw(degrees) @ FACING).tolist())
    placed = mesh.in_frame(frame)
    low, high = placed.points.min(axis=0), placed.points.max(axis=0)
    assert np.linalg.norm(high - low) == pytest.approx(1.0)
    assert (low + high) / 2 == pytest.approx(np.zeros(3), abs=1e-9)
    size = np.array([0.5, 0.43, 0.3])
    assert high - low == pytest.approx(size / np.linalg.norm(size), abs=2e-3)
    assert frame.to_file(placed.points) == pytest.approx(mesh.points, abs=1e-9)


@pytest.mark.representatives(2)
@pytest.mark.parametrize("face", [3, 4, 0, 1, 2, 5])
def test_what_the_user_says_holds(face: int) -> None:
    mesh = turned("drawers", np.eye(3))
    front = -SIDES[face][2]
    for up in (-SIDES[k][2] for k in range(6) if k // 2 != face // 2):
        found = guess_frame(mesh, up=up.tolist(), front=front.tolist())
        assert found.rotation == pytest.approx(given_frame(mesh, up.tolist(), front.tolist()).rotation)
        assert found.reason == "given"
    assert guess_frame(mesh, front=front.tolist()).rotation[1] == pytest.approx(-front)
    assert guess_frame(mesh, up=front.tolist()).rotation[2] == pytest.approx(front)


def test_the_word_of_the_file_counts() -> None:
    cube = weld_triangles(*together(box((0, 0, 0), (1, 1, 1)))[:2])
    for side in range(6):
        assert guess_frame(cube, stated=side).rotation[2] == pytest.approx(-SIDES[side][2])


PIXELS = 128


def test_whole_words_name_a_kind(subtests: pytest.Subtests) -> None:
    for hint, kind in [
        ("kitchenMicrowave", "microwave"),
        ("kitchen-stove_02", "range"),
        ("Fridge freezer", "refrigerator"),
        ("oven", "wall_oven"),
        ("toaster oven", "toaster_oven"),
        ("coffee_maker", "coffee_machine"),
        ("electric kettle", "kettle"),
        ("orange", None),
        ("strange", None),
        ("mesh_0042", None),
    ]:
        with subtests.test(hint=hint, kind=kind):
            found = kind_named([hint])
            assert (found.id if found else None) == kind


def test_every_kind_is_a_fixture_of_the_registry() -> None:
    fixtures = registry.load().fixtures
    assert set(KIND_NAMES) <= set(fixtures)
    assert set(KIND_TRAITS) <= set(fixtures)
