"""Welding, components and winding do not depend on the order of faces and vertices; voxels find the volume."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.mesh.solid.solids import closed_solid, union
from casa_assets.mesh.surface import consistent_winding, face_components, is_closed, signed_volume, weld
from casa_assets.mesh.voxels import voxelise
from casa_assets.model.asset.parts import Box, Cylinder, Shape, Sphere
from casa_assets.model.pose import Pose
from tests.properties.strategies import Floats, Ints, closed, quick, seeds, torus


def several(seed: int, count: int) -> tuple[Floats, Ints]:
    """Closed surfaces side by side."""
    points, faces = [], []
    for i in range(count):
        some, own = closed(seed + i, 12)
        faces.append(own + sum(len(p) for p in points))
        points.append(some + 100.0 * i)
    return np.concatenate(points), np.concatenate(faces)


@quick
@given(seeds, st.integers(1, 5))
def test_weld_undoes_the_splitting_of_vertices(seed: int, count: int) -> None:
    points, faces = several(seed, count)
    order = np.random.default_rng(seed).permutation(len(faces))
    split = points[faces[order]].reshape(-1, 3)
    welded, place = weld(split)
    assert len(welded) == len(points)
    assert np.abs(welded[place] - split).max() <= 1e-6 * np.ptp(points)
    assert is_closed(place.reshape(-1, 3))


@quick
@given(seeds, st.integers(1, 6))
def test_components_do_not_depend_on_the_order_of_faces(seed: int, count: int) -> None:
    points, faces = several(seed, count)
    order = np.random.default_rng(seed).permutation(len(faces))
    straight, shuffled = face_components(faces, len(points)), face_components(faces[order], len(points))
    assert straight.max() + 1 == shuffled.max() + 1 == count
    assert len({*zip(straight[order].tolist(), shuffled.tolist(), strict=True)}) == count
    _, first = np.unique(shuffled, return_index=True)
    assert (np.diff(first) > 0).all()  # numbered by first face


@quick
@given(seeds, st.integers(1, 4), st.booleans())
def test_random_turns_are_undone(seed: int, count: int, holed: bool) -> None:
    points, faces = torus() if holed else several(seed, count)
    draw = np.random.default_rng(seed)
    order = draw.permutation(len(faces))
    flipped = draw.random(len(faces)) < 0.5
    mixed = faces[order].copy()
    mixed[flipped] = mixed[flipped][:, ::-1]
    restored, turned = consistent_winding(mixed)
    assert is_closed(restored)
    label = face_components(restored, len(points))
    wrong = turned ^ flipped  # all of a piece, or none of it
    assert all(len(set(wrong[label == k].tolist())) == 1 for k in range(label.max() + 1))
    first = np.unique(label, return_index=True)[1]
    assert not turned[first].any()
    assert abs(signed_volume(points, restored[label == 0])) > 0


@pytest.mark.parametrize(
    ("shape", "exact"),
    [
        (Box(size=(1.0, 0.7, 0.4)), 0.28),
        (Sphere(radius=0.5), np.pi / 6),
        (Cylinder(radius=0.3, height=1.0), np.pi * 0.09),
    ],
    ids=["box", "sphere", "cylinder"],
)
@pytest.mark.parametrize("tilt", [(1, 0, 0, 0), (0.9, 0.3, 0.2, 0.1)], ids=["straight", "tilted"])
def test_voxels_find_the_volume(shape: Shape, exact: float, tilt: tuple[float, float, float, float]) -> None:
    points, faces = tessellate(shape, Pose(position=(3.0, -2.0, 1.0), quaternion=tilt), steps=64)
    for bridge in (False, True):
        grid = voxelise(points, faces, 64, bridge=bridge)
        assert grid.volume == pytest.approx(exact, rel=0.05)
        centers = grid.origin + np.argwhere(grid.solid) * grid.cell
        assert (centers > points.min(axis=0) - grid.cell).all()
        assert (centers < points.max(axis=0) + grid.cell).all()


def test_what_bounds_no_volume_is_no_solid() -> None:
    points, faces = tessellate(Box(size=(1, 1, 1)), Pose())
    assert closed_solid(points, faces[1:]) is None
    assert closed_solid(points, faces[:, ::-1]) is None
    assert closed_solid(points, np.concatenate([faces, faces[:, ::-1]])) is None
    assert union([]) is None
