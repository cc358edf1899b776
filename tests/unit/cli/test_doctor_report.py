"""The doctor says what is missing and how to fix it, and is not taken in by a child that crashes or hangs."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from casa_assets.cli import doctor

pytestmark = pytest.mark.content("code", "cli.doctor", keep=0)


def only(found: tuple[doctor.Finding, ...], subject: str) -> doctor.Finding:
    [finding] = [finding for finding in found if finding.subject == subject]
    return finding


def test_every_subject_is_looked_at_once(tmp_path: Path) -> None:
    subjects = [finding.subject for finding in doctor.findings(tmp_path)]
    assert len(subjects) == len(set(subjects))
    assert {
        "python",
        "package usd-core",
        "native modules",
        "rendering",
        "output folder",
        "disk",
        "memory",
        "registry",
    } <= set(subjects)


def test_output_folder_is_not_made(tmp_path: Path) -> None:
    finding = only(doctor.findings(tmp_path / "a" / "b"), "output folder")
    assert finding.ok
    assert not (tmp_path / "a").exists()


def test_output_below_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    finding = only(doctor.findings(tmp_path / "file" / "out"), "output folder")
    assert not finding.ok
    assert finding.needed
    assert finding.fix


def test_machine_that_cannot_draw(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # No vendor library behind libEGL is what a machine without Mesa looks like.
    monkeypatch.setenv("__EGL_VENDOR_LIBRARY_FILENAMES", os.devnull)
    monkeypatch.setattr(doctor, "RENDERERS", ("egl",))
    assert doctor.renderer() is None
    finding = only(doctor.findings(tmp_path), "rendering")
    assert not finding.ok
    assert finding.needed
    assert finding.fix == "sudo apt-get install -y libegl1 libgl1 libgl1-mesa-dri"


def test_package_that_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "_requirements", lambda: ("numpy", "not-there"))
    monkeypatch.setattr(doctor, "NATIVE_MODULES", {"numpy": "numpy", "not_there": "not-there"})
    found = doctor.findings(tmp_path)
    assert only(found, "package numpy").needed
    missing = only(found, "package not-there")
    assert (missing.ok, missing.needed, missing.message) == (False, True, "not installed")
    assert missing.fix
    assert only(found, "native modules").message == "not-there: ModuleNotFoundError: No module named 'not_there'"


def test_other_version_is_a_note(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "_pinned", lambda: {"numpy": "0.1"})
    finding = only(doctor.findings(tmp_path), "package numpy")
    assert (finding.ok, finding.needed) == (False, False)
    assert finding.message.endswith("tested with 0.1")


def test_child_that_hangs_or_dies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "CHILD_LIMIT_S", 0.5)
    assert doctor._child("import time; time.sleep(60)") == (False, "no answer within 0.5 s")
    monkeypatch.setattr(doctor, "CHILD_LIMIT_S", 60.0)
    assert doctor._child("import os; os.abort()")[0] is False
    assert doctor._child("raise SystemExit('gone')") == (False, "gone")


def test_name_of_a_requirement(subtests: pytest.Subtests) -> None:
    for requirement, name in [
        ("mujoco-core[usd]", "mujoco-core"),
        ("usd_core==25.11", "usd-core"),
        ("pydantic>=2 ; x", "pydantic"),
    ]:
        with subtests.test(requirement=requirement, name=name):
            assert doctor._name(requirement) == name
