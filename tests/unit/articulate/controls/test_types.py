"""Controls are typed by the group that they stand in: keys in a grid, knobs in a row, pulls of drawers neither."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from casa_assets.articulate.controls.classify import check_forest, classify_with_dials, decided
from casa_assets.articulate.controls.controls import Control, group_controls
from casa_assets.articulate.infer import choose_plan
from casa_assets.articulate.plan import PartKind
from casa_assets.articulate.run.build import load_models
from casa_assets.core.forest import forest_from_dict
from tests.unit.articulate.blocks import Part, box, carcass, disc, together
from tests.unit.articulate.fragmented import in_its_frame


def control(x: float, z: float, width: float, height: float, stands: float = 0.01) -> Control:
    half = np.array([width, height]) / 2
    low, high = np.append(np.array([x, z]) - half, 0.0), np.append(np.array([x, z]) + half, stands)
    return Control([0], low, high, stands, width == height)


def kinds_of(*parts: Part) -> list[PartKind]:
    """The kinds of the knobs and keys that are found on a mesh, as the whole command would type them."""
    mesh, frame = in_its_frame(*together(*parts)[:2])
    found = choose_plan(mesh, frame, models=load_models()).articulation.parts
    return [p.kind for p in found if p.kind in (PartKind.KNOB, PartKind.BUTTON)]


def test_a_grid_is_one_group_and_a_wide_key_below_it_another() -> None:
    grid = [control(0.05 * a, 0.05 * b, 0.03, 0.03) for a in range(3) for b in range(4)]
    groups = group_controls([*grid, control(0.05, -0.06, 0.13, 0.03)])
    assert sorted((len(g.members), g.rows, g.columns) for g in groups) == [(1, 1, 1), (12, 4, 3)]
    assert groups[0].pitch == pytest.approx(0.05 / 0.03)


def test_round_keys_in_a_grid_beside_a_door_are_keys() -> None:
    door, panel = box((0.0, -0.02, 0.0), (0.37, -0.0005, 0.3)), box((0.375, -0.02, 0.0), (0.5, -0.0005, 0.3))
    keys = [disc((0.4 + 0.037 * a, -0.025, 0.08 + 0.032 * b), 0.011, 0.0049, 16) for a in range(3) for b in range(5)]
    bar = box((0.335, -0.05, 0.05), (0.35, -0.0205, 0.25))
    assert kinds_of(*carcass(0.5, 0.38, 0.3), door, panel, bar, *keys) == [PartKind.BUTTON] * 15


def test_octagonal_bosses_in_a_row_over_an_oven_door_are_knobs() -> None:
    door, bar = box((0.0, -0.03, 0.0), (0.6, -0.0005, 0.58)), box((0.06, -0.07, 0.52), (0.54, -0.0305, 0.54))
    panel = box((0.0, -0.03, 0.59), (0.6, -0.0005, 0.7))
    knobs = [disc((0.08 + 0.11 * k, -0.055, 0.645), 0.022, 0.0249, 8) for k in range(5)]
    assert kinds_of(*carcass(0.6, 0.55, 0.7), door, bar, panel, *knobs) == [PartKind.KNOB] * 5


def test_pulls_of_drawers_are_neither() -> None:
    fronts = [box((0.005, -0.02, 0.01 + 0.2 * k), (0.495, -0.0005, 0.195 + 0.2 * k)) for k in range(3)]
    pulls = [disc((0.25, -0.045, 0.1 + 0.2 * k), 0.015, 0.0249, 16) for k in range(3)]
    assert kinds_of(*carcass(0.5, 0.45, 0.61), *fronts, *pulls) == []


def test_what_is_surely_a_control_is_the_likelier_of_the_two() -> None:
    chances = np.array([[0.5, 0.4, 0.1], [0.2, 0.38, 0.42], [0.52, 0.02, 0.46], [0.45, 0.3, 0.25]])
    assert decided(chances, np.zeros(4, dtype=bool)).tolist() == [0, 2, 2, 0]


def test_a_forest_gives_the_mean_of_its_trees() -> None:
    leaf = [[[0, 100]]]
    trees = [[[0, 0.5, 1, 2], [[100, 0]], [[50, 50]]], leaf]
    forest = forest_from_dict({"features": ["a"], "classes": ["x", "y"], "trees": trees})
    assert forest.probabilities(np.array([[0.5], [0.6]])).tolist() == [[0.5, 0.5], [0.25, 0.75]]
    with pytest.raises(ValueError, match="points nowhere"):
        forest_from_dict({"features": ["a"], "classes": ["x", "y"], "trees": [[[0, 0.5, 1, 3], *leaf, *leaf]]})
    with pytest.raises(ValueError, match="other features"):
        check_forest(forest)


def test_round_things_that_are_smaller_than_the_dial_of_a_toaster_are_its_keys() -> None:
    def classify(_control: Control, _others: Sequence[Control]) -> tuple[PartKind | None, float, str]:
        return PartKind.KNOB, 0.6, "round"

    dial, key, lever = control(0.0, 0.0, 0.06, 0.06), control(0.08, 0.0, 0.04, 0.04), control(0.0, 0.1, 0.058, 0.058)
    told = classify_with_dials(classify)
    assert [told(c, [dial, key, lever])[0] for c in (dial, key, lever)] == [
        PartKind.KNOB,
        PartKind.BUTTON,
        PartKind.KNOB,
    ]
