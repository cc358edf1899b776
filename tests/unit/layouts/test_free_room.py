"""What is free in a space."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from casa_assets.layouts.spaces import Space, count_of_things, free_cells, largest_box, world_bounds
from casa_assets.model.pose import Pose

SHELF = Space("unit", "object", "level0", ("shelf",), Pose(position=(1.0, 2.0, 3.0)), (0.8, 0.3, 0.25))


def test_empty_space_is_free() -> None:
    size, middle = largest_box(SHELF)
    assert size == pytest.approx((0.8, 0.3, 0.25))
    assert middle == pytest.approx((0.0, 0.0))
    assert count_of_things(SHELF) == 6 * 2
    assert largest_box(replace(SHELF, taken=((-1.0, -1.0, 1.0, 1.0),)))[0] == (0.0, 0.0, 0.0)


def test_largest_box_is_beside_what_stands_there() -> None:
    space = replace(SHELF, taken=((-0.2, -0.15, 0.05, 0.15), (0.3, 0.1, 0.4, 0.15)))
    size, (x, y) = largest_box(space)
    assert size == pytest.approx((0.35, 0.25, 0.25))
    assert (x, y) == pytest.approx((0.225, -0.025))
    assert count_of_things(space) == 1 * 2 + 3 * 2


@pytest.mark.parametrize("seed", range(6))
def test_largest_box_is_the_best_of_all_rectangles(seed: int) -> None:
    rng = np.random.default_rng(seed)
    small = replace(SHELF, size=(0.14, 0.11, 0.2))
    rects = [(float(x), float(y), float(x + 0.02), float(y + 0.01)) for x, y in rng.uniform(-0.07, 0.06, (4, 2))]
    space = replace(small, taken=tuple(rects))
    free = free_cells(space)
    best = max(
        (i1 - i0) * (j1 - j0)
        for i0 in range(14)
        for i1 in range(i0 + 1, 15)
        for j0 in range(11)
        for j1 in range(j0 + 1, 12)
        if free[i0:i1, j0:j1].all()
    )
    size, _ = largest_box(space)
    assert round(size[0] * size[1] * 1e4) == best


@pytest.mark.parametrize(
    ("changes", "count"),
    [
        ({"taken": ((-1.0, -1.0, 1.0, 1.0),)}, 0),
        ({"size": (0.8, 0.3, 0.08)}, 0),
        ({"size": (0.3, 0.3, 0.2), "is_round": True}, 3),
        ({"size": (0.2, 0.2, 0.25), "is_site": True}, 1),
    ],
)
def test_full_low_or_round_spaces_hold_fewer(changes: dict[str, Any], count: int) -> None:
    assert count_of_things(replace(SHELF, **changes)) == count


def test_bounds_are_those_of_the_world() -> None:
    assert world_bounds(SHELF).tolist() == [pytest.approx([0.6, 1.85, 3.0]), pytest.approx([1.4, 2.15, 3.25])]
