"""The environment of `examples/kitchen_env.py`: what a learner sees, does and is told."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
RUN = Path(__file__).with_name("kitchen_env_run.py")


@pytest.fixture(scope="module")
def found() -> dict[str, Any]:
    backend = os.environ.get("MUJOCO_GL", "egl")
    environment = {**os.environ, "MUJOCO_GL": backend, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    done = subprocess.run(
        [sys.executable, str(RUN)], cwd=ROOT, env=environment, check=False, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(done.stdout)


def test_a_seed_decides_all_and_gymnasium_finds_no_fault(found: dict[str, Any]) -> None:
    assert found["warnings"] == []
    first, other, again, elsewhere = found["walks"]
    assert first == again == elsewhere != other
    assert found["pictures"]["again"] == 0.0
    assert found["pictures"]["other"] > 1.0


def test_a_button_is_pressed_and_a_drawer_is_open_when_it_is_out(found: dict[str, Any]) -> None:
    press = found["press"]
    assert (press["before"], press["success"], press["after"]["power"]) == ("off", True, "on")
    *on_the_way, last = press["rewards"]
    assert on_the_way == sorted(on_the_way), "nearer is better"
    assert max(on_the_way) < 0 < last
    assert found["drawer"] == [False, True]
