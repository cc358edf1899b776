"""Walls of vessels: hulls of flared and filleted ones, and of thin ones, stay as near as they were planned to be."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.geometry.revolution import RAYS, Walls
from casa_assets.geometry.tessellate import surface
from casa_assets.ingest.collide import CollideParams, collide
from casa_assets.ingest.collide_slabs import table
from casa_assets.ingest.decompose import Budget, Floats, Ints
from casa_assets.ingest.draft import Draft
from tests.raw_models import category, draft, turned

PARAMS = CollideParams()
FLARED = [
    (0.0, 0.0),
    (0.034, 0.0),
    (0.038, 0.01),
    (0.038, 0.07),
    (0.044, 0.085),
    (0.041, 0.085),
    (0.033, 0.07),
    (0.033, 0.016),
    (0.026, 0.008),
    (0.0, 0.008),
][::-1]


def never(method: str, points: Floats, faces: Ints, budget: Budget) -> list[Floats]:
    raise AssertionError(f"{method} was not needed")


def sure(state: Draft) -> float:
    [guess] = [g for g in state.guesses if g.subject == "collision"]
    return guess.confidence


def seen(inner: list[float]) -> Walls:
    radii = np.repeat(np.array(inner)[:, None], RAYS, axis=1)
    heights = 0.01 * np.arange(len(inner))
    return Walls(np.zeros(2), heights, 0.01, radii, radii + 0.005)


class TestTable:
    def test_a_hull_has_chords_from_every_height_to_every_other(self) -> None:
        inner = [0.026, 0.033, 0.033, 0.033, 0.033, 0.033, 0.033, 0.045]
        found = table(seen(inner), is_round=True).bend
        part = found[0, 7]  # from the fillet to the end of the straight wall
        assert part > 0.004
        assert found[0, 8] >= part
        assert found[1, 7] == pytest.approx(0.0, abs=1e-9)

    def test_a_wall_that_bulges_inwards_recedes_nowhere_but_outside(self) -> None:
        inner = [0.03, 0.034, 0.036, 0.034, 0.03]
        found = table(seen(inner), is_round=True).bend
        assert found[0, 5] > 0.003


def test_a_flared_cup_stays_within_the_bound() -> None:
    out = collide(draft(turned(FLARED, 48)), category("cup"), PARAMS, never)
    assert sure(out) == 1.0
    assert len(out.colliders) <= 32


def test_a_thin_bowl_stays_within_the_bound_and_on_its_ground() -> None:
    angles = np.linspace(0.0, np.pi / 2.4, 12)
    outer = [(0.08 * float(np.sin(a)), 0.08 - 0.08 * float(np.cos(a))) for a in angles]
    inner = [(r * 0.985, z * 0.985 + 0.0012) for r, z in outer]
    out = collide(draft(turned([*inner, *outer[::-1]], 64)), category("bowl"), PARAMS, never)
    assert sure(out) == 1.0
    assert len(out.colliders) <= 32
    low = min(float(surface(p.shape, p.pose)[0][:, 2].min()) for p in out.colliders)
    assert low > -1e-6
