"""Conditions that fail a build: what may be written, what it means, what is said of what may not."""

from __future__ import annotations

import pytest

from casa_assets.show.reports.gate import COUNTS, BadCondition, judge, parse

CODES = {"FLT005", "MSH014"}
NUMBERS = {**dict.fromkeys(COUNTS, 0), "entries": 40, "accepted": 36, "rejected": 3, "advice": 10, "worse": 2}


def test_a_condition_means_what_it_says(subtests: pytest.Subtests) -> None:
    for text, measured, holds, told in [
        ("rejected", 3, True, "FAIL rejected: 3 of 40, allowed 0"),
        ("rejected>3", 3, False, "PASS rejected: 3 of 40, allowed 3"),
        ("rejected >= 3", 3, True, "FAIL rejected: 3 of 40, allowed less than 3"),
        ("rejected-rate>5%", 0.075, True, "FAIL rejected-rate: 7.5 % of 40, allowed 5 %"),
        ("rejected-rate>0.08", 0.075, False, "PASS rejected-rate: 7.5 % of 40, allowed 8 %"),
        ("accepted<100", 36, True, "FAIL accepted: 36 of 40, allowed at least 100"),
        ("accepted<=35", 36, False, "PASS accepted: 36 of 40, allowed more than 35"),
        ("entries<50", 40, True, "FAIL entries: 40, allowed at least 50"),
        ("worse", 2, True, "FAIL worse: 2 of 40, allowed 0"),
        ("FLT005", 4, True, "FAIL FLT005: 4 of 40, allowed 0"),
        ("MSH014", 0, False, "PASS MSH014: 0 of 40, allowed 0"),
        ("FLT005>4", 4, False, "PASS FLT005: 4 of 40, allowed 4"),
    ]:
        with subtests.test(text=text, measured=measured, holds=holds, told=told):
            (outcome,) = judge([parse(text, CODES)], NUMBERS, {"FLT005": 4})
            assert (outcome.measured, outcome.holds) == (pytest.approx(measured), holds)
            assert f"{outcome.mark} {outcome}" == told


def test_what_is_no_condition_is_told_with_what_is_allowed(subtests: pytest.Subtests) -> None:
    for text, why in [
        ("rejected=5", "is no condition"),
        ("", "is no condition"),
        ("rejectd-rate>5%", "did you mean rejected-rate"),
        ("entries-rate>5%", "nothing is called 'entries-rate'"),
        ("FLT999", "nothing is called 'FLT999'"),
        ("rejected>5%", "% belongs to a rate"),
        ("rejected-rate>5", "a rate is 0 to 1"),
    ]:
        with subtests.test(text=text, why=why):
            with pytest.raises(BadCondition, match=why) as error:
                parse(text, CODES)
            assert "mass-outliers" in str(error.value)


def test_of_nothing_there_is_no_rate_and_changes_need_an_earlier_run() -> None:
    (outcome,) = judge([parse("rejected-rate>0", CODES)], dict.fromkeys(COUNTS, 0), {})
    assert not outcome.holds
    assert parse("gone", CODES).needs_baseline
    assert not parse("rejected", CODES).needs_baseline
