"""casa-assets find: what it says without weights, without packages, and by words alone."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.assets import ball, rigid_mug
from tests.built_libraries import keep
from tests.libraries import casa


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A red mug and an orange."""
    return keep(tmp_path_factory.mktemp("kept") / "library", [rigid_mug(), ball()])


def test_without_weights_it_says_so_and_finds_nothing(library: Path) -> None:
    done = casa("find", "red mug", "--library", library)
    assert done.returncode == 2
    assert "--clip-weights" in done.stderr
    assert "--words" in done.stderr
    assert done.stdout == ""


def test_weights_that_are_not_there_are_named(library: Path) -> None:
    done = casa("find", "red mug", "--library", library, "--clip-weights", "nowhere.pt")
    assert done.returncode == 2
    assert "nowhere.pt: there are no weights of CLIP" in done.stderr


def test_words_alone(library: Path) -> None:
    done = casa("find", "red mug", "--library", library, "--words", "--json")
    assert done.returncode == 0, done.stderr
    (row,) = [json.loads(line) for line in done.stdout.splitlines()]
    assert (row["id"], row["category"]) == (rigid_mug().id, "mug")
    assert casa("find", "bicycle", "--library", library, "--words").returncode == 1
