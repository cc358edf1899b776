"""What a certificate says of checks that did not apply, or could not be run: not that they passed."""

from __future__ import annotations

from pathlib import Path

import pytest
from pydantic import ValidationError

from casa_assets import registry
from casa_assets.checks.check import Check, Measurement, Package, no_fault, not_applicable, not_run, report_not_run, run
from casa_assets.checks.scene.placement import PreviewImages
from casa_assets.checks.table import TABLE
from casa_assets.model.issue import CheckResult, Report, Severity, Status
from tests.support.asset.assets import ball, rigid_mug
from tests.support.asset.packages import not_run_here, written

LIMITS = registry.load().limits
SILENT = ("AST", "VIS", "KIN", "HOL", "CON", "BEH", "MJC", "FLT")


def row(found: Measurement, severity: Severity = Severity.ERROR) -> Check:
    return Check("AST001", "Any title", severity, object, lambda *_: found, None, "", "A; b.")


def report(*found: Measurement, severity: Severity = Severity.ERROR) -> Report:
    return run(object(), "one", LIMITS, table=[row(one, severity) for one in found])


def statuses(package: Package) -> dict[str, Status]:
    rows = [check for check in TABLE if check.code.startswith(SILENT)]
    told = [run(subject, "one", LIMITS, table=rows) for subject in (package.asset, package)]
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
        broken = row(Measurement(2.0, (("", "is broken"),)))
        found = run(object(), "one", LIMITS, {"AST001": "known and accepted"}, [broken])
        assert found.passed
        (result,) = found.results
        assert (result.status, result.waived, result.reason) == (Status.NOT_RUN, True, "known and accepted")

    def test_a_subject_that_is_not_there_leaves_its_checks_not_run(self) -> None:
        found = report_not_run((PreviewImages,), "room", LIMITS, "MuJoCo cannot read scene.xml")
        assert {r.code: r.status for r in found.results} == {"SCN024": Status.NOT_RUN, "SCN025": Status.NOT_RUN}
        assert not found.passed


class TestChecks:
    def test_a_mug_has_no_joints_to_pass(self, tmp_path: Path) -> None:
        found = statuses(written(rigid_mug(), tmp_path))
        assert {found[code] for code in ("AST015", "KIN001", "KIN005", "KIN009", "MJC009", "CON001", "BEH001")} == {
            Status.NOT_APPLICABLE
        }
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
