"""The same input gives the same bytes, whatever the number of workers, the hash seed, the place and the history."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.libraries import casa, casa_here, differences, entries_of, input_rows


@pytest.fixture(scope="module")
def inputs(boxes: Path) -> Path:
    return boxes / "in"


@pytest.fixture(scope="module")
def library(boxes: Path) -> Path:
    """Made by one worker, hash seed 0."""
    return boxes / "library"


def test_all_inputs_have_an_outcome(library: Path) -> None:
    accepted = [path for path in entries_of(library) if not path.startswith("rejected/")]
    assert [path.split("/")[0] for path in accepted] == ["cereal", "cutting_board", "milk"]
    assert len(entries_of(library)) == 5  # the two rows of the manifest without a mesh are lines of one file
    assert len((library / "rejected" / "rows.jsonl").read_text(encoding="utf-8").splitlines()) == 1


def test_another_run_elsewhere_gives_the_same_bytes(inputs: Path, library: Path, tmp_path: Path) -> None:
    moved = tmp_path / "elsewhere" / "in"
    shutil.copytree(inputs, moved)
    done = casa("ingest", moved, "--library", tmp_path / "library", "--jobs", 2, PYTHONHASHSEED="1", TZ="Asia/Tokyo")
    assert done.returncode == 1, done.stdout + done.stderr
    assert differences(library, tmp_path / "library") == []


def test_a_second_run_changes_nothing(inputs: Path, library: Path, tmp_path: Path) -> None:
    again = tmp_path / "library"
    shutil.copytree(library, again)
    before = {path: path.stat().st_mtime_ns for path in again.glob("*/*/*.json")}
    done = casa_here("ingest", inputs, "--library", again, "--json")
    rows = input_rows(done.stdout)
    assert done.returncode == 1
    assert [row["kept"] for row in rows] == [True] * 7
    assert differences(library, again) == []
    assert {path: path.stat().st_mtime_ns for path in again.glob("*/*/*.json")} == before


def test_one_by_one_gives_what_all_at_once_gives(inputs: Path, library: Path, tmp_path: Path) -> None:
    """Entries do not depend on what else a run works on (a twin does, by its nature)."""
    done = casa_here("ingest", inputs / "milk_carton.obj", "--library", tmp_path / "one")
    assert done.returncode == 0, done.stdout + done.stderr
    assert differences(library / "milk", tmp_path / "one" / "milk") == []
