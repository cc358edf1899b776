"""The same input gives the same bytes, whatever the number of workers, the hash seed, the place and the history."""

from __future__ import annotations

import shutil
from pathlib import Path

from tests.support.library.libraries import casa, casa_here, differences, entries_of, input_rows


def test_all_inputs_have_an_outcome(boxes: Path) -> None:
    library = boxes / "library"
    entries = entries_of(library)
    accepted = [path.split("/")[0] for path in entries if not path.startswith("rejected/")]
    assert accepted == ["cereal", "cutting_board", "milk"]
    assert len(entries) == 5  # the two rows of the manifest without a mesh are lines of one file
    assert len((library / "rejected" / "rows.jsonl").read_text(encoding="utf-8").splitlines()) == 1


def test_another_run_elsewhere_gives_the_same_bytes(boxes: Path, tmp_path: Path) -> None:
    moved = tmp_path / "elsewhere" / "in"
    shutil.copytree(boxes / "in", moved)
    done = casa("ingest", moved, "--library", tmp_path / "library", "--jobs", 2, PYTHONHASHSEED="1", TZ="Asia/Tokyo")
    assert done.returncode == 1, done.stdout + done.stderr
    assert differences(boxes / "library", tmp_path / "library") == []


def test_a_second_run_changes_nothing(boxes: Path, tmp_path: Path) -> None:
    again = tmp_path / "library"
    shutil.copytree(boxes / "library", again)
    before = {path: path.stat().st_mtime_ns for path in again.glob("*/*/*.json")}
    done = casa_here("ingest", boxes / "in", "--library", again, "--json")
    assert done.returncode == 1
    assert [row["kept"] for row in input_rows(done.stdout)] == [True] * 7
    assert differences(boxes / "library", again) == []
    assert {path: path.stat().st_mtime_ns for path in again.glob("*/*/*.json")} == before


def test_one_by_one_gives_what_all_at_once_gives(boxes: Path, tmp_path: Path) -> None:
    """Entries do not depend on what else a run works on (a twin does, by its nature)."""
    done = casa_here("ingest", boxes / "in" / "milk_carton.obj", "--library", tmp_path / "one")
    assert done.returncode == 0, done.stdout + done.stderr
    assert differences(boxes / "library" / "milk", tmp_path / "one" / "milk") == []
