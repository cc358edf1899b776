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
from tests.assets import category, rigid_mug


def mug(**changes: Any) -> Category:
    row = category(rigid_mug()).model_dump(mode="json")
    return Category.model_validate({**row, "shape": (1.0, 0.5, 0.25), **changes})


def spans(*typical: float) -> list[dict[str, float]]:
    return [{"low": 0.9 * t, "typical": t, "high": 1.1 * t} for t in typical]


class TestExtents:
    def test_are_the_longest_times_the_shape(self) -> None:
        x, y, z = mug().extents
        assert (x.typical, y.typical, z.typical) == (0.2, 0.1, 0.05)
        assert (y.low, y.high) == (0.005, 0.5)

    def test_are_what_is_said_of_each_axis(self) -> None:
        found = mug(size_m=spans(0.2, 0.15, 0.12)).extents
        assert [span.typical for span in found] == [0.2, 0.15, 0.12]

    def test_may_not_contradict_the_longest(self) -> None:
        with pytest.raises(ValidationError, match="longest_m"):
            mug(size_m=spans(0.2, 0.15, 0.3))

    def test_have_three_axes(self) -> None:
        with pytest.raises(ValidationError):
            mug(size_m=spans(0.2, 0.15))


def test_a_span_is_scaled_in_all_its_parts() -> None:
    assert SizeRange(low=1, typical=2, high=4).scaled(0.5) == SizeRange(low=0.5, typical=1, high=2)


class TestWords:
    def test_the_name_is_a_phrase_where_none_is_given(self) -> None:
        assert mug().phrases == ("a mug",)
        assert mug(id="oven_tray").phrases == ("an oven tray",)
        assert mug(prompts=["a coffee mug"]).phrases == ("a coffee mug",)

    def test_sentences_are_of_pictures(self) -> None:
        found = clip_prompts(mug(prompts=["a mug", "a cup"]))
        assert len(found) == len(set(found)) == 2 * len(PICTURE_PROMPTS)
        assert found[0] == "a photo of a mug."


class TestSets:
    def test_say_nothing_twice(self) -> None:
        with pytest.raises(ValidationError, match="twice"):
            mug(affords=["washable", "washable"])

    def test_what_it_can(self) -> None:
        found = mug(affords=["washable"], types=["receptacle"])
        assert found.can(Affordance.WASHABLE)
        assert not found.can(Affordance.COOKABLE)
        assert found.types == (ObjectType.RECEPTACLE,)
        assert found.basis.size is NumberBasis.USUAL


def test_a_split_is_told_from_the_digest() -> None:
    assert split_of("00000000" + "f" * 56) is Split.TEST
    assert split_of(f"{TEST_SHARE:08x}" + "f" * 56) is Split.TEST
    assert split_of("00000001" + "0" * 56) is Split.TRAIN
