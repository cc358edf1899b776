"""The table of `./dev certify`: what has passed is kept, what has failed is run again."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.certify import __main__ as certify
from tests.certify.parts import Part, parts


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder in place of the checkout's, with three parts: one fails until a file `mended` is there."""
    say = (sys.executable, "-c", "print('3 passed in 1 s')", "pytest")
    code = f"import pathlib, sys; sys.exit(not pathlib.Path({str(tmp_path / 'mended')!r}).exists())"
    leave = f"import pathlib; pathlib.Path({str(tmp_path / 'after')!r}).touch()"
    every = [
        Part("first", "counts", (say,)),
        Part("second", "fails", ((sys.executable, "-c", code),), ((sys.executable, "-c", leave),)),
        Part("third", "passes", ((sys.executable, "-c", ""),)),
    ]
    monkeypatch.setattr(certify, "parts", lambda: every)
    for name, file in {"OUT": "out", "RECORDED": "certified.json", "PAGE": "certified.md", "SHARED": "."}.items():
        monkeypatch.setattr(certify, name, tmp_path / file)
    return tmp_path


def called(monkeypatch: pytest.MonkeyPatch, *words: str) -> int:
    monkeypatch.setattr(sys, "argv", ["certify", *words])
    monkeypatch.setattr(certify, "_commit", lambda: "0123abcd")
    return certify.main()


def test_a_failure_ends_nothing_and_is_run_again(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert called(monkeypatch) == 1
    results = {"first": "passed", "second": "FAILED", "third": "passed"}
    assert {name: done.result for name, done in certify.read().items()} == results
    assert not (place / "after").exists()
    (place / "mended").touch()
    (place / "out" / "first.txt").unlink()
    assert called(monkeypatch, "--resume") == 0
    assert not (place / "out" / "first.txt").exists(), "what has passed is not run again"
    assert (place / "after").exists()
    rows = (place / "certified.md").read_text(encoding="utf-8").splitlines()[-3:]
    assert [row.split(" | ")[2:4] for row in rows] == [["passed", "3"], ["passed", ""], ["passed", ""]]


def test_without_the_shared_data_nothing_is_run(
    place: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(certify, "SHARED", place / "nowhere")
    assert called(monkeypatch) == 1
    assert "CASA_SHARED=<folder>" in capsys.readouterr().err
    assert certify.read() == {}


def test_keys_of_other_programs_are_recorded_where_all_have_passed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(certify, "_commit", lambda: "0123abcd")
    every = [Part(n, "", (("pytest", f"tests/consumers/{n}"),)) for n in "ab"]
    every.append(Part("c", "", (("pytest", "tests/unit"),)))
    here, older = (certify.Record("passed", 1, "2026-11-29", commit) for commit in ("0123abcd", "99999999"))
    failed = certify.Record("FAILED", 1, "2026-11-29", "0123abcd")
    assert certify._programs_passed({"a": here, "b": here}, every)
    for other in (older, failed):
        assert not certify._programs_passed({"a": here, "b": other}, every)
    assert not certify._programs_passed({"a": here}, every)


def test_a_part_that_takes_too_long_fails(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(certify, "_commit", lambda: "0123abcd")
    slow = Part("slow", "sleeps", ((sys.executable, "-c", "import time; time.sleep(60)"),), limit_s=1)
    (place / "out").mkdir()
    assert certify.run(slow).result == "FAILED"


def test_every_test_of_a_release_is_in_a_part() -> None:
    """Folders of tests that some part does not name would never be run."""
    words = {word for part in parts() for command in part.commands for word in command}
    tests = Path(__file__).parents[1]
    for path in sorted(tests.rglob("test_*.py")):
        places = [place.relative_to(tests.parent) for place in (path, *path.parents) if place.is_relative_to(tests)]
        assert {place.as_posix() for place in places} & (words - {"tests"}), path
