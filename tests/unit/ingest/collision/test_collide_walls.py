"""Walls of vessels: hulls of flared and filleted ones, and of thin ones, stay as near as they were planned to be."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.core.numeric import Floats
from casa_assets.ingest.collision.collide import collide
from casa_assets.ingest.collision.fit import CollideParams
from casa_assets.ingest.collision.rings import RAYS, WallProfile
from casa_assets.ingest.draft import Draft
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.model.asset.parts import Box, Mesh
from tests.support.mesh.raw_models import category, draft, turned
from tests.support.mesh.solids import never

pytestmark = pytest.mark.content("code", "ingest.collision", keep=0)

PARAMS = CollideParams()


def confidence(state: Draft) -> float:
    [guess] = [g for g in state.guesses if g.subject == "collision"]
    return guess.confidence


def seen(inner: list[float]) -> WallProfile:
    radii: Floats = np.repeat(np.array(inner, dtype=np.float64)[:, None], RAYS, axis=1)
    heights: Floats = 0.01 * np.arange(len(inner), dtype=np.float64)
    return WallProfile(np.zeros(2), heights, 0.01, radii, radii + 0.005)


def test_a_thin_bowl_stays_within_the_bound_and_on_its_ground() -> None:
    angles = np.linspace(0.0, np.pi / 2.4, 12)
    outer = [(0.08 * float(np.sin(a)), 0.08 - 0.08 * float(np.cos(a))) for a in angles]
    inner = [(r * 0.985, z * 0.985 + 0.0012) for r, z in outer]
    out = collide(draft(turned([*inner, *outer[::-1]], 64)), category("bowl"), PARAMS, never)
    assert confidence(out) == 1.0
    assert len(out.colliders) <= 32
    low = min(float(tessellate(p.shape, p.pose)[0][:, 2].min()) for p in out.colliders)
    assert low > -1e-6


def test_a_carton_that_bulges_is_one_box_between_its_bulges_and_its_edges() -> None:
    flat = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
    around = [(x, -1.0) for x in flat[:-1]] + [(1.0, y) for y in flat[:-1]]
    around += [(x, 1.0) for x in flat[:0:-1]] + [(-1.0, y) for y in flat[:0:-1]]
    rings = []
    for z in flat:
        bulge = 0.004 * (1 - z * z)
        rings += [
            (0.05 * x + bulge * (abs(x) == 1) * x, 0.03 * y + bulge * (abs(y) == 1) * y, 0.08 * z) for x, y in around
        ]
    count = len(around)
    sides = [
        face
        for k in range(4)
        for i in range(count)
        for a, b in [(k * count + i, k * count + (i + 1) % count)]
        for face in ((a, b, b + count), (a, b + count, a + count))
    ]
    ends = [(5 * count, (i + 1) % count, i) for i in range(count)]
    ends += [(5 * count + 1, 4 * count + i, 4 * count + (i + 1) % count) for i in range(count)]
    mesh = Mesh(vertices=[*rings, (0.0, 0.0, -0.08), (0.0, 0.0, 0.08)], faces=[*sides, *ends])
    [placed] = collide(draft(mesh), category("boxed_food"), PARAMS, never).colliders
    assert isinstance(placed.shape, Box)
    x, y, z = sorted(placed.shape.size)
    assert 0.06 < x < 0.0675
    assert 0.1 < y < 0.1075
    assert z == pytest.approx(0.16, abs=1e-3)
    assert float(tessellate(placed.shape, placed.pose)[0][:, 2].min()) == pytest.approx(-0.08, abs=1e-6)
