"""Volumes of hulls: parts are split until hulls hold little beyond them, and hulls of few vertices grow to theirs."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.core.numeric import Floats
from casa_assets.geometry.solid.solids import MAX_GROWTH, Solid, hull_volume, hull_with_volume, solid_of, volume_of_hull
from casa_assets.ingest.collision.plane_splits import split_to_volume
from tests.meshes import box_mesh

FREE = np.array([[-9.0, -9.0, -9.0], [9.0, 9.0, 9.0]])


def block(size: tuple[float, float, float], center: tuple[float, float, float]) -> Solid:
    mesh = box_mesh(size, center, shared=True)
    found = solid_of(mesh.vertices, mesh.faces)
    assert found is not None
    return found


def angle_iron() -> Solid:
    """Two plates of 0.2 x 0.1 x 0.02 m that share an edge; the hull around them is more than twice as large."""
    return block((0.2, 0.1, 0.02), (0.1, 0.0, 0.01)) + block((0.02, 0.1, 0.2), (0.01, 0.0, 0.1))


def excess(parts: list[Solid]) -> float:
    return sum(volume_of_hull([p]) - float(p.volume()) for p in parts)


def ring(sides: int, radius: float) -> Floats:
    angles = np.arange(sides) * 2 * np.pi / sides
    return np.concatenate(
        [np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.full(sides, z)]) for z in (0.0, 0.1)]
    )


class TestSplitToVolume:
    def test_two_plates_become_two_parts(self) -> None:
        parts = split_to_volume([angle_iron()], 1e-6, 8, 0.001)
        assert len(parts) == 2
        assert excess(parts) == pytest.approx(0.0, abs=1e-7)

    def test_nothing_is_lost(self) -> None:
        parts = split_to_volume([angle_iron()], 1e-6, 8, 0.001)
        assert sum(float(p.volume()) for p in parts) == pytest.approx(float(angle_iron().volume()))

    def test_what_may_be_left_is_left_where_cutting_gains_little(self) -> None:
        dented = block((0.1, 0.1, 0.1), (0.0, 0.0, 0.0)) - block((0.1, 0.02, 0.002), (0.0, 0.0, 0.05))
        assert len(split_to_volume([dented], 1.1 * excess([dented]), 8, 0.001)) == 1
        assert len(split_to_volume([dented], 0.5 * excess([dented]), 8, 0.001)) > 1

    def test_what_is_near_enough_is_cut_on_where_that_gains_much(self) -> None:
        assert len(split_to_volume([angle_iron()], 2 * excess([angle_iron()]), 8, 0.001)) == 2

    def test_the_number_of_parts_is_kept(self) -> None:
        ring = Solid.cylinder(0.05, 0.1, circular_segments=48) - Solid.cylinder(0.05, 0.06, circular_segments=48)
        parts = split_to_volume([ring], 0.0, 5, 0.001)
        assert 2 <= len(parts) <= 5
        assert excess(parts) < 0.5 * excess([ring])

    def test_no_slice_is_thinner_than_is_asked(self) -> None:
        assert len(split_to_volume([angle_iron()], 1e-6, 8, 0.19)) == 1

    def test_what_is_convex_is_not_cut(self) -> None:
        assert len(split_to_volume([block((0.1, 0.1, 0.1), (0.0, 0.0, 0.0))], 0.0, 8, 0.001)) == 1


class TestHullWithVolume:
    def test_a_round_thing_of_few_vertices_grows_to_its_volume(self) -> None:
        wanted = np.pi * 0.05**2 * 0.1
        few = ring(12, 0.05)
        assert hull_volume(few) < 0.96 * wanted
        assert hull_volume(hull_with_volume(few, wanted, FREE)) == pytest.approx(wanted, rel=1e-6)

    def test_it_grows_about_its_middle(self) -> None:
        few = ring(12, 0.05) + np.array([1.0, 2.0, 3.0])
        grown = hull_with_volume(few, 1.05 * hull_volume(few), FREE)
        assert (grown.min(axis=0) + grown.max(axis=0)) / 2 == pytest.approx([1.0, 2.0, 3.05])

    def test_it_does_not_grow_out_of_the_box(self) -> None:
        few = ring(12, 0.05)
        box = np.array([few.min(axis=0), few.max(axis=0)])
        grown = hull_with_volume(few, 1.1 * hull_volume(few), box)
        assert grown.min(axis=0) == pytest.approx(box[0])
        assert grown.max(axis=0) == pytest.approx(box[1])

    def test_what_is_large_enough_stays(self) -> None:
        few = ring(12, 0.05)
        assert hull_with_volume(few, 0.9 * hull_volume(few), FREE) is few

    def test_growth_has_an_end(self) -> None:
        few = ring(12, 0.05)
        assert hull_volume(hull_with_volume(few, 9.0, FREE)) == pytest.approx(MAX_GROWTH**3 * hull_volume(few))
