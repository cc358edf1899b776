"""casa-assets export: exit codes, lines of JSON, examples in the help."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.support.library.built_libraries import keep, loose_and_fixed
from tests.support.library.libraries import called as casa

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


def test_misuse_is_exit_2_and_one_line(library: Path, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "a").touch()
    for arguments, words in (
        (("robocasa", tmp_path / "empty", "--out", tmp_path / "out"), "holds no accepted asset"),
        (("robocasa", tmp_path / "missing", "--out", tmp_path / "out"), "does not exist"),
        (("robocasa", library, "--out", tmp_path / "taken"), "neither empty nor an earlier export"),
        (("robocasa", library, "--out", tmp_path / "out", "--registry", "No"), "no name of a registry"),
        (("urdf", "--out", tmp_path / "out"), "give either a library"),
        (("urdf", library, "--scenes", "l_small__coastal", "--out", tmp_path / "out"), "give either a library"),
        (("urdf", "--scenes", "l_smal__coastal", "--out", tmp_path / "out"), "l_small__coastal"),
        (("urdf", tmp_path, "--jobs", "2", "--out", tmp_path / "out"), "holds no accepted asset"),
    ):
        done = casa("export", *arguments)
        assert done.returncode == 2
        assert words in " ".join(done.stderr.split())
        assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_one_asset_takes_the_place_of_an_earlier_export(library: Path, tmp_path: Path) -> None:
    mug = "assets/mug_0123456789.glb"
    assert casa("export", "glb", library, "--out", tmp_path / "out").returncode == 0
    plain = (tmp_path / "out" / mug).stat().st_size
    done = casa("export", "glb", library / "mug" / "mug_0123456789", "--out", tmp_path / "out", "--layers")
    assert done.returncode == 0
    assert "1 asset as GLB" in done.stdout
    (one,) = (tmp_path / "out").rglob("*.glb")
    assert (one.read_bytes()[:4], one.stat().st_size > plain) == (b"glTF", True)
