"""A report as files that continuous integration reads: JUnit XML, and SARIF 2.1.0 for code scanning.

JUnit has one test case for each input and one for each condition of --fail-on. A rejected input is a failure, and one
that a person has to decide about is skipped. Where conditions are set, only they can fail, so that the file agrees with
the exit code of the command: rejected inputs are then skipped too.

SARIF has a result for each rejected input (error), for each thing that a person has to decide (note), for each advice
(warning) and for each condition that holds (error).

Ref: Apache Ant's JUnit reports; OASIS SARIF 2.1.0.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any
from urllib.parse import quote

from lxml import etree

from casa_assets.model.issue import REVIEW_CODE, Decision
from casa_assets.pipeline.ingest.job import writing
from casa_assets.pipeline.reports.entry import Reported
from casa_assets.pipeline.reports.library.rows import Words
from casa_assets.pipeline.reports.library.summary import Findings
from casa_assets.pipeline.reports.library.written import write_text

SARIF_SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
CONDITION = "fail-on"
# What XML 1.0 cannot hold, not even escaped.
_NO_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@dataclass(frozen=True)
class CiFiles:
    """Files that are written beside a report; None for those that nobody asked for."""

    junit: Path | None = None
    sarif: Path | None = None

    def write(self, found: Findings, words: Words) -> None:
        """Write them. Raises OutputError where a folder cannot be written to."""
        if self.junit is not None:
            _write(self.junit, junit(found))
        if self.sarif is not None:
            _write(self.sarif, sarif(found, words))


NO_CI_FILES = CiFiles()


def _write(path: Path, text: str) -> None:
    with writing(path.parent):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_text(path, text)


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
        case = _case(conditions, CONDITION, outcome.condition.text)
        if outcome.holds:
            etree.SubElement(case, "failure", type=CONDITION, message=_text(str(outcome)))
    for suite in (inputs, conditions):
        suite.set("tests", str(len(suite)))
        suite.set("failures", str(len(suite.findall("testcase/failure"))))
        suite.set("skipped", str(len(suite.findall("testcase/skipped"))))
        suite.set("errors", "0")
    body: str = etree.tostring(root, encoding="unicode", pretty_print=True)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + body


def _case(suite: etree._Element, group: str, name: str) -> etree._Element:
    return etree.SubElement(suite, "testcase", classname=_text(group), name=_text(name), time="0")


def _to_decide(entry: Reported) -> str:
    return f"a person has to decide: {', '.join(sorted(set(entry.to_decide)))}"


def _text(value: str) -> str:
    return _NO_XML.sub("\ufffd", value)


def sarif(found: Findings, words: Words) -> str:
    """The report as SARIF 2.1.0, JSON.

    Args:
        words: what codes mean.
    """
    results = [*_condition_results(found), *(one for entry in found.entries for one in _entry_results(entry, words))]
    rules = {
        code: {"id": code, "shortDescription": {"text": _rule_text(code, words)}}
        for code in sorted({result["ruleId"] for result in results})
    }
    driver = {"name": "casa-assets", "version": version("casa-assets"), "rules": list(rules.values())}
    content = {"$schema": SARIF_SCHEMA, "version": "2.1.0", "runs": [{"tool": {"driver": driver}, "results": results}]}
    return json.dumps(content, indent=1, sort_keys=True) + "\n"


def _rule_text(code: str, words: Words) -> str:
    own = {
        REVIEW_CODE: "A person has to decide something about this asset",
        CONDITION: "A condition of --fail-on holds",
    }
    return own.get(code) or words.meaning(code) or code


def _condition_results(found: Findings) -> Iterator[dict[str, Any]]:
    for outcome in found.outcomes:
        if outcome.holds:
            yield _result(CONDITION, "error", str(outcome), "report.json", outcome.condition.text)


def _entry_results(entry: Reported, words: Words) -> Iterator[dict[str, Any]]:
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
    """One result. key: what it is about, so that the next run knows it again wherever its file lies."""
    location = {"artifactLocation": {"uri": quote(place, errors="replace")}, "region": {"startLine": 1}}
    return {
        "ruleId": rule,
        "level": level,
        "message": {"text": message},
        "locations": [{"physicalLocation": location}],
        "partialFingerprints": {"casaAssets/v1": f"{rule}:{key}"},
    }
