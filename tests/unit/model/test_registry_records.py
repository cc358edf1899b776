"""Rows of the registry as records: categories and contracts, and what they refuse."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import ValidationError

from casa_assets.model.asset.provenance import TEST_SHARE, Split, split_of
from casa_assets.model.registry.category import (
    Category,
)
from casa_assets.model.registry.contract import (
    NamePattern,
    Step,
    Threshold,
)
from tests.support.asset.assets import category, rigid_mug


def mug(**changes: Any) -> Category:
    row = category(rigid_mug()).model_dump(mode="json")
    return Category.model_validate({**row, "shape": (1.0, 0.5, 0.25), **changes})


def spans(*typical: float) -> list[dict[str, float]]:
    return [{"low": 0.9 * t, "typical": t, "high": 1.1 * t} for t in typical]


def test_a_row_may_not_contradict_itself(subtests: pytest.Subtests) -> None:
    for changes, message in [
        ({"size_m": spans(0.2, 0.15, 0.3)}, "longest_m"),
        ({"size_m": spans(0.2, 0.15)}, "size_m"),
        ({"affords": ["washable", "washable"]}, "twice"),
    ]:
        with subtests.test(message=message), pytest.raises(ValidationError, match=message):
            mug(**changes)


def test_a_split_is_told_from_the_digest() -> None:
    for digits, split in (("00000000", Split.TEST), (f"{TEST_SHARE:08x}", Split.TEST), ("00000001", Split.TRAIN)):
        assert split_of(digits + "f" * 56) is split


def test_what_cannot_be_met_is_refused(subtests: pytest.Subtests) -> None:
    threshold = {"name": "on", "joint": "knob"}
    for kind, row, message in [
        *((NamePattern, {"name": name}, None) for name in ("(open", "[a-", "*", "")),
        (NamePattern, {"name": "door", "min_count": 2, "max_count": 1}, "cannot both hold"),
        (Threshold, threshold, "at a position or at a share"),
        (Threshold, {**threshold, "at": 0.4, "share": 0.5}, "at a position or at a share"),
        (Step, {"move": {"door": 1.1}}, None),  # no farther than the ends
    ]:
        with subtests.test(row=row), pytest.raises(ValidationError, match=message):
            kind.model_validate(row)


def test_a_share_counts_from_the_end_nearer_to_zero(subtests: pytest.Subtests) -> None:
    for span, share, at in [
        ((0.0, 2.0), 0.9, 1.8),
        ((-1.5, 0.0), 0.9, -1.35),
        ((-1.5, 0.0), 0.0, 0.0),
        ((-0.8, 0.8), 0.5, 0.0),
        ((-0.8, 0.8), 0.25, -0.4),
    ]:
        with subtests.test(span=span, share=share, at=at):
            assert Threshold(name="x", joint="x", share=share).position(span) == pytest.approx(at)
    assert Threshold(name="x", joint="x", at=0.35).position((0.0, 3.0)) == 0.35
