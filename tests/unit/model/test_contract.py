"""Contracts as records: patterns, short forms, thresholds, and what `for_each` puts into them."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from casa_assets.model.registry.contract import (
    Contract,
    ForEach,
    JointRule,
    KeyRule,
    NamePattern,
    Requirements,
    SiteRule,
    Step,
    Threshold,
)


def test_a_name_matches_as_a_whole() -> None:
    assert NamePattern(name="door").matches("door")
    assert not NamePattern(name="door").matches("door_main")
    assert NamePattern(name="fridge_.*door.*").matches("fridge_left_door_joint")
    assert not NamePattern(name="rack[0-9]").matches("rack10")


def test_a_bare_name_is_a_rule() -> None:
    needs = Requirements.model_validate(
        {"sites": ["water"], "joints": ["a_joint", {"name": "b_joint", "min_count": 0}]}
    )
    assert needs.sites == (SiteRule(name="water"),)
    assert [(j.name, j.min_count) for j in needs.joints] == [("a_joint", 1), ("b_joint", 0)]
    assert Contract.model_validate({"id": "x", "title": "X", "keyframes": ["closed"]}).keyframes == (
        KeyRule(name="closed"),
    )


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


def test_filled_puts_the_value_into_every_pattern() -> None:
    each = ForEach(
        key="loc",
        values=("rear_left",),
        used_by=("burner_on_{loc}",),
        needs=Requirements(
            joints=(JointRule(name="knob_{loc}_joint", link="knob_{loc}", reach=(0.0, 2.0)),),
            sites=(SiteRule(name="burner_on_{loc}", depth=0),),
        ),
    )
    filled = each.needs.filled("loc", "rear_left")
    assert filled.joints == (JointRule(name="knob_rear_left_joint", link="knob_rear_left", reach=(0.0, 2.0)),)
    assert filled.sites == (SiteRule(name="burner_on_rear_left", depth=0),)
