"""The table of checks as a whole, and what a certificate says of checks that did not apply, or could not be run."""

from __future__ import annotations

import ast
import importlib
import re
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from string import Formatter
from typing import Any

import pytest
from pydantic import ValidationError

from casa_assets import registry
from casa_assets.checks.check import Check, Measurement, Package, no_fault, not_applicable, not_run, report_not_run, run
from casa_assets.checks.scene.placement import PreviewImages
from casa_assets.checks.table import TABLE
from casa_assets.ingest.collision.fit import CollideParams
from casa_assets.model.issue import CheckResult, Report, Severity, Status
from casa_assets.show.reports.checks_page import checks_markdown, every_code
from casa_assets.textures.check import SET_CHECKS
from casa_assets.textures.check import TABLE as TEXTURES
from tests.support.asset.assets import ball, rigid_mug
from tests.support.asset.packages import not_run_here, written
from tests.support.library.libraries import ROOT

KNOWN = registry.load()
PAGE = checks_markdown()
CODE = re.compile(r"[\"']([A-Z]{3}[0-9]{3})[\"']")
SOURCES = {path: path.read_text(encoding="utf-8") for path in sorted((ROOT / "casa_assets").rglob("*.py"))}


def examples() -> dict[str, tuple[Any, Any]]:
    """Code -> (good, bad), gathered from every module of tests that has a dict EXAMPLES."""
    found: dict[str, tuple[Any, Any]] = {}
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        if re.search(r"^EXAMPLES(: dict.*)? = \{", path.read_text(encoding="utf-8"), re.MULTILINE):
            module = importlib.import_module(".".join(path.relative_to(ROOT).with_suffix("").parts))
            assert not found.keys() & module.EXAMPLES.keys(), f"{path.name} has examples of a code that has some"
            found |= module.EXAMPLES
    return found


def test_every_code_has_a_good_and_a_bad_example() -> None:
    found = examples()
    assert found.keys() == {check.code for check in TABLE}
    assert [code for code, (good, bad) in found.items() if not callable(good) or not bad] == []


def test_codes_are_unique_and_in_order_within_their_family() -> None:
    families = [(family, [c.code for c in rows]) for family, rows in groupby(TABLE, key=lambda check: check.code[:3])]
    assert len(families) == len(dict(families))
    for _, codes in families:
        assert codes == sorted(set(codes))


def faults_of(check: Check) -> Iterator[str]:
    """What is wrong with a row of the table; how a drop is done may stay out of what it says."""
    named = {name for _, name, _, _ in Formatter().parse(check.description) if name}
    if (check.limit is not None) != bool(named & {"limit", "mm", "mm2"}):
        yield "the number that decides is not said"
    if check.limit is not None and check.limit not in KNOWN.limits:
        yield "its limit is not registered"
    elif check.limit is not None and check.unit != KNOWN.limit_units[check.limit]:
        yield "its limit has another unit"
    elif "{" in check.describe(KNOWN.limits):
        yield "a number of its sentence is not filled in"
    if check.code in KNOWN.rejections:
        yield "its code is that of a rejection"
    if f"| {check.code} | **{check.title}**" not in PAGE:
        yield "it is not in the documents"


def test_every_row_names_its_number_which_is_registered_in_its_unit() -> None:
    assert [(check.code, fault) for check in TABLE for fault in faults_of(check)] == []


def test_document_is_the_printed_one() -> None:
    page = ROOT / "docs" / "reference" / "checks.md"
    assert page.read_text(encoding="utf-8") == PAGE, "run ./dev docs"


def test_every_code_in_the_program_is_explained_and_every_waiver_names_a_check() -> None:
    explained = every_code()
    named = {(path.relative_to(ROOT), code) for path, text in SOURCES.items() for code in CODE.findall(text)}
    assert {(path, code) for path, code in named if code not in explained} == set()
    assert {waiver.code for waiver in KNOWN.waivers} <= {check.code for check in TABLE}


def taken_by_key() -> set[str]:
    """Keys that the sources take out of a mapping of limits: `limits["key"]`, `brief.limits["key"]`."""
    found = set()
    for text in SOURCES.values():
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant):
                name = node.value.attr if isinstance(node.value, ast.Attribute) else getattr(node.value, "id", "")
                if name.endswith("limits"):
                    found.add(str(node.slice.value))
    return found


def test_every_limit_is_read_and_none_is_asked_for_that_is_not_there() -> None:
    textures = {row.limit for row in TEXTURES} | {key for _, key, _ in SET_CHECKS.values()}
    asked = {key for check in TABLE for key in (check.limit, *check.others) if key}
    assert KNOWN.limits.keys() - asked - textures - taken_by_key() - CollideParams.model_fields.keys() == set()
    assert asked <= KNOWN.limits.keys()


def report(*found: Measurement, **waived: str) -> Report:
    checks = [lambda *_, told=one: told for one in found]
    rows = [Check("AST001", "Any title", Severity.ERROR, object, check, None, "", "A; b.") for check in checks]
    return run(object(), "one", KNOWN.limits, waived, rows)


def statuses(package: Package) -> dict[str, Status]:
    """By all rows of assets and their packages but those of USD."""
    rows = [check for check in TABLE if not check.code.startswith(("USD", "PAR"))]
    told = [run(subject, "one", KNOWN.limits, table=rows) for subject in (package.asset, package)]
    return {r.code: r.status for one in told for r in one.results}


def test_silence_is_no_pass_and_what_was_not_measured_has_a_reason_and_no_number() -> None:
    with pytest.raises(AssertionError, match="no_fault, not_applicable or not_run"):
        Measurement()
    with pytest.raises(AssertionError):
        Measurement(1.0, status=Status.NOT_RUN, reason="a tool is missing")
    for status in [Status.NOT_APPLICABLE, Status.NOT_RUN]:
        with pytest.raises(ValidationError, match="reason"):
            CheckResult(code="AST001", status=status)


class TestReport:
    def test_what_does_not_apply_keeps_nothing_out_and_an_error_that_was_not_run_does(self) -> None:
        found = report(no_fault(), not_applicable("it has no joints"))
        assert found.passed
        statuses = [(r.status, r.reason) for r in found.results]
        assert statuses == [(Status.PASSED, ""), (Status.NOT_APPLICABLE, "it has no joints")]
        assert str(found.tally) == "1 of 1 that apply"
        found = report(no_fault(), not_run("the validator gave no verdict"))
        assert not found.passed
        assert [i.message for i in found.errors] == ["was not run: the validator gave no verdict"]
        assert found.issues == (), "what nobody found is no finding"
        assert str(found.tally) == "1 of 2 that apply, 1 not run"
        # What was found stands for what it kept from running.
        found = report(Measurement(1.0, (("model.xml", "does not compile"),)), not_run("model.xml does not compile"))
        assert [i.message for i in found.errors] == ["does not compile"]

    def test_a_waiver_is_told_and_keeps_nothing_out(self) -> None:
        found = report(Measurement(2.0, (("", "is broken"),)), AST001="known and accepted")
        assert found.passed
        (result,) = found.results
        assert (result.status, result.waived, result.reason) == (Status.NOT_RUN, True, "known and accepted")

    def test_a_subject_that_is_not_there_leaves_its_checks_not_run(self) -> None:
        found = report_not_run((PreviewImages,), "room", KNOWN.limits, "MuJoCo cannot read scene.xml")
        assert {r.code: r.status for r in found.results} == {"SCN024": Status.NOT_RUN, "SCN025": Status.NOT_RUN}
        assert not found.passed


class TestChecks:
    def test_a_mug_has_no_joints_to_pass(self, tmp_path: Path) -> None:
        found = statuses(written(rigid_mug(), tmp_path))
        of_joints = ("AST015", "KIN001", "KIN005", "KIN009", "MJC009", "CON001", "BEH001")
        assert {found[code] for code in of_joints} == {Status.NOT_APPLICABLE}
        assert {found[code] for code in ("AST001", "AST003", "MJC001", "MJC006")} == {Status.PASSED}
        absent = {code for code in not_run_here(on_good=True) if code in found}
        assert {code for code, status in found.items() if status is Status.NOT_RUN} == absent

    def test_a_file_that_does_not_compile_passes_nothing_that_needs_it(self, tmp_path: Path) -> None:
        package = written(ball(), tmp_path)
        for path in (package.mjcf, package.scene):
            path.write_text("<mujoco><nonsense/></mujoco>")
        found = statuses(package)
        assert found["MJC001"] is Status.FAILED
        assert {found[f"MJC00{n}"] for n in (2, 3, 4, 5, 6, 8)} == {Status.NOT_RUN}
