"""Volumes of hulls: parts are split until hulls hold little beyond them, and hulls of few vertices grow to theirs."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.core.numeric import Floats
from casa_assets.ingest.collision.plane_splits import split_to_volume
from casa_assets.mesh.solid.solids import MAX_GROWTH, Solid, hull_volume, hull_with_volume, volume_of_hull
from tests.support.mesh.solids import block

FREE = np.array([[-9.0, -9.0, -9.0], [9.0, 9.0, 9.0]])


# Two plates of 0.2 x 0.1 x 0.02 m that share an edge; the hull around them is more than twice as large.
ANGLE = block((0.2, 0.1, 0.02), (0.1, 0.0, 0.01)) + block((0.02, 0.1, 0.2), (0.01, 0.0, 0.1))


def excess(parts: list[Solid]) -> float:
    return sum(volume_of_hull([p]) - float(p.volume()) for p in parts)


def ring(sides: int, radius: float) -> Floats:
    angles = np.arange(sides) * 2 * np.pi / sides
    return np.concatenate(
        [np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.full(sides, z)]) for z in (0.0, 0.1)]
    )


class TestSplitToVolume:
    def test_two_plates_become_two_parts_and_nothing_is_lost(self) -> None:
        parts = split_to_volume([ANGLE], 1e-6, 8, 0.001)
        assert len(parts) == 2
        assert excess(parts) == pytest.approx(0.0, abs=1e-7)
        assert sum(float(p.volume()) for p in parts) == pytest.approx(float(ANGLE.volume()))

    def test_what_may_be_left_is_left_where_cutting_gains_little(self) -> None:
        dented = block((0.1, 0.1, 0.1)) - block((0.1, 0.02, 0.002), (0.0, 0.0, 0.05))
        assert len(split_to_volume([dented], 1.1 * excess([dented]), 8, 0.001)) == 1
        assert len(split_to_volume([dented], 0.5 * excess([dented]), 8, 0.001)) > 1

    @pytest.mark.parametrize(
        ("solid", "allowed", "thinnest", "count"),
        [
            pytest.param(ANGLE, 2 * excess([ANGLE]), 0.001, 2, id="near enough, but cutting gains much"),
            pytest.param(ANGLE, 1e-6, 0.19, 1, id="slices would be too thin"),
            pytest.param(block((0.1, 0.1, 0.1)), 0.0, 0.001, 1, id="convex"),
        ],
    )
    def test_into_how_many(self, solid: Solid, allowed: float, thinnest: float, count: int) -> None:
        assert len(split_to_volume([solid], allowed, 8, thinnest)) == count

    def test_the_number_of_parts_is_kept(self) -> None:
        ring = Solid.cylinder(0.05, 0.1, circular_segments=48) - Solid.cylinder(0.05, 0.06, circular_segments=48)
        parts = split_to_volume([ring], 0.0, 5, 0.001)
        assert 2 <= len(parts) <= 5
        assert excess(parts) < 0.5 * excess([ring])


class TestHullWithVolume:
    FEW = ring(12, 0.05)

    def test_a_round_thing_of_few_vertices_grows_to_its_volume_about_its_middle(self) -> None:
        wanted = np.pi * 0.05**2 * 0.1
        few = self.FEW + np.array([1.0, 2.0, 3.0])
        assert hull_volume(few) < 0.96 * wanted
        grown = hull_with_volume(few, wanted, FREE)
        assert hull_volume(grown) == pytest.approx(wanted, rel=1e-6)
        assert (grown.min(axis=0) + grown.max(axis=0)) / 2 == pytest.approx([1.0, 2.0, 3.05])

    def test_growth_ends_at_the_box_and_at_a_bound(self) -> None:
        box = np.array([self.FEW.min(axis=0), self.FEW.max(axis=0)])
        grown = hull_with_volume(self.FEW, 1.1 * hull_volume(self.FEW), box)
        assert np.array([grown.min(axis=0), grown.max(axis=0)]) == pytest.approx(box)
        free = hull_volume(hull_with_volume(self.FEW, 9.0, FREE))
        assert free == pytest.approx(MAX_GROWTH**3 * hull_volume(self.FEW))

    def test_what_is_large_enough_stays(self) -> None:
        assert hull_with_volume(self.FEW, 0.9 * hull_volume(self.FEW), FREE) is self.FEW
