"""The child that decomposes: same hulls twice, and whatever goes wrong in it is one kind of error."""

from __future__ import annotations

from functools import cache, partial

import numpy as np
import pytest

from casa_assets.core.numeric import Floats, Ints
from casa_assets.ingest.collision.components import Budget, DecompositionFailed, decompose
from tests.support.mesh.raw_models import MUG, joined, turned
from tests.support.mesh.solids import box, welded

pytestmark = pytest.mark.content("code", "ingest.collision", keep=0)

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


BOXES = [box((0.05, 0.4, 0.6), (x, y, z)) for x, y, z in np.random.default_rng(0).random((300, 3)).tolist()]
NOT_FINITE = [np.concatenate([CUP[0][:3], [[0.0, bad, 0.0]], CUP[0][4:]]) for bad in (np.nan, np.inf, -np.inf)]


@pytest.mark.parametrize(
    ("method", "mesh", "budget", "said"),
    [
        pytest.param("vhacd", welded(joined(*BOXES)), Budget(hulls=64, cpu_s=1), "vhacd ended with -", id="time"),
        pytest.param("coacd", CUP, Budget(hulls=8, memory_bytes=1_000_000), "coacd ended with", id="memory"),
        pytest.param("magic", CUP, BUDGET, "KeyError", id="no such method"),
        *(pytest.param("coacd", (p, CUP[1]), BUDGET, "not tried", id="no number") for p in NOT_FINITE),
        pytest.param("vhacd", (np.zeros((4, 3)), np.array([[0, 1, 2]])), BUDGET, "not tried", id="no extent"),
        pytest.param("vhacd", (CUP[0], np.empty((0, 3), dtype=np.int64)), BUDGET, "not tried", id="no faces"),
    ],
)
def test_what_goes_wrong(method: str, mesh: tuple[Floats, Ints], budget: Budget, said: str) -> None:
    with pytest.raises(DecompositionFailed, match=said):
        decompose(method, *mesh, budget)
