"""Estimates of a mass: each way by itself, and what is made of them together."""

from __future__ import annotations

import pytest

from casa_assets import registry
from casa_assets.ingest.mass import (
    Estimate,
    EstimateMethod,
    combine_estimates,
    estimate_masses,
)
from casa_assets.mesh.solid.solids import closed_solid
from casa_assets.model.asset.parts import Mesh
from tests.support.mesh.raw_models import category
from tests.support.mesh.solids import box, welded


def estimated(mesh: Mesh, name: str) -> list[Estimate]:
    kind = category(name)
    points, faces = welded(mesh)
    return estimate_masses(points, faces, closed_solid(points, faces), kind, registry.load().substances[kind.substance])


def of(mesh: Mesh, name: str) -> dict[EstimateMethod, float]:
    return {e.method: e.kg for e in estimated(mesh, name)}


def test_the_range_of_the_category_is_never_left(subtests: pytest.Subtests) -> None:
    for size in [0.2, 1.0, 5.0]:
        for name in ["apple", "mug", "bottle", "microwave", "fork", "cheese"]:
            with subtests.test(name=name, size=size):
                kind = category(name)
                a, b, c = (side.typical * size for side in kind.extents)
                span = kind.mass_kg
                assert span.low <= combine_estimates(estimated(box((a, b, c)), name), kind, 2.0).kg <= span.high


@pytest.mark.parametrize(
    ("kilograms", "kg", "confidence"),
    [
        pytest.param((0.4, 0.3, 0.33), (0.4, 0.4), (0.7, 1.0), id="measured, and others bear it out"),
        pytest.param((0.48, 0.1, 0.34), (0.25, 0.48), (0.0, 0.6), id="they disagree: between them"),
        pytest.param((0.9, 0.8, 0.33), (0.33, 0.5), (0.0, 0.8), id="a little out of range: drawn back"),
        pytest.param((50.0, 40.0, 0.5), (0.5, 0.5), (0.0, 0.5), id="far out of range: the usual mass"),
    ],
)
def test_together(kilograms: tuple[float, ...], kg: tuple[float, float], confidence: tuple[float, float]) -> None:
    ways = (EstimateMethod.MATTER, EstimateMethod.SHELL, EstimateMethod.USUAL)
    found = combine_estimates(
        [Estimate(way, value, 0.3, "") for way, value in zip(ways, kilograms, strict=True)], category("mug"), 2.0
    )
    assert kg[0] <= found.kg <= kg[1]
    assert confidence[0] <= found.confidence <= confidence[1]
    assert found.kg not in kg or kg[0] == kg[1]
    if kilograms[0] == 0.48:
        assert found.ratio > 3
    if kilograms[0] == 50.0:
        assert "a mug weighs 0.25 to 0.5 kg" in found.message


def test_the_air_in_what_is_sold_by_the_box_is_that_of_the_category() -> None:
    kind = category("boxed_food")
    a, b, c = (side.typical for side in kind.extents)
    assert of(box((a, b, c)), "boxed_food")[EstimateMethod.MATTER] == pytest.approx(
        kind.mass_kg.typical / 0.85, rel=0.05
    )
