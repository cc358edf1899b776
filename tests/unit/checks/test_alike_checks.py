"""Checks of a library as a whole: what is in it twice, what does not look like its kind, and that nobody looked."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from casa_assets import registry
from casa_assets.checks.check import run
from casa_assets.checks.library import CategoryRank, LibraryView, ShapePair, in_words
from casa_assets.checks.table import TABLE
from casa_assets.model.issue import Status

LIMITS = registry.load().limits
ROWS = {check.code: check for check in TABLE if check.subject is LibraryView}
Build = Callable[[], LibraryView]


def pair(most: float = 0.001, size: float = 1.0, colors: float = 0.0, kin: bool = True) -> ShapePair:
    """A mug and another thing that lie this near to each other."""
    return ShapePair("mug_one", "mug_two", most, 2 * most, size, colors, kin)


def named(rank: int, share: float = 0.4) -> CategoryRank:
    """A mug that comes at this place among what it looks like."""
    return CategoryRank("mug_one", "mug", share, rank, (("cup", 0.3), ("bowl", 0.2), ("pot", 0.05)))


def shelf(alike: float = 0.08, near: float = 0.95, rank: int = 1) -> LibraryView:
    """Two assets, as different as these numbers say."""
    return LibraryView(2, (pair(alike),), (("mug_one", "mug_two", near),), (named(rank),))


# Code -> what it is silent on, and what trips it alone.
EXAMPLES: dict[str, tuple[Build, Build]] = {
    "LIB001": (shelf, lambda: shelf(alike=0.01)),
    "LIB002": (shelf, lambda: shelf(near=0.999)),
    "LIB003": (shelf, lambda: shelf(rank=17)),
}


@pytest.mark.parametrize("code", EXAMPLES)
def test_each_code_is_tripped_by_its_fault_alone(code: str) -> None:
    good, bad = (run(make(), "library", LIMITS) for make in EXAMPLES[code])
    assert good.issues == ()
    assert [result.code for result in good.results] == sorted(ROWS)
    assert [result.code for result in bad.results if result.status is Status.FAILED] == [code]
    assert {issue.severity for issue in bad.issues} == {ROWS[code].severity}
    assert bad.passed, "a library is not turned away"


def test_where_nobody_looked_nothing_passes_in_silence() -> None:
    blind = LibraryView(2, unseen="no weights of CLIP were given")
    report = run(blind, "library", LIMITS)
    passed, unseen = Status.PASSED, Status.NOT_RUN
    assert {r.code: r.status for r in report.results} == {"LIB001": passed, "LIB002": unseen, "LIB003": unseen}
    assert [r.reason for r in report.results] == ["", *["no weights of CLIP were given"] * 2]
    assert report.issues == ()


def test_alternatives_are_named() -> None:
    assert in_words(named(4)) == (
        "is called mug (40%, number 4 of what it looks like); others: cup (30%), bowl (20%), pot (5%)"
    )


def test_twins_agree_in_form_size_and_colours(subtests: pytest.Subtests) -> None:
    for found, twins, same_form in [
        (pair(), True, True),
        (pair(size=1.02), True, True),
        (pair(size=0.8), False, True),  # a larger and a smaller one
        (pair(size=0.8, kin=False), True, True),  # two names for one mesh give it two sizes
        (pair(colors=12.0), False, True),  # the red and the blue one
        (pair(most=0.05), False, False),
    ]:
        with subtests.test(found=found, twins=twins, same_form=same_form):
            assert found.twins(LIMITS["alike_form"]) is twins
            assert found.same_form(LIMITS["alike_form"]) is same_form
