"""CLIP with a tiny model that open_clip builds itself: search, agreement of categories, weights that are none."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.asset.assets import ball, rigid_mug, textured_box
from tests.support.library.built_libraries import keep
from tests.support.library.libraries import put_boxes, ran
from tests.support.program.environments import with_packages_of

pytestmark = pytest.mark.consumers


def run(*arguments: object, code: int = 0) -> subprocess.CompletedProcess[str]:
    """clip_run.py with our packages, and those that [clip] adds in front of them."""
    variables = with_packages_of("clip", OMP_NUM_THREADS="1", HF_HUB_OFFLINE="1")
    return ran(sys.executable, Path(__file__).with_name("clip_run.py"), *arguments, code=code, env=variables)


@pytest.fixture(scope="module")
def weights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with `tiny`, a model; `bare`, one without weights; and a file of another architecture than it says."""
    folder = tmp_path_factory.mktemp("weights")
    run("make", folder)
    return folder


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return keep(tmp_path_factory.mktemp("kept") / "library", [rigid_mug(), ball(), textured_box()])


def test_words_find_by_pictures_and_twice_the_same(library: Path, weights: Path) -> None:
    asked = ("casa", "find", "red mug", "--library", library, "--clip-weights", weights / "tiny", "--json")
    first, again = run(*asked), run(*asked, "--most", 2)
    rows = [json.loads(line) for line in first.stdout.splitlines()]
    assert {row["category"] for row in rows} == {"mug", "orange", textured_box().labels.category}
    scores = [row["score"] for row in rows]
    assert scores == sorted(scores, reverse=True)
    assert all(-1 <= score <= 1 for score in scores)
    assert len(set(scores)) == 3, "the pictures are looked at"
    assert again.stdout.splitlines() == first.stdout.splitlines()[:2]


def test_ingest_says_what_things_look_like(weights: Path, tmp_path: Path) -> None:
    library, mesh = tmp_path / "library", put_boxes(tmp_path, "milk_carton") / "milk_carton.obj"
    run("casa", "ingest", mesh, "--library", library, "--clip-weights", weights / "tiny")
    whole = json.loads((library / "library.json").read_text(encoding="utf-8"))
    assert whole["weights"] == "tiny"
    ((name, seen),) = whole["seen"].items()
    assert name.startswith("milk_")
    assert seen["category"] == "milk"
    assert len(seen["others"]) == 3
    assert "milk" not in dict(seen["others"])
    assert 0 < seen["share"] < 1
    results = {r["code"]: r for r in whole["report"]["results"]}
    assert results["LIB003"]["number"] == seen["rank"] >= 1
    assert "nobody looked" not in json.dumps(whole)


def test_weights_that_are_none_end_the_search(library: Path, weights: Path) -> None:
    for named, message in [
        (weights / "bare", "cannot be loaded"),
        (weights / "ViT-B-32-of-another-size.pt", "cannot be loaded"),
        (weights, "holds no weights of CLIP"),
        ("ViT-B-32/nobody", "open_clip has of ViT-B-32: "),
    ]:
        assert message in run("casa", "find", "mug", "--library", library, "--clip-weights", named, code=2).stderr
