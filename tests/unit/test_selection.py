"""Tests near a change are chosen: as many as fit into the time, and a few that start the program."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

from tests.selection import BUDGET_S, SECONDS, SMOKE, Reaching, changed_files, chosen

ROOT = Path(__file__).parents[2]


def test_the_nearest_that_fit_are_chosen() -> None:
    tests = [Reaching(name, steps) for name, steps in zip("abcdef", (0, 1, 2, 2, 3, None), strict=True)]
    seconds = {"a": 1.0, "b": 80.0, "c": 60.0, "d": 40.0, "e": 45.0, "f": 1.0}
    # `c` is long and imports nothing that was changed, `e` does not fit any more, `f` only starts the program.
    assert chosen(tests, seconds) == (["a", "b", "d"], 3)
    assert chosen(tests, {**seconds, "s": 40.0}, ["s", "f"]) == (["a", "b", "s", "f"], 3)
    assert chosen([Reaching(str(n), 1) for n in range(200)], {})[0] == [str(n) for n in range(int(BUDGET_S / 2))]


def test_what_starts_the_program_and_what_has_a_time_is_there() -> None:
    assert len(SMOKE) <= 10
    named = [*SMOKE, *json.loads(SECONDS.read_text("utf-8"))]
    assert [path for path in named if not (ROOT / path).is_file()] == []


def test_changed_files_are_those_that_differ_from_the_base(tmp_path: Path) -> None:
    def git(*words: str) -> None:
        who = ("-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false")
        subprocess.run(["git", *who, *words], cwd=tmp_path, check=True, stdout=subprocess.DEVNULL)

    git("init", "-q")
    for name in ("one", "two"):
        (tmp_path / name).write_text(name)
        git("add", name)
        git("commit", "-q", "-m", name)
    assert changed_files(tmp_path, None) == ["two"]
    (tmp_path / "one").write_text("changed")
    (tmp_path / "three").write_text("")
    assert changed_files(tmp_path, None) == ["one", "three"]
    assert changed_files(tmp_path, "HEAD~1") == ["one", "two", "three"]
