"""Conditions on a report that fail a build, and the report as JUnit XML and SARIF 2.1.0 for code scanning.

A condition is such as `rejected-rate>5%`, `worse` or `FLT005`.

    CONDITION  = NAME [ OPERATOR NUMBER [ "%" ] ]
    NAME       = a count, a count followed by "-rate", or the code of a check or of a rejection
    OPERATOR   = ">" | ">=" | "<" | "<="

A name alone means that there is at least one. A rate is a share of all entries, 0 to 1 or with a percent sign.

If conditions are set, only they can fail in JUnit, so that the file agrees with the exit code of the command: rejected
inputs are then skipped, as those are that a person has to decide about.

Ref: Apache Ant's JUnit reports; OASIS SARIF 2.1.0.
"""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from lxml import etree

from casa_assets.library.entry import Entry
from casa_assets.library.search import COMPARE, BadCondition
from casa_assets.model.issue import REVIEW_CODE, Decision
from casa_assets.show.page.page_template import Words

if TYPE_CHECKING:
    from casa_assets.show.reports.findings import Findings

# Counts of a report, in the order in which they are listed.
COUNTS = ("entries", "accepted", "review", "rejected", "advice", "not-run", "size-outliers", "mass-outliers")
# Counts beside an earlier run.
CHANGES = ("better", "worse", "appeared", "gone")
# Counts of entries, of which there is a rate.
RATES = ("accepted", "review", "rejected", "advice")
# Operator of a condition that fails a build -> words before the number that is allowed.
_ALLOWED: Mapping[str, str] = {">": "", ">=": "less than ", "<": "at least ", "<=": "more than "}
_FORM = re.compile(r"\s*([A-Za-z][A-Za-z0-9-]*)\s*(?:(>=|<=|>|<)\s*([0-9]*\.?[0-9]+)\s*(%?))?\s*")
GRAMMAR = (
    "write NAME, or NAME followed by >, >=, < or <= and a number; NAME is one of "
    f"{', '.join((*COUNTS, *CHANGES))}, one of "
    f"{', '.join(f'{name}-rate' for name in RATES)} (0 to 1, or with %), or a code such as FLT005"
)

SARIF_SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
FAIL_ON = "fail-on"  # group of the conditions in both files
# Characters that XML 1.0 cannot hold, not even escaped.
_NO_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@dataclass(frozen=True)
class Condition:
    """One condition: what is counted, how it is compared (a key of COMPARE), and the bound."""

    text: str  # as it was written
    name: str
    compare: str
    bound: float

    @property
    def is_rate(self) -> bool:
        """It is about a share of all entries."""
        return self.name.endswith("-rate")

    @property
    def needs_baseline(self) -> bool:
        """It is about what changed since an earlier run."""
        return self.name in CHANGES


@dataclass(frozen=True)
class Outcome:
    """A condition with what was measured."""

    condition: Condition
    measured: float
    holds: bool  # then the build fails
    total: int  # entries of the report

    @property
    def mark(self) -> str:
        """`FAIL` where the condition holds, else `PASS`."""
        return "FAIL" if self.holds else "PASS"

    def __str__(self) -> str:
        """Such as `rejected: 2 of 61, allowed 0`, or `rejected-rate: 3.3 % of 61, allowed 5 %`."""
        name = self.condition.name
        measured, bound = (
            f"{100 * value:.3g} %" if self.condition.is_rate else f"{value:g}"
            for value in (self.measured, self.condition.bound)
        )
        of = "" if name in COUNTS and name not in RATES else f" of {self.total}"
        return f"{name}: {measured}{of}, allowed {_ALLOWED[self.condition.compare]}{bound}"


def parse(text: str, codes: Collection[str]) -> Condition:
    """The condition that a text states; `codes`: of all checks and rejections. Raises BadCondition."""
    found = _FORM.fullmatch(text)
    if found is None:
        raise BadCondition(f"--fail-on {text!r} is no condition; {GRAMMAR}")
    name, compare, number, percent = found.groups()
    rate = name.removesuffix("-rate") if name.endswith("-rate") else ""
    if (rate and rate not in RATES) or not (rate or name in COUNTS or name in CHANGES or name in codes):
        known = (*COUNTS, *CHANGES, *(f"{one}-rate" for one in RATES), *codes)
        near = difflib.get_close_matches(name, sorted(known), n=3, cutoff=0.5)
        hint = f" (did you mean {', '.join(near)}?)" if near else ""
        raise BadCondition(f"--fail-on {text!r}: nothing is called {name!r}{hint}; {GRAMMAR}")
    if percent and not rate:
        raise BadCondition(f"--fail-on {text!r}: {name} is a count, and % belongs to a rate; {GRAMMAR}")
    bound = float(number or 0) / (100 if percent else 1)
    if rate and bound > 1:
        raise BadCondition(f"--fail-on {text!r}: a rate is 0 to 1, or 0% to 100%; {GRAMMAR}")
    return Condition(text.strip(), name, compare or ">", bound)


def judge(conditions: Sequence[Condition], counts: Mapping[str, int], codes: Mapping[str, int]) -> tuple[Outcome, ...]:
    """Each condition with what was measured; `codes`: how many entries have each."""
    found, total = [], counts["entries"]
    for condition in conditions:
        name = condition.name.removesuffix("-rate")
        number: float = counts[name] if name in counts else codes.get(name, 0)
        if condition.is_rate:
            number = number / total if total else 0.0
        found.append(Outcome(condition, number, COMPARE[condition.compare](number, condition.bound), total))
    return tuple(found)


def junit(found: Findings) -> str:
    """The report as JUnit XML."""
    root = etree.Element("testsuites", name=_text(found.library))
    inputs = etree.SubElement(root, "testsuite", name="inputs")
    for entry in found.entries:
        case = _case(inputs, entry.category or "unknown", entry.id)
        if entry.source_path:
            case.set("file", _text(entry.source_path))
        if entry.decision is Decision.REVIEW:
            etree.SubElement(case, "skipped", message=_text(_to_decide(entry)))
        elif entry.decision is Decision.REJECTED:
            kind = "skipped" if found.outcomes else "failure"
            etree.SubElement(case, kind, type=_text(entry.code), message=_text(f"{entry.code}: {entry.message}"))
    conditions = etree.SubElement(root, "testsuite", name="conditions")
    for outcome in found.outcomes:
        case = _case(conditions, FAIL_ON, outcome.condition.text)
        if outcome.holds:
            etree.SubElement(case, "failure", type=FAIL_ON, message=_text(str(outcome)))
    for suite in (inputs, conditions):
        suite.set("tests", str(len(suite)))
        suite.set("failures", str(len(suite.findall("testcase/failure"))))
        suite.set("skipped", str(len(suite.findall("testcase/skipped"))))
        suite.set("errors", "0")
    body: str = etree.tostring(root, encoding="unicode", pretty_print=True)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + body


def _case(suite: etree._Element, group: str, name: str) -> etree._Element:
    return etree.SubElement(suite, "testcase", classname=_text(group), name=_text(name), time="0")


def _to_decide(entry: Entry) -> str:
    return f"a person has to decide: {', '.join(sorted(set(entry.to_decide)))}"


def _text(value: str) -> str:
    return _NO_XML.sub("\ufffd", value)


def sarif(found: Findings, words: Words) -> str:
    """The report as SARIF 2.1.0, JSON."""
    results = [
        _result(FAIL_ON, "error", str(one), "report.json", one.condition.text) for one in found.outcomes if one.holds
    ]
    results += [result for entry in found.entries for result in _entry_results(entry, words)]
    own = {REVIEW_CODE: "A person has to decide something about this asset", FAIL_ON: "A condition of --fail-on holds"}
    rules = [
        {"id": code, "shortDescription": {"text": own.get(code) or words.meaning(code) or code}}
        for code in sorted({result["ruleId"] for result in results})
    ]
    driver = {"name": "casa-assets", "version": version("casa-assets"), "rules": rules}
    content = {"$schema": SARIF_SCHEMA, "version": "2.1.0", "runs": [{"tool": {"driver": driver}, "results": results}]}
    return json.dumps(content, indent=1, sort_keys=True) + "\n"


def _entry_results(entry: Entry, words: Words) -> Iterator[dict[str, Any]]:
    place = entry.source_path or entry.path
    if entry.decision is Decision.REJECTED:
        yield _result(entry.code, "error", f"{entry.id} was rejected: {entry.message}", place, entry.id)
        return
    if entry.to_decide:
        yield _result(REVIEW_CODE, "note", f"{entry.id}: {_to_decide(entry)}", place, entry.id)
    for code in entry.advice:
        if code != REVIEW_CODE:
            yield _result(code, "warning", f"{entry.id}: {words.meaning(code) or code}", place, entry.id)


def _result(rule: str, level: str, message: str, place: str, key: str) -> dict[str, Any]:
    """One result. key: its subject, so that the next run knows it again wherever its file lies."""
    location = {"artifactLocation": {"uri": quote(place, errors="replace")}, "region": {"startLine": 1}}
    return {
        "ruleId": rule,
        "level": level,
        "message": {"text": message},
        "locations": [{"physicalLocation": location}],
        "partialFingerprints": {"casaAssets/v1": f"{rule}:{key}"},
    }
