"""A front without seams is parted between its pulls as people would part it."""

from __future__ import annotations

import itertools

import pytest

from casa_assets.articulate.fronts.pull_partition import Item, part_between_pulls

Box = tuple[int, int, int, int]


def pull(row: int, column: int, height: int, width: int) -> Item:
    """A pull around a middle, in pixels."""
    rows, columns = (row - height // 2, row + height // 2), (column - width // 2, column + width // 2)
    return Item(rows, columns, rows, columns)


def room(a: int, b: int, c: int, d: int) -> Item:
    """An open room."""
    return Item((a, b), (c, d), (a, b), (c, d), is_room=True)


def boxes(rows: tuple[int, int], columns: tuple[int, int], items: list[Item]) -> list[Box]:
    """The cells as (first and last row, first and last column)."""
    return [(*c.rows, *c.columns) for c in part_between_pulls(rows, columns, items)]


def near(found: list[Box], wanted: list[Box], slack: int) -> bool:
    """Whether cells are as wanted, but for some pixels."""
    return len(found) == len(wanted) and all(
        abs(a - b) <= slack for f, w in zip(found, wanted, strict=True) for a, b in zip(f, w, strict=True)
    )


def test_three_drawers_in_a_column_are_parted_where_their_pulls_keep_one_distance() -> None:
    """Pulls 20 below the top of drawers of 100, 200 and 300."""
    items = [pull(20, 150, 10, 60), pull(120, 150, 10, 60), pull(320, 150, 10, 60)]
    wanted = [(0, 100, 0, 300), (100, 300, 0, 300), (300, 600, 0, 300)]
    assert near(boxes((0, 600), (0, 300), items), wanted, 12)


def test_a_wide_drawer_below_a_pair_of_doors() -> None:
    """Standing pulls at the outer sides of two doors; a lying one in the middle of the drawer."""
    items = [pull(150, 30, 100, 14), pull(150, 570, 100, 14), pull(450, 300, 14, 100)]
    wanted = [(0, 300, 0, 300), (0, 300, 300, 600), (300, 600, 0, 600)]
    assert near(boxes((0, 600), (0, 600), items), wanted, 25)


def test_doors_whose_pulls_face_each_other_meet_between_them() -> None:
    """Two pairs of doors side by side."""
    items = [pull(200, c, 80, 12) for c in (130, 170, 430, 470)]
    wanted = [(0, 400, 0, 150), (0, 400, 150, 300), (0, 400, 300, 450), (0, 400, 450, 600)]
    assert near(boxes((0, 400), (0, 600), items), wanted, 12)


def test_an_open_room_is_no_front() -> None:
    """Three drawers and a room in a grid of two by two."""
    items = [pull(50, 50, 10, 40), pull(50, 150, 10, 40), pull(150, 150, 10, 40), room(100, 200, 0, 100)]
    wanted = [(0, 100, 0, 100), (0, 100, 100, 200), (100, 200, 100, 200)]
    assert near(boxes((0, 200), (0, 200), items), wanted, 3)


def test_what_is_where_no_pull_would_be_is_not_parted() -> None:
    """Standing things in the middle of narrow strips far from any usual place: nothing is guessed."""
    assert boxes((0, 100), (0, 100), [pull(50, 50, 10, 10)]) == []
    scattered = [pull(20, 40, 8, 8), pull(37, 46, 8, 8), pull(90, 55, 8, 8), pull(71, 61, 8, 8)]
    assert boxes((0, 100), (0, 400), scattered) == []


def test_cells_hold_their_pulls_and_do_not_overlap(subtests: pytest.Subtests) -> None:
    """Whatever the grid, each pull has a cell of its own inside the front."""
    for rows, columns in list(itertools.product((1, 2, 3), (2, 3))):
        with subtests.test(rows=rows, columns=columns):
            items = [pull(60 + 130 * r, 50 + 100 * c, 12, 50) for r in range(rows) for c in range(columns)]
            found = boxes((0, 130 * rows), (0, 100 * columns), items)
            assert len(found) == len(items)
            for a, b, c, d in found:
                assert (
                    sum(a <= i.rows[0] and i.rows[1] <= b and c <= i.columns[0] and i.columns[1] <= d for i in items)
                    == 1
                )
            for (a, b, c, d), (e, f, g, h) in itertools.combinations(found, 2):
                assert min(b, f) <= max(a, e) or min(d, h) <= max(c, g)
