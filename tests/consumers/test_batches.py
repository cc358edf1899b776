"""Kitchens of different plans and styles side by side in three engines, each held against MuJoCo, on the processor."""

from __future__ import annotations

import json
import os
import re
import sys
from pathlib import Path
from typing import Any

import pytest

import casa_assets as casa
from casa_assets.addons.batch.batch_form import batch_of
from casa_assets.formats.mjcf.batch import write
from tests.support.kitchen.scenes import put
from tests.support.library.libraries import ROOT, ran
from tests.support.program.environments import CONSUMERS, python_of

# Plan and style of each.
KITCHENS = (
    ("galley", "rustic"),
    ("double_island", "modern_2"),
    ("one_wall_large", "coastal"),
    ("u_small", "mediterranean"),
    ("g_large", "farmhouse"),
    ("l_large", "scandinavian"),
    ("wraparound", "modern_1"),
    ("u_dining", "traditional_2"),
    ("pantry_island", "industrial"),
    ("attic", "transitional_1"),
)
# `.ci/run` has no time for all of it: CASA_SHORT=1 takes two kitchens for 0.2 s in place of ten for 2 s.
SHORT = os.environ.get("CASA_SHORT") == "1"
MANY, STEPS, LEAST_WAY = (2, 100, 0.005) if SHORT else (10, 1000, 0.05)
# Positions in an engine may differ from MuJoCo's by so much after that, m or rad. In MJX nothing sleeps, and it finds
# other points where two boxes touch.
OFF = {"mujoco_warp": 0.001, "newton": 0.001, "mjx": 0.005}
MAX_S = 4 * 3600
# Two renderers draw edges and shadows differently: means of blocks of pixels by so much of 255, on average.
MOST_OFF = 10.0

pytestmark = pytest.mark.consumers


@pytest.fixture(scope="module")
def folders(cache: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    out = tmp_path_factory.mktemp("scenes")
    found = []
    for plan, style in KITCHENS[:MANY]:
        kitchen = casa.kitchen(plan, style)
        found.append(put(write(batch_of(kitchen.scene, cache)), out, kitchen.scene))
    return found


def found_by(script: str, *words: object, **variables: str) -> Any:
    """The JSON in the last line of what a script here prints, in this Python."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **variables}
    done = ran(sys.executable, CONSUMERS / script, *words, timeout=MAX_S, env=environment)
    # As mujoco_warp tells that a buffer was too small; names of its kernels have the word in them, too.
    assert not re.search(r"overflow( -|:)", done.stdout + done.stderr)
    return json.loads(done.stdout.splitlines()[-1])


def engines() -> str:
    code = "import sysconfig; print(sysconfig.get_path('purelib'))"
    return ran(python_of("engines"), "-c", code).stdout.strip()


@pytest.fixture(scope="module", params=sorted(OFF))
def told(request: Any, folders: list[Path]) -> tuple[str, Any]:
    return request.param, found_by("batch_worlds.py", request.param, STEPS, engines(), *folders)


def test_all_kitchens_are_stepped_and_share_what_they_have(told: tuple[str, Any], folders: list[Path]) -> None:
    """Places for all of them: three times the geoms of one at most, of which each has about 290."""
    assert set(told[1]["kitchens"]) == {folder.name for folder in folders}
    assert told[1]["ngeom"] < 900


def test_what_is_pulled_what_is_not_and_what_is_reset_goes_as_far_as_in_mujoco(told: tuple[str, Any]) -> None:
    engine, found = told
    for name, kitchen in found["kitchens"].items():
        assert abs(kitchen["way"]) > LEAST_WAY, f"{name}: {kitchen['pulled']} was not pulled far enough to tell"
        assert kitchen["off"] < OFF[engine], f"{name}: {kitchen['pulled']} is off by {kitchen['off']}"
        assert kitchen["worst_off"] < OFF[engine], f"{name}: {kitchen['worst']} is off by {kitchen['worst_off']}"
    # A reset is of one world alone.
    assert found["reset"]["begun"] < 1e-5, "engines have single precision"
    assert found["reset"]["others"] == 0.0


def test_each_world_shows_its_own_pictures(folders: list[Path], tmp_path: Path) -> None:
    """Drawn at once by mujoco_warp, each kitchen looks as MuJoCo draws it alone, and not as another one."""
    drawn_by = os.environ.get("MUJOCO_GL", "egl")
    found = found_by("batch_pictures.py", engines(), tmp_path, *folders, MUJOCO_GL=drawn_by)
    assert set(found) == {folder.name for folder in folders}
    for name, kitchen in found.items():
        assert kitchen["shown"] > 0.2, f"{name}: next to nothing is drawn"
        assert kitchen["off"] < MOST_OFF, f"{name}: looks unlike MuJoCo's picture of it, by {kitchen['off']} of 255"
        assert kitchen["from_others"] > 2 * kitchen["off"], f"{name}: looks like another kitchen"
