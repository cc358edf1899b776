"""casa-assets export: exit codes, lines of JSON, examples in the help."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.built_libraries import keep, loose_and_fixed
from tests.libraries import called as casa

# What `--json` tells of every item, whatever the verb.
COMMON = ("verdict", "folder", "mass", "size")


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return keep(tmp_path_factory.mktemp("library") / "lib", loose_and_fixed())


def test_json_lines(library: Path, tmp_path: Path) -> None:
    done = casa("export", "robocasa", library, "--out", tmp_path / "out", "--json")
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
    for row in rows:
        assert (row["status"] == "exported") == (row["message"] == "")
        assert not row["model"] or (tmp_path / "out" / row["model"]).is_file()


def test_words(library: Path, tmp_path: Path) -> None:
    done = casa("export", "robocasa", library, "--out", tmp_path / "out")
    assert done.returncode == 0
    for words in (
        "sandwich_bread",
        "left out microwave_0123456789: is a fixture",
        "5 objects in 4 categories",
        "of the 65 atomic tasks of RoboCasa v1.0 can be reset with these objects alone",
        "Make what is missing, then export again: casa-assets objects build ",
    ):
        assert words in done.stdout


def test_misuse_is_exit_2_and_one_line(library: Path, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "a").touch()
    for arguments, words in (
        ((tmp_path / "empty", "--out", tmp_path / "out"), "holds no accepted asset"),
        ((tmp_path / "missing", "--out", tmp_path / "out"), "does not exist"),
        ((library, "--out", tmp_path / "taken"), "neither empty nor an earlier export"),
        ((library, "--out", tmp_path / "out", "--registry", "No"), "no name of a registry"),
    ):
        done = casa("export", "robocasa", *arguments)
        assert done.returncode == 2
        assert words in " ".join(done.stderr.split())
        assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_urdf_of_a_library_and_of_one_asset(library: Path, tmp_path: Path) -> None:
    done = casa("export", "urdf", library, "--out", tmp_path / "out", "--json")
    assert done.returncode == 0
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    assert all(set(row) == {"status", "id", "urdf", "message", *COMMON} for row in rows)
    assert all((tmp_path / "out" / row["urdf"]).is_file() for row in rows)
    done = casa("export", "urdf", library / "mug" / "mug_0123456789", "--out", tmp_path / "out")
    assert done.returncode == 0
    assert "1 asset as URDF" in done.stdout
    assert len(list((tmp_path / "out").rglob("*.urdf"))) == 1


def test_urdf_takes_a_library_or_scenes(library: Path, tmp_path: Path) -> None:
    for arguments, words in (
        ((), "give either a library"),
        ((library, "--scenes", "l_small__coastal"), "give either a library"),
        (("--scenes", "l_smal__coastal"), "l_small__coastal"),
        ((tmp_path, "--jobs", "2"), "holds no accepted asset"),
    ):
        done = casa("export", "urdf", *arguments, "--out", tmp_path / "out")
        assert done.returncode == 2
        assert words in " ".join(done.stderr.split())
        assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_glb_of_a_library_and_of_one_asset(library: Path, tmp_path: Path) -> None:
    done = casa("export", "glb", library, "--out", tmp_path / "out", "--json")
    assert done.returncode == 0
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    assert all(set(row) == {"status", "id", "glb", "message", *COMMON} for row in rows)
    assert all((tmp_path / "out" / row["glb"]).read_bytes().startswith(b"glTF") for row in rows)
    plain = (tmp_path / "out" / "assets" / "mug_0123456789.glb").stat().st_size
    done = casa("export", "glb", library / "mug" / "mug_0123456789", "--out", tmp_path / "out", "--layers")
    assert done.returncode == 0
    assert "1 asset as GLB" in done.stdout
    (one,) = (tmp_path / "out").rglob("*.glb")
    assert one.stat().st_size > plain
