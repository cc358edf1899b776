"""A full disk is exit 2 in every verb, in one line that names the folder; nothing is taken for a fault of ours."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.support.library.libraries import limited
from tests.unit.articulate.blocks import microwave
from tests.unit.articulate.test_assemble import obj

pytestmark = pytest.mark.slow

# The system's limit on the size of a file stands for a disk that is full.
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


# A folder of files, and one file; workers that meet a full disk are in test_ingest_cli.py.
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
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("error: ")
    assert str(tmp_path) in lines[0]
    assert "cannot be written" in lines[0]
