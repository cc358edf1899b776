"""A row of the registry of categories: sizes per axis, phrases, and what it refuses."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import ValidationError

from casa_assets.model.asset.provenance import TEST_SHARE, Split, split_of
from casa_assets.model.registry.category import (
    PICTURE_PROMPTS,
    Affordance,
    Category,
    NumberBasis,
    ObjectType,
    SizeRange,
    clip_prompts,
)
from tests.support.asset.assets import category, rigid_mug


def mug(**changes: Any) -> Category:
    row = category(rigid_mug()).model_dump(mode="json")
    return Category.model_validate({**row, "shape": (1.0, 0.5, 0.25), **changes})


def spans(*typical: float) -> list[dict[str, float]]:
    return [{"low": 0.9 * t, "typical": t, "high": 1.1 * t} for t in typical]


def test_extents_are_the_longest_times_the_shape_or_what_is_said_of_each_axis() -> None:
    x, y, z = mug().extents
    assert (x.typical, y.typical, z.typical) == (0.2, 0.1, 0.05)
    assert (y.low, y.high) == (0.005, 0.5)
    assert [span.typical for span in mug(size_m=spans(0.2, 0.15, 0.12)).extents] == [0.2, 0.15, 0.12]
    assert SizeRange(low=1, typical=2, high=4).scaled(0.5) == SizeRange(low=0.5, typical=1, high=2)


def test_a_row_may_not_contradict_itself(subtests: pytest.Subtests) -> None:
    for changes, message in [
        ({"size_m": spans(0.2, 0.15, 0.3)}, "longest_m"),
        ({"size_m": spans(0.2, 0.15)}, "size_m"),
        ({"affords": ["washable", "washable"]}, "twice"),
    ]:
        with subtests.test(message=message), pytest.raises(ValidationError, match=message):
            mug(**changes)


def test_the_name_is_a_phrase_where_none_is_given() -> None:
    assert mug().phrases == ("a mug",)
    assert mug(id="oven_tray").phrases == ("an oven tray",)
    assert mug(prompts=["a coffee mug"]).phrases == ("a coffee mug",)
    found = clip_prompts(mug(prompts=["a mug", "a cup"]))
    assert len(found) == len(set(found)) == 2 * len(PICTURE_PROMPTS)
    assert found[0] == "a photo of a mug."


def test_what_it_can() -> None:
    found = mug(affords=["washable"], types=["receptacle"])
    assert found.can(Affordance.WASHABLE)
    assert not found.can(Affordance.COOKABLE)
    assert found.types == (ObjectType.RECEPTACLE,)
    assert found.basis.size is NumberBasis.USUAL


def test_a_split_is_told_from_the_digest() -> None:
    for digits, split in (("00000000", Split.TEST), (f"{TEST_SHARE:08x}", Split.TEST), ("00000001", Split.TRAIN)):
        assert split_of(digits + "f" * 56) is split
