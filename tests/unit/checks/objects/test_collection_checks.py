"""Checks of all members together: which are alike, and which are nearer to another kind than to their own."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from casa_assets import registry
from casa_assets.checks.check import run
from casa_assets.checks.objects import MIN_MEMBERS, CategoryConfusion, CollectedMember, ObjectCollection, in_words
from casa_assets.checks.table import TABLE
from casa_assets.model.asset.provenance import (
    CENTER_SHARES,
    PAIR_SHARES,
    TONE_SHARES,
    TONES,
    ColorHistogram,
    ShapeDescriptor,
    Signature,
)
from casa_assets.model.issue import Status

LIMITS = registry.load().limits
ROWS = {check.code: check for check in TABLE if check.subject is ObjectCollection}
Build = Callable[[], ObjectCollection]
Sides = tuple[float, float, float]


def shape_of(sides: Sides) -> ShapeDescriptor:
    """A descriptor that hangs on the sides alone; a real one takes a tenth of a second."""
    x, y, z = np.sqrt(np.array(sides) ** 2 / sum(side**2 for side in sides)).tolist()
    return ShapeDescriptor(
        radius=max(sides),
        pair_distances=tuple(np.linspace(0.0, x, PAIR_SHARES).tolist()),
        center_distances=tuple(np.linspace(z, x + y, CENTER_SHARES).tolist()),
        axis_spread=(x, y, z),
    )


def member(category: str, number: int, sides: Sides, light: float) -> CollectedMember:
    """A box of one lightness, CIELAB units."""
    tones = np.zeros((TONES, TONE_SHARES))
    tones[0] = light
    color = ColorHistogram(tones=tuple(float(t) for t in tones.ravel()), names=(), stated=True)
    return CollectedMember(f"{category}_{number}", category, Signature(shape=shape_of(sides), color=color), sides)


def kind(category: str, longest: float, light: float, count: int = MIN_MEMBERS) -> list[CollectedMember]:
    """Members of a category: boxes that differ somewhat in length and in lightness."""
    return [member(category, i, (longest * 1.05**i, 0.1, 0.05), light + 5 * (i % 3)) for i in range(count)]


def shelf(light: float = 90.0, length: float = 0.5, alike: dict[str, str] | None = None) -> ObjectCollection:
    """Short dark boxes, and others that are as long and as light as these numbers say."""
    return ObjectCollection((*kind("bar", 0.1, 10.0), *kind("slab", length, light)), alike or {})


def with_a_copy() -> ObjectCollection:
    found = shelf()
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


# Code -> what it is silent on, and what trips it; of a category that is confused the share of all is lower, too.
EXAMPLES: dict[str, tuple[Build, Build]] = {
    "OBJ005": (shelf, with_a_copy),
    "OBJ006": (shelf, lambda: shelf(light=10.0, length=0.1)),
    "OBJ007": (shelf, lambda: with_strangers(2, MIN_MEMBERS)),
}


@pytest.mark.parametrize("code", EXAMPLES)
def test_each_code_is_tripped_by_its_fault(code: str) -> None:
    good, bad = (run(make(), "library", LIMITS) for make in EXAMPLES[code])
    assert good.issues == ()
    assert [result.code for result in good.results] == sorted(ROWS)
    failed = {result.code for result in bad.results if result.status is Status.FAILED}
    assert failed == {code, *({"OBJ007"} if code == "OBJ006" else ())}
    assert bad.passed, "a library is not turned away"


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
    rows = shelf(light=10.0, length=0.1, alike=alike).confusions
    assert [(row.right, row.others) for row in rows] == [(MIN_MEMBERS, ())] * 2


def test_a_few_members_tell_nothing_of_a_kind() -> None:
    few = ObjectCollection((*kind("bar", 0.1, 10.0, 3), *kind("slab", 0.5, 90.0, 3)), {})
    status = {r.code: r.status for r in run(few, "library", LIMITS).results}
    assert status == {"OBJ005": Status.PASSED, "OBJ006": Status.NOT_APPLICABLE, "OBJ007": Status.NOT_APPLICABLE}
