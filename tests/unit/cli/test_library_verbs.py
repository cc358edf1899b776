"""Verbs on libraries: exit codes, lines of JSON, stores, exports, and messages that a person can act on."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from casa_assets.cli.main import app
from casa_assets.errors import OutputError
from tests.support.asset.assets import rigid_mug
from tests.support.library.built_libraries import keep, loose_and_fixed
from tests.support.library.libraries import BOXES, box_obj, called, casa, entries_of, input_rows, limited
from tests.support.library.sharded_inputs import public_differences


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
    total = "7 inputs: 3 accepted, 0 in review, 4 rejected (7 were there already)"
    for words in (total, "RUN006", "category: milk (", "mass: "):
        assert words in done.stdout
    (line,) = done.stderr.splitlines()
    assert line.startswith("Look at it: casa-assets view ")


def test_all_accepted_is_exit_0_and_a_broken_entry_is_named(boxes: Path, tmp_path: Path) -> None:
    library = tmp_path / "library"
    for words in (("ingest", boxes / "in" / "milk_carton.obj"), ("report",)):
        assert called(*words, "--library", library).returncode == 0
    (certificate,) = library.glob("*/*/asset.json")
    certificate.write_text("{", encoding="utf-8")
    for words in (("find", "carton"), ("report",)):
        done = called(*words, "--library", library)
        assert done.returncode == 2
        assert str(certificate) in done.stderr


def test_a_bug_is_exit_3(boxes: Path, tmp_path: Path) -> None:
    hook = "import sys\nsys.modules['casa_assets.runs.pool'] = None\n"
    (tmp_path / "sitecustomize.py").write_text(hook, encoding="ascii")
    done = casa("ingest", boxes / "in", "--library", tmp_path / "library", PYTHONPATH=str(tmp_path))
    assert done.returncode == 3
    assert all(words in done.stderr for words in ("Traceback", "please report it"))


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
    assert sorted(row["path"] for row in input_rows(done.stdout)) == ["a\nb[red]\x1b[31m.obj", "c\\udcff.obj"]


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return keep(tmp_path_factory.mktemp("library") / "lib", loose_and_fixed())


def test_words_and_conditions_find_assets(library: Path) -> None:
    done = called("find", "red mug", "--library", library, "--json")
    assert done.returncode == 0, done.stderr
    found = [json.loads(line) for line in done.stdout.splitlines()]
    assert [row["category"] for row in found] == ["mug", "carton"], "a carton of which half is red comes after the mug"
    assert found[0]["id"] == rigid_mug().id
    done = called("find", "bicycle", "--library", library, "--verbose")
    assert done.returncode == 1
    assert done.stderr.startswith("no match\n")
    assert "s of processor time" in done.stderr
    done = called("find", "--where", "category=mug,cup", "--where", "size<=0.5", "--library", library, "--json")
    assert done.returncode == 0, done.stderr
    (row,) = [json.loads(line) for line in done.stdout.splitlines()]
    assert (Path(row["folder"]) / "asset.json").is_file()
    assert (row["id"], row["status"]) == (rigid_mug().id, "accepted")
    assert row["mass"] > 0.0
    assert called("find", "--where", "mass>1000", "--library", library).returncode == 1
    heads = called("find", "--where", "category=mug", "--library", library).stdout.splitlines()[0]
    assert heads.split() == ["folder", "category"]


def test_a_backend_of_opengl_that_is_not_there_is_the_fault_of_the_machine(library: Path, tmp_path: Path) -> None:
    # PyOpenGL keeps to EGL there, so that OSMesa cannot be opened on any machine, as where its library is missing.
    broken = {"MUJOCO_GL": "osmesa", "PYOPENGL_PLATFORM": "egl"}
    done = casa("preview", library, "--out", tmp_path / "out", **broken)
    assert done.returncode == 2
    assert "sudo apt-get install -y libosmesa6" in done.stderr
    assert not any(word in done.stderr for word in ("Traceback", "bug:"))


def cli(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


def test_a_folder_is_a_store_and_what_one_side_lacks_is_removed_on_request(boxes: Path, tmp_path: Path) -> None:
    pushed = cli("library", "push", boxes / "library", tmp_path / "store")
    assert pushed.exit_code == 0, pushed.output
    assert pushed.output.startswith("Store: ")
    assert "5 copied; " in pushed.output
    assert "5 kept; 0.0 MB" in cli("library", "push", boxes / "library", f"file://{tmp_path}/store").output
    pulled = cli("library", "pull", tmp_path / "store", tmp_path / "back", "-v")
    assert pulled.exit_code == 0, pulled.output
    assert f"Library: {tmp_path}/back: 5 copied; " in pulled.output
    assert public_differences(tmp_path / "back", boxes / "library") == []
    shutil.copytree(boxes / "library", tmp_path / "less")
    shutil.rmtree(tmp_path / "less" / "milk")
    refused = cli("library", "push", tmp_path / "less", tmp_path / "store")
    assert isinstance(refused.exception, OutputError)
    assert "has an entry that" in str(refused.exception)
    done = cli("library", "push", tmp_path / "less", tmp_path / "store", "--delete")
    assert done.exit_code == 0, done.output
    assert "4 kept, 1 removed" in done.output
    assert not (tmp_path / "store" / "milk").exists()


# What `--json` says of every item, whatever the verb.
COMMON = ("verdict", "folder", "mass", "size")


def test_rows_of_an_export_to_robocasa(library: Path, tmp_path: Path) -> None:
    done = called("export", "robocasa", library, "--out", tmp_path / "out", "--json")
    assert done.returncode == 0
    *rows, tasks = [json.loads(line) for line in done.stdout.splitlines()]
    told = {"status", "id", "category", "model", "split", "message", *COMMON}
    assert all(set(row) == told for row in rows)
    assert all(row["mass"] > 0 and len(row["size"]) == 3 for row in rows)
    assert set(tasks) == {"status", "id", "can_be_reset", "missing", "command", *COMMON}
    assert len(tasks["can_be_reset"]) + len(tasks["missing"]) == 65
    assert {"CoffeeSetupMug", "OpenFridge", "TurnOnToaster"} <= set(tasks["can_be_reset"])
    assert tasks["missing"]["OpenDrawer"] == ["tool or utensil, graspable, at most 0.1 m high"]
    assert [row["id"] for row in rows if row["status"] == "left_out"] == ["microwave_0123456789"]
    assert all((row["status"] == "exported") == (row["message"] == "") for row in rows)
    assert all((tmp_path / "out" / row["model"]).is_file() for row in rows if row["model"])


def test_one_asset_takes_the_place_of_an_earlier_export(library: Path, tmp_path: Path) -> None:
    mug = "assets/mug_0123456789.glb"
    assert called("export", "glb", library, "--out", tmp_path / "out").returncode == 0
    plain = (tmp_path / "out" / mug).stat().st_size
    done = called("export", "glb", library / "mug" / "mug_0123456789", "--out", tmp_path / "out", "--layers")
    assert done.returncode == 0
    assert "1 asset as GLB" in done.stdout
    (one,) = (tmp_path / "out").rglob("*.glb")
    assert (one.read_bytes()[:4], one.stat().st_size > plain) == (b"glTF", True)
