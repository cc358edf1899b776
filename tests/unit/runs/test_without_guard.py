"""Workers never import the program that starts them: scripts need no `__main__` guard, and notebooks no file."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from unittest.mock import Mock

import pytest

from casa_assets.families import build as run
from casa_assets.families.build import FamilyRequest
from casa_assets.runs import engine as batch
from tests.support.library.libraries import ROOT, put_boxes, ran

pytestmark = [pytest.mark.slow, pytest.mark.content("code", "runs", keep=0)]

# Every kind of run has workers of the one pool, which are told where to begin by the program that starts them.
TEXT = """
from pathlib import Path
from casa_assets.model.kitchen.choices import Surface
from casa_assets.textures.run.check import check_recipes, select_recipes

with Path("started").open("a") as note:
    note.write("once\\n")
recipes = select_recipes([], [Surface.WALL])[:2]
assert len(list(check_recipes(recipes, Path("cache"), 2))) == 2
"""
SCRIPT = f"""{TEXT}
from casa_assets.families.build import FamilyRequest, build_all
from casa_assets.ingest.run.run import Options, ingest
from casa_assets.layouts.run.resolve import SceneRecipe
from casa_assets.layouts.run.scene_folders import BuildOptions, build_all as build_scenes

assert [e.kind for e in ingest([Path("mesh")], Options(Path("library"), jobs=2))] == ["accepted"]
assert all(b.passed for b in build_all([FamilyRequest("vase")], Path("families"), 2, False))
kitchens = [SceneRecipe("one_wall_small", "coastal")]
assert all(s.passed for s in build_scenes(kitchens, Path("scenes"), 2, BuildOptions(drawn=False)))
"""


@pytest.mark.parametrize("started", ["file", "text"])
def test_a_script_without_a_guard(started: str, tmp_path: Path) -> None:
    put_boxes(tmp_path / "mesh", "milk_carton")
    (tmp_path / "script.py").write_text(SCRIPT, encoding="ascii")
    words = ["script.py"] if started == "file" else ["-c", TEXT]
    environment = {**os.environ, "PYTHONPATH": os.environ.get("PYTHONPATH", str(ROOT))}
    ran(sys.executable, *words, cwd=tmp_path, env=environment)
    assert (tmp_path / "started").read_text(encoding="ascii") == "once\n"


def test_one_thing_starts_no_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for module, name in ((subprocess, "Popen"), (os, "fork"), (batch, "open_engine")):
        monkeypatch.setattr(module, name, Mock(side_effect=AssertionError("a process was started")))
    assert run.build_one(FamilyRequest("vase"), tmp_path, drawn=False).passed
