"""The child that decomposes: same hulls twice, and whatever goes wrong in it is one kind of error."""

from __future__ import annotations

from functools import cache, partial

import numpy as np
import pytest

from casa_assets.core.numeric import Floats, Ints
from casa_assets.geometry.mesh.topology import weld
from casa_assets.geometry.solid.solids import hull_volume
from casa_assets.ingest.collision.convex_decomposition import Budget, DecompositionFailed, decompose
from casa_assets.model.asset.parts import Mesh
from tests.meshes import box_mesh
from tests.raw_models import MUG, joined, moved, turned

pytestmark = pytest.mark.content("code", "ingest.collision", keep=0)


def welded(mesh: Mesh) -> tuple[Floats, Ints]:
    points, place = weld(mesh.vertices)
    return points, place[mesh.faces]


CUP = welded(turned(MUG, 8))
BUDGET = Budget(hulls=8, hull_vertices=32, threshold=0.2)
hulls_of = cache(partial(decompose, vertices=CUP[0], faces=CUP[1], budget=BUDGET))


@pytest.mark.parametrize("method", ["coacd", "vhacd"])
def test_two_runs_give_the_same_hulls_within_the_budget(method: str) -> None:
    first, second = hulls_of(method), decompose(method, *CUP, BUDGET)
    assert 1 < len(first) <= BUDGET.hulls
    assert all(4 <= len(cloud) <= BUDGET.hull_vertices for cloud in first)
    assert [c.tobytes() for c in first] == [c.tobytes() for c in second]
    cloud = np.concatenate(first)
    size = np.ptp(CUP[0], axis=0).max()
    assert cloud.min(axis=0) == pytest.approx(CUP[0].min(axis=0), abs=0.02 * size)
    assert cloud.max(axis=0) == pytest.approx(CUP[0].max(axis=0), abs=0.02 * size)


def test_hulls_move_and_grow_with_the_mesh() -> None:
    far = [1000.0, -500.0, 20.0]
    here, there = hulls_of("vhacd"), decompose("vhacd", CUP[0] * 100 + far, CUP[1], BUDGET)
    volumes = [sum(map(hull_volume, hulls)) for hulls in (here, there)]
    assert volumes[1] == pytest.approx(volumes[0] * 1e6, rel=0.02)


def test_a_child_out_of_time_says_so() -> None:
    draw = np.random.default_rng(0)
    boxes = [box_mesh((0.05, 0.4, 0.6), tuple(o), shared=True) for o in draw.random((300, 3)).tolist()]
    hard = welded(joined(*(moved(b) for b in boxes)))
    with pytest.raises(DecompositionFailed, match="vhacd ended with -"):
        decompose("vhacd", *hard, Budget(hulls=64, cpu_s=1))


def test_a_child_out_of_memory_says_so() -> None:
    with pytest.raises(DecompositionFailed, match="coacd ended with"):
        decompose("coacd", *CUP, Budget(hulls=8, memory_bytes=1_000_000))


def test_a_method_that_does_not_exist() -> None:
    with pytest.raises(DecompositionFailed, match="KeyError"):
        decompose("magic", *CUP, BUDGET)


def test_numbers_that_are_none_are_not_tried(subtests: pytest.Subtests) -> None:
    for bad in [np.nan, np.inf, -np.inf]:
        with subtests.test(bad=bad):
            points = CUP[0].copy()
            points[3, 1] = bad
            with pytest.raises(DecompositionFailed, match="not tried"):
                decompose("coacd", points, CUP[1], BUDGET)


def test_no_extent_and_no_faces_are_not_tried() -> None:
    for points, faces in ((np.zeros((4, 3)), np.array([[0, 1, 2]])), (CUP[0], np.empty((0, 3), dtype=np.int64))):
        with pytest.raises(DecompositionFailed, match="not tried"):
            decompose("vhacd", points, faces, BUDGET)
