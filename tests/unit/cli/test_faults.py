"""Faults of the program and of the machine: a bug in one item is exit 3, a full disk is exit 2 in every verb."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from casa_assets.families import build as families
from casa_assets.ingest.run import steps as worker
from tests.support.library.libraries import BOXES, box_obj, called, limited
from tests.unit.articulate.blocks import microwave
from tests.unit.articulate.test_assemble import obj


@pytest.fixture
def faulty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Building a vase, and reading a milk carton, meet a fault."""
    build, collect = families.build_asset, worker.collect

    def faulty_build(found: Any, *rest: Any) -> Any:
        assert found.name != "vase", "a vase without a bottom"
        return build(found, *rest)

    def faulty_collect(found: Any, limits: Any) -> Any:
        assert "milk" not in found.main, "a carton without a lid"
        return collect(found, limits)

    monkeypatch.setattr(families, "build_asset", faulty_build)
    monkeypatch.setattr(worker, "collect", faulty_collect)


@pytest.mark.usefixtures("faulty")
def test_of_a_family(tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = called("families", "build", "vase", "switch", "--samples", 1, "--no-pictures", "--library", out, "--json")
    assert done.returncode == 3, done.stderr
    rows = {row["member"]: row for row in map(json.loads, done.stdout.splitlines())}
    assert rows["switch/#0"]["passed"]
    for words in ("AssertionError: a vase without a bottom", "Traceback"):
        assert words in rows["vase/#0"]["message"]
    assert "vase/#0: a fault of the program" in done.stderr


@pytest.mark.usefixtures("faulty")
def test_of_an_input(tmp_path: Path) -> None:
    for name in ("cereal_box", "milk_carton"):
        (tmp_path / f"{name}.obj").write_text(box_obj(BOXES[name]), encoding="ascii")
    done = called("ingest", *tmp_path.glob("*.obj"), "--library", tmp_path / "library", "--json")
    assert done.returncode == 3, done.stderr
    rows = {row["path"]: row for row in map(json.loads, done.stdout.splitlines())}
    assert (rows["cereal_box.obj"]["status"], rows["milk_carton.obj"]["code"]) == ("accepted", "RUN004")
    assert "AssertionError: a carton without a lid" in rows["milk_carton.obj"]["message"]


# The system's limit on the size of a file takes the place of a disk that is full.
VERBS = [
    "textures make oak_natural_plank --out {out}",
    "report --library {library} --out {out}/report.html",
    "families build microwave --library {out}",
    "families show microwave --preset steel --no-check --out {out}",
    "families catalogue vase --no-swatches --out {out}",
    "textures sheet oak_natural_plank --out {out}",
    "scenes build one_wall_small__coastal --out {out}",
    "scenes check one_wall_small__coastal --out {out}",
    "scenes sample 1 --no-pictures --out {out}",
    "articulate {microwave} --up +z --front=-y --library {out}",
    "preview {library} --out {out}",
    "library index {library} --out {out}/tables",
    "export robocasa {library} --out {out}",
]


# A folder of files, and one file; workers that meet a full disk are in test_library_verbs.py.
@pytest.mark.slow
@pytest.mark.representatives(2)
@pytest.mark.parametrize("verb", VERBS)
def test_a_full_disk_is_exit_2_and_names_the_folder(verb: str, boxes: Path, tmp_path: Path) -> None:
    out, copy = tmp_path / "out", tmp_path / "library"
    out.mkdir()
    shutil.copytree(boxes / "library", copy)
    mesh = obj(tmp_path / "microwave.obj", *microwave()[:2])
    words = verb.format(out=out, library=copy, microwave=mesh).split()
    done = limited(1, *words)
    assert done.returncode == 2, done.stdout + done.stderr
    (line,) = done.stderr.strip().splitlines()
    assert line.startswith("error: ")
    assert all(words in line for words in (str(tmp_path), "cannot be written"))
