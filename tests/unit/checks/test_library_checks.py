"""Checks of a library as a whole: what is in it twice, what does not look like its kind, and that nobody looked."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from casa_assets.checks.check import run
from casa_assets.checks.library import CategoryRank, LibraryView, ShapePair
from casa_assets.checks.library import in_words as looks_in_words
from casa_assets.checks.objects import MIN_MEMBERS, CategoryConfusion, CollectedMember, ObjectCollection, in_words
from casa_assets.model.asset import asset as asset_records
from casa_assets.model.issue import Status
from tests.support.asset.examples import LIMITS, check_examples

Build = Callable[[], LibraryView | ObjectCollection]


def pair(most: float = 0.001, size: float = 1.0, colors: float = 0.0, kin: bool = True) -> ShapePair:
    return ShapePair("mug_one", "mug_two", most, 2 * most, size, colors, kin)


def named(rank: int, share: float = 0.4) -> CategoryRank:
    return CategoryRank("mug_one", "mug", share, rank, (("cup", 0.3), ("bowl", 0.2), ("pot", 0.05)))


def shelf(alike: float = 0.08, near: float = 0.95, rank: int = 1) -> LibraryView:
    return LibraryView(2, (pair(alike),), (("mug_one", "mug_two", near),), (named(rank),))


Sides = tuple[float, float, float]


def shape_of(sides: Sides) -> asset_records.ShapeDescriptor:
    """A descriptor that hangs on the sides alone; a real one takes a tenth of a second."""
    x, y, z = np.sqrt(np.array(sides) ** 2 / sum(side**2 for side in sides)).tolist()
    return asset_records.ShapeDescriptor(
        radius=max(sides),
        pair_distances=tuple(np.linspace(0.0, x, asset_records.PAIR_SHARES).tolist()),
        center_distances=tuple(np.linspace(z, x + y, asset_records.CENTER_SHARES).tolist()),
        axis_spread=(x, y, z),
    )


def member(category: str, number: int, sides: Sides, light: float) -> CollectedMember:
    tones = np.zeros((asset_records.TONES, asset_records.TONE_SHARES))
    tones[0] = light
    color = asset_records.ColorHistogram(tones=tuple(float(t) for t in tones.ravel()), names=(), stated=True)
    return CollectedMember(
        f"{category}_{number}", category, asset_records.Signature(shape=shape_of(sides), color=color), sides
    )


def kind(category: str, longest: float, light: float, count: int = MIN_MEMBERS) -> list[CollectedMember]:
    """Members of a category: boxes that differ somewhat in length and in lightness."""
    return [member(category, i, (longest * 1.05**i, 0.1, 0.05), light + 5 * (i % 3)) for i in range(count)]


def boxes(light: float = 90.0, length: float = 0.5, alike: dict[str, str] | None = None) -> ObjectCollection:
    return ObjectCollection((*kind("bar", 0.1, 10.0), *kind("slab", length, light)), alike or {})


def with_a_copy() -> ObjectCollection:
    found = boxes()
    one = found.members[0]
    x, y, z = one.sides
    twin = member("bar", 99, (1.01 * x, y, z), 11.0)
    return ObjectCollection((*found.members, twin), {})


def with_strangers(count: int, of: int) -> ObjectCollection:
    """Of the slabs so many are bars to the eye; bars are many, so that of all members few are wrong."""
    bars = kind("bar", 0.1, 10.0, 8 * MIN_MEMBERS)
    slabs = kind("slab", 0.9, 90.0, of - count)
    odd = [
        member("slab", 100 + i, (bars[3 * i].sides[0] * 1.02, 0.1, 0.05), bars[3 * i].signature.color.tones[0] + 1.0)
        for i in range(count)
    ]
    return ObjectCollection((*bars, *slabs, *odd), {})


# Code -> what it is silent on, and what trips it.
EXAMPLES: dict[str, tuple[Build, Build]] = {
    "LIB001": (shelf, lambda: shelf(alike=0.01)),
    "LIB002": (shelf, lambda: shelf(near=0.999)),
    "LIB003": (shelf, lambda: shelf(rank=17)),
    "OBJ005": (boxes, with_a_copy),
    "OBJ006": (boxes, lambda: boxes(light=10.0, length=0.1)),
    "OBJ007": (boxes, lambda: with_strangers(2, MIN_MEMBERS)),
}


@pytest.mark.parametrize("code", EXAMPLES)
def test_each_code_is_tripped_by_its_fault_alone(code: str) -> None:
    """Of a category that is confused the share of all is lower, too."""
    good, bad = (run(make(), "library", LIMITS) for make in EXAMPLES[code])
    check_examples(code, good, bad, along={"OBJ006": ["OBJ007"]}.get(code, ()))
    assert bad.passed, "a library is not turned away"


def test_where_nobody_looked_nothing_passes_in_silence() -> None:
    told = looks_in_words(named(4))
    assert told == "is called mug (40%, number 4 of what it looks like); others: cup (30%), bowl (20%), pot (5%)"
    blind = LibraryView(2, unseen="no weights of CLIP were given")
    report = run(blind, "library", LIMITS)
    passed, unseen = Status.PASSED, Status.NOT_RUN
    assert {r.code: r.status for r in report.results} == {"LIB001": passed, "LIB002": unseen, "LIB003": unseen}
    assert [r.reason for r in report.results] == ["", *["no weights of CLIP were given"] * 2]
    assert report.issues == ()


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


def test_a_copy_is_named_with_what_it_is_a_copy_of() -> None:
    (issue,) = run(with_a_copy(), "library", LIMITS).issues
    assert issue.pointer == "bar_99"
    assert "bar_0" in issue.message


def test_another_size_or_another_colour_is_enough_to_differ(subtests: pytest.Subtests) -> None:
    for sides, light in [((0.12, 0.1, 0.05), 10.0), ((0.1, 0.1, 0.05), 60.0)]:
        with subtests.test(sides=sides, light=light):
            pair = (member("bar", 0, (0.1, 0.1, 0.05), 10.0), member("bar", 1, sides, light))
            assert "OBJ005" not in {issue.code for issue in run(ObjectCollection(pair, {}), "library", LIMITS).issues}


def test_what_a_category_is_taken_for_is_counted() -> None:
    rows = {row.category: row for row in with_strangers(2, MIN_MEMBERS).confusions}
    assert rows["slab"] == CategoryConfusion("slab", MIN_MEMBERS, MIN_MEMBERS - 2, (("bar", 2),))
    assert f"2 of {MIN_MEMBERS} are nearer to another kind: bar (2)" in in_words(rows["slab"])


def test_categories_that_look_the_same_are_not_counted_against_each_other() -> None:
    alike = {"bar": "plank", "slab": "plank"}
    rows = boxes(light=10.0, length=0.1, alike=alike).confusions
    assert [(row.right, row.others) for row in rows] == [(MIN_MEMBERS, ())] * 2


def test_a_few_members_tell_nothing_of_a_kind() -> None:
    few = ObjectCollection((*kind("bar", 0.1, 10.0, 3), *kind("slab", 0.5, 90.0, 3)), {})
    status = {r.code: r.status for r in run(few, "library", LIMITS).results}
    assert status == {"OBJ005": Status.PASSED, "OBJ006": Status.NOT_APPLICABLE, "OBJ007": Status.NOT_APPLICABLE}
