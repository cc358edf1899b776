"""JUnit and SARIF files of a report: they agree with the exit code, and no text of an input breaks them."""

from __future__ import annotations

import dataclasses
import json

from lxml import etree

from casa_assets.model.issue import REVIEW_CODE, Issue, Severity
from casa_assets.show.reports.gate import junit, sarif
from tests.unit.show.reports.test_library_page import HOSTILE, WORDS, entry, findings, reject

UNDECIDED = dataclasses.replace(
    entry("mug_0000000003"),
    warnings=(Issue(code=REVIEW_CODE, severity=Severity.WARNING, pointer="category", message="which kind is it"),),
)
ENTRIES = [entry(), entry("mug_0000000002", warned=True), reject("a b.glb")]


def cases(text: str, kind: str) -> dict[str, str]:
    """Name of each test case with such a mark -> its message."""
    found = etree.fromstring(text.encode()).xpath(f"//testcase[{kind}]")
    return {str(case.get("name")): str(case.find(kind).get("message")) for case in found}


def test_rejected_inputs_are_failures() -> None:
    text = junit(findings(ENTRIES))
    assert cases(text, "failure") == {"mug_a b.glb": "SRC003: cannot be read"}
    suite = etree.fromstring(text.encode()).find("testsuite[@name='inputs']")
    assert (suite.get("tests"), suite.get("failures"), suite.get("skipped")) == ("3", "1", "0")
    (case,) = suite.xpath("testcase[failure]")
    assert case.get("file") == "a b.glb"

    assert UNDECIDED.to_decide  # else the next line would say nothing
    assert list(cases(junit(findings([UNDECIDED])), "skipped")) == [UNDECIDED.id]


def test_where_conditions_are_set_only_they_fail() -> None:
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


def test_texts_of_strangers() -> None:
    word = HOSTILE + "\x00\x1b[31m\ud800"
    refused = reject(word, word=word)
    assert len(cases(junit(findings([refused])), "failure")) == 1
    assert json.loads(sarif(findings([refused]), WORDS))["runs"][0]["results"][0]["ruleId"] == "SRC003"
