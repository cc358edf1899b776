"""The doctor says what is missing and how to fix it; a child that crashes or hangs does not take it in."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from typer.testing import CliRunner

from casa_assets.cli import doctor
from casa_assets.cli.doctor import Finding
from casa_assets.cli.main import app

of_machine = pytest.mark.content("code", "cli.doctor", keep=0)
GOOD = Finding(subject="python", ok=True, message="3.11")
NOTE = Finding(subject="disk", ok=False, needed=False, message="1 GiB free")
PACKAGES = tuple(Finding(subject=f"package {name}", ok=True, message="1.0") for name in ("numpy", "scipy"))
EXTRA = Finding(subject="package mink", ok=False, needed=False, message="not installed", fix="pip install mink")
DRAWS = Finding(subject="renderer egl", ok=True, needed=False, message="llvmpipe")
UNUSED = Finding(subject="renderer osmesa", ok=False, needed=False, message="its library is not installed")
BAD = Finding(subject="rendering", ok=False, message="[none] works", fix="sudo apt-get install -y libegl1")


def run(monkeypatch: pytest.MonkeyPatch, found: tuple[Finding, ...], *arguments: str) -> tuple[int, str]:
    monkeypatch.setattr("casa_assets.cli.doctor.findings", lambda output: found)
    result = CliRunner().invoke(app, ["doctor", *arguments])
    return result.exit_code, result.output


def only(found: tuple[Finding, ...], subject: str) -> Finding:
    [finding] = [finding for finding in found if finding.subject == subject]
    return finding


def test_a_line_for_each_thing_and_no_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    found = (GOOD, *PACKAGES, EXTRA, DRAWS, UNUSED, NOTE)
    code, output = run(monkeypatch, found)
    assert code == 0
    lines = output.splitlines()
    expected = ["note disk", "note packages", "ok packages", "ok python"]
    assert [" ".join(line.split()[:2]) for line in lines[:-1]] == expected
    assert "mink" in lines[1]
    _, output = run(monkeypatch, found, "--verbose")
    assert all(word in output for word in ("numpy", "scipy", "renderer osmesa", "llvmpipe"))
    assert "run: pip install mink" in output
    _, output = run(monkeypatch, (GOOD, UNUSED, BAD))
    assert "renderer osmesa" in output
    assert output.startswith("MISSING"), "what is wrong comes first"


def test_a_library_that_is_missing_and_not_needed_is_named_in_words() -> None:
    """PyOpenGL raises an AttributeError there, which says nothing to anybody."""
    raised = "AttributeError: 'NoneType' object has no attribute 'glGetError'"
    found = tuple(doctor._renderers((("egl", True, "llvmpipe"), ("osmesa", False, raised))))
    message = "its library is not installed (libosmesa6); not needed, for egl draws"
    assert only(found, "renderer osmesa").message == message
    assert only(found, "rendering").ok


@of_machine
def test_machine_that_cannot_draw(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # No vendor library behind libEGL is what a machine without Mesa looks like.
    monkeypatch.setenv("__EGL_VENDOR_LIBRARY_FILENAMES", os.devnull)
    monkeypatch.setattr(doctor, "RENDERERS", ("egl",))
    assert doctor.renderer() is None
    finding = only(doctor.findings(tmp_path), "rendering")
    assert (finding.ok, finding.needed) == (False, True)
    assert finding.fix == "sudo apt-get install -y libegl1 libgl1 libgl1-mesa-dri"


@of_machine
def test_package_that_is_missing_and_a_folder_that_cannot_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "requirements", lambda: ("numpy", "not-there"))
    monkeypatch.setattr(doctor, "NATIVE_MODULES", {"numpy": "numpy", "not_there": "not-there"})
    found = doctor.findings(tmp_path / "a" / "b")
    assert only(found, "output folder").ok
    assert not (tmp_path / "a").exists()
    assert only(found, "package numpy").needed
    missing = only(found, "package not-there")
    assert (missing.ok, missing.needed, missing.message) == (False, True, "not installed")
    assert missing.fix
    assert only(found, "native modules").message == "not-there: ModuleNotFoundError: No module named 'not_there'"
    (tmp_path / "file").write_text("")
    finding = next(doctor._folder(tmp_path / "file" / "out"))
    assert (finding.subject, finding.ok, finding.needed, bool(finding.fix)) == ("output folder", False, True, True)


@of_machine
def test_child_that_hangs_or_dies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "CHILD_LIMIT_S", 0.5)
    assert doctor._child("import time; time.sleep(60)") == (False, "no answer within 0.5 s")
    monkeypatch.setattr(doctor, "CHILD_LIMIT_S", 60.0)
    assert doctor._child("import os; os.abort()")[0] is False
    assert doctor._child("raise SystemExit('gone')") == (False, "gone")
