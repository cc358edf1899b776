"""The command line: exit codes, lines of JSON, and messages that a person can act on."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import pytest

from tests.determinism.test_kill import children
from tests.support.library.libraries import BOXES, ROOT, box_obj, called, casa, command, entries_of, input_rows, limited


@pytest.fixture(scope="module")
def inputs(boxes: Path) -> Path:
    return boxes / "in"


def test_json_lines(boxes: Path) -> None:
    rows = input_rows((boxes / "lines.jsonl").read_text(encoding="utf-8"))
    assert sorted((row["path"], row["status"], row["code"]) for row in rows) == [
        ("broken.glb", "rejected", "SRC002"),
        ("cereal_box.obj", "accepted", ""),
        ("cutting_board.obj", "accepted", ""),
        ("manifest.jsonl", "rejected", "SRC020"),
        ("manifest.jsonl", "rejected", "SRC020"),
        ("milk_carton.obj", "accepted", ""),
        ("twin.obj", "rejected", "RUN006"),
    ]
    keys = {"status", "to_decide", "kept", "path", "id", "code", "message", "warnings", "count", "dry_run"}
    keys |= {"verdict", "folder", "mass", "size"}
    assert all(set(row) == keys for row in rows)
    for row in rows:
        assert (row["mass"] is None) == (row["size"] is None) == (row["status"] == "rejected")
        assert row["folder"] == "" or row["folder"].endswith(row["id"])
    assert all(row["message"] for row in rows if row["status"] == "rejected")


def test_tables_and_reasons(boxes: Path, tmp_path: Path) -> None:
    shutil.copytree(boxes / "library", tmp_path / "library")
    done = called("ingest", boxes / "in", "--library", tmp_path / "library", "--explain")
    assert done.returncode == 1
    for words in (
        "7 inputs: 3 accepted, 0 in review, 4 rejected (7 were there already)",
        "RUN006",
        "category: milk (",
        "mass: ",
    ):
        assert words in done.stdout
    (line,) = done.stderr.splitlines()
    assert line.startswith("Look at it: casa-assets view ")


def test_all_accepted_is_exit_0(inputs: Path, tmp_path: Path) -> None:
    library = tmp_path / "library"
    assert called("ingest", inputs / "milk_carton.obj", "--library", library).returncode == 0
    assert called("report", "--library", library).returncode == 0
    (certificate,) = library.glob("*/*/asset.json")
    certificate.write_text("{", encoding="utf-8")
    for words in (("find", "carton"), ("report",)):
        done = called(*words, "--library", library)
        assert done.returncode == 2
        assert str(certificate) in done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere.glb"], "nowhere.glb"),
        (["{inputs}", "--category", "cuting_board"], "did you mean cutting_board"),
        (["{inputs}", "--library", "{inputs}/broken.glb"], "cannot be written to"),
        (["{inputs}", "--library", "/dev/null/library"], "cannot be written to"),
        (["{inputs}", "--jobs", "-1"], "--jobs"),
        (["{empty}"], "no mesh found"),
        ([], "SOURCES is missing"),
    ],
)
def test_misuse_is_exit_2(arguments: list[str], message: str, inputs: Path, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    filled = [a.format(inputs=inputs, empty=tmp_path / "empty") for a in arguments]
    place = [] if "--library" in filled else ["--library", str(tmp_path / "library")]
    done = called("ingest", *filled, *place)
    assert done.returncode == 2
    assert message in done.stdout + done.stderr
    assert "Traceback" not in done.stderr


def at_work(library: Path) -> bool:
    """A worker has begun; the folder that shows it is made anew at the start of a run."""
    with suppress(FileNotFoundError):
        return any((library / ".casa" / "staging").iterdir())
    return False


def test_two_runs_at_once(inputs: Path, tmp_path: Path) -> None:
    library = tmp_path / "library"
    first = subprocess.Popen(
        command("ingest", inputs / "milk_carton.obj", "--library", library), cwd=ROOT, stdout=subprocess.DEVNULL
    )
    while not at_work(library):
        assert first.poll() is None
        time.sleep(0.01)
    (program,) = children(first.pid)  # below the process that passes signals on
    os.kill(program, signal.SIGSTOP)  # it holds the library however long the other one takes to start
    second = called("ingest", inputs, "--library", library)
    os.kill(program, signal.SIGCONT)
    assert second.returncode == 2
    assert "another run is writing to this library" in second.stderr
    assert first.wait() == 0


def test_a_bug_is_exit_3(inputs: Path, tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(
        "import sys\nsys.modules['casa_assets.runs.pool'] = None\n",
        encoding="ascii",
    )
    done = casa("ingest", inputs, "--library", tmp_path / "library", PYTHONPATH=str(tmp_path))
    assert done.returncode == 3
    assert "Traceback" in done.stderr
    assert "please report it" in done.stderr


def test_a_full_disk_is_exit_2_and_leaves_nothing_behind(boxes: Path, tmp_path: Path) -> None:
    library = tmp_path / "library"
    mesh = tmp_path / "milk_carton.obj"
    mesh.write_text(box_obj(BOXES["milk_carton"]), encoding="ascii")
    done = limited(8, "ingest", mesh, "--library", library)
    assert done.returncode == 2, done.stdout + done.stderr
    assert f"{library}: cannot be written to: File too large" in done.stderr.replace("\n", " ")
    assert all(path.startswith("rejected/") for path in entries_of(library))
    assert list((library / ".casa" / "staging").iterdir()) == []
    assert called("ingest", mesh, "--library", library).returncode == 0
    (entry,) = entries_of(library)
    assert entry in entries_of(boxes / "library")


def test_hostile_names_do_not_reach_the_terminal(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a\nb[red]\x1b[31m.obj").touch()
    (tmp_path / "in" / os.fsdecode(b"c\xff.obj")).touch()
    done = called("ingest", tmp_path / "in", "--library", tmp_path / "library")
    assert done.returncode == 1
    assert "a\\nb[red]\\x1b[31m.obj" in done.stdout
    assert "\x1b" not in done.stdout
    shutil.rmtree(tmp_path / "library")
    done = called("ingest", tmp_path / "in", "--library", tmp_path / "library", "--json")
    assert sorted(row["path"] for row in input_rows(done.stdout)) == [
        "a\nb[red]\x1b[31m.obj",
        "c\\udcff.obj",
    ]
