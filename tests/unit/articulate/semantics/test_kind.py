"""What kind a thing is, by name, proportions and parts; and the things that stand out from its sides."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets import registry
from casa_assets.articulate.category import (
    KIND_NAMES,
    KIND_TRAITS,
    ControlPlacement,
    kind_by_parts,
    kind_named,
    shape_likelihood,
)
from casa_assets.articulate.plan import Articulation
from tests.unit.articulate.blocks import drawers, microwave
from tests.unit.articulate.fragmented import found_on


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


def test_usual_proportions_are_likelier_upright() -> None:
    upright, sideways = (1.0, 0.76, 0.57), (0.57, 0.76, 1.0)
    assert shape_likelihood(upright, ControlPlacement.ASIDE) > shape_likelihood(sideways, ControlPlacement.ABOVE) + 1.0
    assert shape_likelihood((0.42, 0.4, 1.0), ControlPlacement.NONE) > shape_likelihood(
        (1.0, 0.4, 0.42), ControlPlacement.NONE
    )
    assert shape_likelihood((2.0, 1.5, 1.16), ControlPlacement.NONE) == pytest.approx(
        shape_likelihood((1.0, 0.75, 0.58), ControlPlacement.NONE)
    )


@pytest.mark.parametrize(("make", "kind"), [(drawers, "drawer_stack"), (microwave, "microwave")])
def test_parts_and_proportions_tell_the_kind(make: object, kind: str) -> None:
    assert callable(make)
    vertices, faces, _ = make()
    found = found_on(vertices, faces)
    x, y, z = (float(v) for v in np.ptp(vertices, axis=0))
    guessed, confidence = kind_by_parts((x, y, z), found)
    assert guessed == kind
    assert 0.2 < confidence <= 0.6
    assert kind_by_parts((x, y, z), Articulation(frame=found.frame)) == ("", 0.0)
