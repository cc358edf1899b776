"""SimReady's validator is optional: what is said where it is not installed, or fails in the Python that has it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from casa_assets.checks import simready, simready_python
from casa_assets.checks.check import run
from casa_assets.families import build
from casa_assets.ingest.run import steps
from casa_assets.layouts.run import check
from casa_assets.model.issue import CheckResult, Report, Status
from casa_assets.registry import load
from tests.support.asset.assets import rigid_mug
from tests.support.asset.packages import written
from tests.support.kitchen.rooms import LIMITS, at, block, in_all_forms, room

VERSIONS = '{"simready-validate": "1", "simready-foundation-tier-core": "1"}'


@pytest.fixture
def absent(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """No Python of this machine has the validator."""
    monkeypatch.delenv(simready_python.VARIABLE, raising=False)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    monkeypatch.setattr(simready_python, "_versions_here", dict)
    monkeypatch.setattr(simready_python, "_CHECKOUT", tmp_path)


def python_that(does: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Name a program as the validator's Python: it says that it has the packages, and `does` something with files."""
    program = folder / "python"
    program.write_text(f"#!/bin/sh\ncase $4 in simready-validate) echo '{VERSIONS}' ;; *) {does} ;; esac\n")
    program.chmod(0o755)
    monkeypatch.setenv(simready_python.VARIABLE, str(program))


def judged(folder: Path) -> tuple[Report, CheckResult]:
    """The report on a sound mug, and what is said of SimReady in it."""
    report = run(written(rigid_mug(), folder), "mug", load().limits)
    (result,) = (r for r in report.results if r.code == "USD002")
    return report, result


@pytest.mark.usefixtures("absent")
def test_without_it_an_asset_passes_and_a_check_was_not_run(tmp_path: Path) -> None:
    report, result = judged(tmp_path)
    assert (result.status, result.waived) == (Status.NOT_RUN, True)
    assert "SimReady's validator is not installed" in result.reason
    assert report.passed
    assert report.tally.not_run >= 1


@pytest.mark.usefixtures("absent")
@pytest.mark.parametrize("warm", [steps.warm, build.warm, check.warm])
def test_without_it_workers_start(warm: Callable[[], None], monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("simready", "simready.validate"):
        monkeypatch.setitem(sys.modules, name, None)  # cannot be imported
    simready.load_rules.cache_clear()
    with pytest.raises(ImportError):
        simready.load_rules()
    warm()


@pytest.mark.parametrize(
    ("does", "reason"),
    [
        ("kill -9 $$", "ended with -9"),
        ("echo no module >&2; exit 1", "ended with 1: no module"),
        ("echo nonsense", "ended with 0"),
        ("sleep 60", "did not end within 0.5 s"),
        ("echo '{\"verdict\": null}'", "gave no verdict"),
    ],
)
def test_a_validator_that_fails_on_a_file_keeps_it_out(
    does: str, reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    python_that(does, tmp_path, monkeypatch)
    monkeypatch.setattr(simready, "CHILD_LIMIT_S", 0.5 if "sleep" in does else 60.0)
    report, result = judged(tmp_path)
    assert (result.status, result.waived) == (Status.NOT_RUN, False)
    assert reason in result.reason
    assert [issue.code for issue in report.errors] == ["USD002"]


def test_a_python_that_cannot_import_it_keeps_nothing_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    python_that('echo \'{"missing": "no libusd"}\'', tmp_path, monkeypatch)
    report, result = judged(tmp_path)
    assert (result.status, result.waived) == (Status.NOT_RUN, True)
    assert "no libusd" in result.reason
    assert report.passed


def test_without_mujocos_reader_of_usd_an_asset_and_a_kitchen_pass(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("readers.usd_facts", "package.usd", "scene.formats"):
        monkeypatch.setattr(f"casa_assets.checks.{module}.missing_importer", lambda: "it is not installed")
    asset = run(written(rigid_mug(), tmp_path), "mug", load().limits)
    kitchen = run(in_all_forms(room((block("crate", (0.2, 0.2, 0.2)), at(0.0, 0.0, 0.0))), tmp_path), "room", LIMITS)
    absent = {r.code for r in (*asset.results, *kitchen.results) if r.reason == "it is not installed" and r.waived}
    assert absent == {"USD004", "PAR001", "PAR003", "PAR004", "SCN017", "SCN018"}
    assert asset.passed
    assert kitchen.passed
