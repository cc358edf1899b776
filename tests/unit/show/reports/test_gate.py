"""Two runs beside each other, conditions that fail a build, and the files of a report for continuous integration."""

from __future__ import annotations

import dataclasses
import json
import shutil
from pathlib import Path

import pytest
from lxml import etree

from casa_assets.errors import OutputError
from casa_assets.library import library as disk
from casa_assets.model.issue import REVIEW_CODE, Decision, Issue, Severity
from casa_assets.show.reports.findings import Change, Standing, compare, read_run
from casa_assets.show.reports.gate import COUNTS, BadCondition, judge, junit, parse, sarif
from casa_assets.show.reports.library_page import write
from tests.support.library.built_libraries import keep
from tests.unit.library.test_alike import FIRST, OTHER
from tests.unit.show.reports.test_library_page import HOSTILE, WORDS, entry, findings, reject

A, B, C = "0a0a0a0a0a", "0b0b0b0b0b", "0c0c0c0c0c"


def standing(digits: str, verdict: Decision, *codes: str, category: str = "mug") -> Standing:
    return Standing(f"{category}_{digits}", category, f"{category}/{category}_{digits}", verdict, codes, "x.glb")


def test_how_one_input_does() -> None:
    accepted, advised = standing(A, Decision.ACCEPTED), standing(A, Decision.ACCEPTED, "GEO004")
    review, rejected = standing(A, Decision.REVIEW, "REV001"), standing(A, Decision.REJECTED, "FLT005")
    for before, now, change in [
        (accepted, rejected, Change.WORSE),
        (accepted, review, Change.WORSE),
        (rejected, review, Change.BETTER),
        (accepted, advised, Change.WORSE),
        (advised, accepted, Change.BETTER),
        (advised, standing(A, Decision.ACCEPTED, "SRC042"), Change.WORSE),
        (rejected, standing(A, Decision.REJECTED, "MSH002"), None),
        (accepted, standing(A, Decision.ACCEPTED, category="cup"), None),
        (accepted, None, Change.GONE),
        (None, accepted, Change.APPEARED),
    ]:
        found = compare([before] if before else [], [now] if now else [])
        assert [one.change for one in found] == ([change] if change else []), (before, now)
    before_, now_ = [accepted, standing(B, Decision.REVIEW)], [standing(B, Decision.ACCEPTED), rejected]
    changes = [one.change for one in compare(before_, [*now_, standing(C, Decision.ACCEPTED)])]
    assert changes == [Change.WORSE, Change.BETTER, Change.APPEARED], "what is worse comes first"


def test_a_report_says_what_changed_since_its_own_earlier_version(tmp_path: Path) -> None:
    root = keep(tmp_path / "library", [FIRST, OTHER])
    first = write(root, root / "report.html")
    of_library, of_report = read_run(root), read_run(first.json)
    assert of_library.standings == of_report.standings
    assert of_library.page == of_report.page == first.page
    assert of_library.root.resolve() == of_report.root.resolve()
    shutil.rmtree(disk.Library(root).folder("mug", OTHER.id))
    again = write(root, root / "report.html", first.json, [parse("gone", ()), parse("worse", ())])
    assert [outcome.holds for outcome in again.outcomes] == [True, False]
    found = json.loads(again.json.read_text(encoding="utf-8"))
    assert found["baseline"]["counts"] == {"better": 0, "worse": 0, "appeared": 0, "gone": 1}
    assert found["baseline"]["differences"][0]["id"] == OTHER.id
    assert found["conditions"][0] == {"condition": "gone", "measured": 1, "holds": True}
    assert OTHER.id in again.page.read_text(encoding="utf-8")


def test_what_is_no_report_is_told(tmp_path: Path) -> None:
    path = tmp_path / "report.json"
    other = "schema version 2, and this program reads 1"
    for content, message in [
        *((text, "is no report of a library") for text in ("{", "[]", '{"entries": [{"id": 1}]}', '{"library": "x"}')),
        ('{"schema_version": 2}', other),
    ]:
        path.write_text(content, encoding="utf-8")
        with pytest.raises(OutputError, match=message):
            read_run(path)
    for place in (tmp_path, tmp_path / "nowhere"):
        with pytest.raises(OutputError, match="is no earlier run"):
            read_run(place)


CODES = {"FLT005", "MSH014"}
NUMBERS = {**dict.fromkeys(COUNTS, 0), "entries": 40, "accepted": 36, "rejected": 3, "advice": 10, "worse": 2}


def test_a_condition_means_what_it_says_and_what_is_none_is_refused() -> None:
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
        (outcome,) = judge([parse(text, CODES)], NUMBERS, {"FLT005": 4})
        assert (outcome.measured, outcome.holds) == (pytest.approx(measured), holds), text
        assert f"{outcome.mark} {outcome}" == told
    for text, why in [
        ("rejected=5", "is no condition"),
        ("", "is no condition"),
        ("rejectd-rate>5%", "did you mean rejected-rate"),
        ("entries-rate>5%", "nothing is called 'entries-rate'"),
        ("FLT999", "nothing is called 'FLT999'"),
        ("rejected>5%", "% belongs to a rate"),
        ("rejected-rate>5", "a rate is 0 to 1"),
    ]:
        with pytest.raises(BadCondition, match=f"{why}.*mass-outliers"):
            parse(text, CODES)


UNDECIDED = dataclasses.replace(
    entry("mug_0000000003"),
    warnings=(Issue(code=REVIEW_CODE, severity=Severity.WARNING, pointer="category", message="which kind is it"),),
)
ENTRIES = [entry(), entry("mug_0000000002", warned=True), reject("a b.glb")]


def cases(text: str, kind: str) -> dict[str, str]:
    """Name of each test case with such a mark -> its message."""
    found = etree.fromstring(text.encode()).xpath(f"//testcase[{kind}]")
    return {str(case.get("name")): str(case.find(kind).get("message")) for case in found}


def test_rejected_inputs_are_failures_unless_conditions_are_set() -> None:
    text = junit(findings(ENTRIES))
    assert cases(text, "failure") == {"mug_a b.glb": "SRC003: cannot be read"}
    suite = etree.fromstring(text.encode()).find("testsuite[@name='inputs']")
    assert (suite.get("tests"), suite.get("failures"), suite.get("skipped")) == ("3", "1", "0")
    (case,) = suite.xpath("testcase[failure]")
    assert case.get("file") == "a b.glb"
    assert UNDECIDED.to_decide  # else the next line would say nothing
    assert list(cases(junit(findings([UNDECIDED])), "skipped")) == [UNDECIDED.id]
    text = junit(findings(ENTRIES, None, "rejected>0", "rejected-rate>50%"))
    assert list(cases(text, "failure")) == ["rejected>0"]
    assert list(cases(text, "skipped")) == ["mug_a b.glb"]
    assert cases(junit(findings(ENTRIES, None, "rejected>1")), "failure") == {}


def test_results_of_sarif() -> None:
    run = json.loads(sarif(findings([*ENTRIES, UNDECIDED], None, "rejected"), WORDS))["runs"][0]
    found = [(one["ruleId"], one["level"]) for one in run["results"]]
    assert ("fail-on", "error") in found
    assert ("SRC003", "error") in found
    assert ("GEO004", "warning") in found
    assert [level for rule, level in found if rule == REVIEW_CODE] == ["note"]
    assert {rule["id"] for rule in run["tool"]["driver"]["rules"]} == {rule for rule, _ in found}
    (refused,) = (one for one in run["results"] if one["ruleId"] == "SRC003")
    assert refused["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] == "a%20b.glb"
    assert len({one["partialFingerprints"]["casaAssets/v1"] for one in run["results"]}) == len(found)


def test_texts_of_strangers_are_whole_files() -> None:
    word = HOSTILE + "\x00\x1b[31m\ud800"
    refused = reject(word, word=word)
    assert len(cases(junit(findings([refused])), "failure")) == 1
    assert json.loads(sarif(findings([refused]), WORDS))["runs"][0]["results"][0]["ruleId"] == "SRC003"
