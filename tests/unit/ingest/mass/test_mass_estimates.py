"""Estimates of a mass: each way by itself, and what is made of them together."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets import registry
from casa_assets.geometry.mesh.topology import weld
from casa_assets.geometry.solid.solids import closed_solid
from casa_assets.ingest.mass.estimates import (
    WALL_THICKNESS_M,
    CombinedMass,
    Estimate,
    EstimateMethod,
    combine_estimates,
    estimate_masses,
)
from casa_assets.model.asset.parts import Mesh
from tests.meshes import box_mesh
from tests.raw_models import MUG, category, flipped, joined, turned, volume

CUP = turned(MUG, 64)


def estimated(mesh: Mesh, name: str) -> list[Estimate]:
    kind = category(name)
    points, place = weld(mesh.vertices)
    faces = place[mesh.faces]
    return estimate_masses(points, faces, closed_solid(points, faces), kind, registry.load().substances[kind.substance])


def of(mesh: Mesh, name: str) -> dict[EstimateMethod, float]:
    return {e.method: e.kg for e in estimated(mesh, name)}


def verdict(mesh: Mesh, name: str) -> CombinedMass:
    return combine_estimates(estimated(mesh, name), category(name), 2.0)


def guess(name: str, **kilograms: float) -> CombinedMass:
    found = [Estimate(EstimateMethod(way), kg, 0.3, "") for way, kg in kilograms.items()]
    return combine_estimates(found, category(name), 2.0)


def test_a_vessel_is_weighed_by_its_walls() -> None:
    found = of(CUP, "mug")
    assert found[EstimateMethod.MATTER] == pytest.approx(volume(CUP) * 2300, rel=1e-6)
    inner, outer = 2 * np.pi * 0.036 * 0.089 + np.pi * 0.036**2, 2 * np.pi * 0.04 * 0.095 + np.pi * 0.04**2
    assert found[EstimateMethod.SHELL] == pytest.approx(
        (inner + outer) / 2 * WALL_THICKNESS_M["ceramic"] * 2300, rel=0.05
    )
    assert set(found) == set(EstimateMethod)


def test_a_lone_sheet_is_one_wall_and_no_matter() -> None:
    sheet = Mesh(
        vertices=CUP.vertices,
        faces=CUP.faces[np.linalg.norm(CUP.vertices[CUP.faces][..., :2], axis=2).max(axis=1) > 0.0399],
    )
    found = of(sheet, "mug")
    assert EstimateMethod.MATTER not in found
    skin = 2 * np.pi * 0.04 * 0.095 + np.pi * 0.04**2
    assert found[EstimateMethod.SHELL] == pytest.approx(skin * WALL_THICKNESS_M["ceramic"] * 2300, rel=0.15)


def test_a_full_thing_has_matter_and_a_hull_but_no_wall() -> None:
    block = box_mesh((0.07, 0.07, 0.07), (0, 0, 0), shared=True)
    found = of(block, "apple")
    assert found[EstimateMethod.MATTER] == pytest.approx(0.07**3 * 950, rel=1e-6)
    assert found[EstimateMethod.HULL] == pytest.approx(0.9 * 0.07**3 * 950, rel=1e-6)
    assert EstimateMethod.SHELL not in found


def test_a_double_wall_that_stands_for_a_full_thing_is_filled() -> None:
    outer = box_mesh((0.07, 0.07, 0.07), (0, 0, 0), shared=True)
    hollow = joined(outer, flipped(box_mesh((0.066, 0.066, 0.066), (0, 0, 0), shared=True)))
    assert of(hollow, "apple")[EstimateMethod.MATTER] == pytest.approx(0.07**3 * 950, rel=0.1)


def test_the_range_of_the_category_is_never_left(subtests: pytest.Subtests) -> None:
    for size in [0.2, 1.0, 5.0]:
        for name in ["apple", "mug", "bottle", "microwave", "fork", "cheese"]:
            with subtests.test(name=name, size=size):
                kind = category(name)
                a, b, c = (side.typical * size for side in kind.extents)
                span = kind.mass_kg
                assert span.low <= verdict(box_mesh((a, b, c), (0, 0, 0), shared=True), name).kg <= span.high


def test_a_measured_mass_is_kept_where_others_bear_it_out() -> None:
    assert guess("mug", matter=0.4, shell=0.3, usual=0.33).kg == 0.4
    assert guess("mug", matter=0.4, shell=0.3, usual=0.33).confidence > 0.7


def test_where_they_disagree_it_is_between_them_and_nobody_is_sure() -> None:
    found = guess("mug", matter=0.48, shell=0.1, usual=0.34)
    assert 0.25 < found.kg < 0.48
    assert found.ratio > 3
    assert found.confidence <= 0.6


def test_a_little_out_of_range_the_usual_mass_draws_it_back() -> None:
    found = guess("mug", matter=0.9, shell=0.8, usual=0.33)
    assert 0.33 < found.kg < 0.5
    assert found.confidence < 0.8


def test_the_air_in_what_is_sold_by_the_box_is_that_of_the_category() -> None:
    kind = category("boxed_food")
    a, b, c = (side.typical for side in kind.extents)
    assert of(box_mesh((a, b, c), (0, 0, 0), shared=True), "boxed_food")[EstimateMethod.MATTER] == pytest.approx(
        kind.mass_kg.typical / 0.85, rel=0.05
    )


def test_far_out_of_range_the_usual_mass_is_taken_and_not_sure() -> None:
    found = guess("mug", matter=50.0, shell=40.0, usual=0.5)
    assert found.kg == 0.5
    assert found.confidence < 0.5
    assert "a mug weighs 0.25 to 0.5 kg" in found.message
