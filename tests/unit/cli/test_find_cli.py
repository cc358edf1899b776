"""casa-assets find: what it says without weights, without packages, and by words alone."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.support.asset.assets import ball, rigid_mug
from tests.support.library.built_libraries import keep
from tests.support.library.libraries import called as casa
from tests.support.library.libraries import casa as started


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A red mug and an orange."""
    return keep(tmp_path_factory.mktemp("kept") / "library", [rigid_mug(), ball()])


def test_words_alone(library: Path) -> None:
    done = casa("find", "red mug", "--library", library, "--json")
    assert done.returncode == 0, done.stderr
    (row,) = [json.loads(line) for line in done.stdout.splitlines()]
    assert (row["id"], row["category"]) == (rigid_mug().id, "mug")
    done = casa("find", "bicycle", "--library", library, "--verbose")
    assert done.returncode == 1
    assert done.stderr.startswith("no match\n")
    assert "s of processor time" in done.stderr


def test_conditions(library: Path) -> None:
    done = casa("find", "--where", "category=mug,cup", "--where", "size<=0.5", "--library", library, "--json")
    assert done.returncode == 0, done.stderr
    (row,) = [json.loads(line) for line in done.stdout.splitlines()]
    assert (Path(row["folder"]) / "asset.json").is_file()
    assert (row["id"], row["status"]) == (rigid_mug().id, "accepted")
    assert row["mass"] > 0.0
    assert casa("find", "--where", "mass>1000", "--library", library).returncode == 1
    heads = casa("find", "--where", "category=mug", "--library", library).stdout.splitlines()[0]
    assert heads.split() == ["folder", "category"]


def test_one_table_of_libraries(library: Path, tmp_path: Path) -> None:
    tables = tmp_path / "tables"
    done = casa("library", "index", library, "--out", tables)
    assert (done.returncode, done.stdout) == (0, f"2 rows of 1 library in {tables}\n"), done.stderr


def test_a_backend_of_opengl_that_is_not_there_is_the_fault_of_the_machine(library: Path, tmp_path: Path) -> None:
    # PyOpenGL keeps to EGL there, so that OSMesa cannot be opened on any machine, as where its library is missing.
    broken = {"MUJOCO_GL": "osmesa", "PYOPENGL_PLATFORM": "egl"}
    done = started("preview", library, "--out", tmp_path / "out", **broken)
    assert done.returncode == 2
    assert "sudo apt-get install -y libosmesa6" in done.stderr
    assert not any(word in done.stderr for word in ("Traceback", "bug:"))


def test_what_cannot_be_asked_is_told(library: Path, tmp_path: Path) -> None:
    for words, told in (
        (("--library", library), "there are no words to look for"),
        (("mug", "--library", library, "--clip-weights", "nowhere.pt"), "nowhere.pt: there are no weights of CLIP"),
        (("mug", "--where", "size=3", "--library", library), "size is compared with"),
        (("mug", "--clip-weights", "x", "--where", "size<3", "--library", library), "leave --clip-weights out"),
        (("mug", "--library", tmp_path), "is no library"),
    ):
        done = casa("find", *words)
        assert done.returncode == 2
        assert told in " ".join(done.stderr.split()), words
