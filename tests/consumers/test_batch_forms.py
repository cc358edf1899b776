"""The batch form of a kitchen in mujoco_warp, which steps it on the processor as it would on a graphics card."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from casa_assets.addons.batch.batch_form import BatchRequest, make_one, read_batch
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.scene_folders import BatchRequest, make_one, read_batch
from tests.support.program.environments import found_by

# Of simulated time that is 0.3 s; a step of one world takes a tenth of a second on a processor.
STEPS = 150
# Compiling its kernels takes two minutes, once.
MAX_S = 1500

pytestmark = pytest.mark.consumers


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a kitchen with its batch form."""
    out = tmp_path_factory.mktemp("scenes")
    done = make_one(SceneRecipe("l_small", "coastal"), out, BatchRequest())
    assert done.folder, done.message
    assert done.passed, done.problems
    return Path(done.folder)


@pytest.fixture(scope="module")
def told(made: Path) -> Any:
    return found_by("engines", "warp_kitchen.py", STEPS, made, timeout_s=MAX_S)[made.name]


def test_it_means_the_same_and_fits_into_its_buffers(told: Any, made: Path) -> None:
    found = read_batch(made)
    assert found is not None
    assert told["pairs"] == found.pairs <= 20_000
    assert told["asleep"] == told["trees"] > 20
    assert abs(told["way"]) > 0.02, "the drawer was not pulled far enough to tell"
    assert told["off"] < 0.002
    assert told["contacts"] <= told["limits"]["nconmax"]
    assert told["rows"] <= told["limits"]["njmax"]
