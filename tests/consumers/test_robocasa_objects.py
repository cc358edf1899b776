"""Objects out of numbers as RoboCasa draws them: every group of its atomic tasks, and resets of some of them."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

from casa_assets.export.robocasa.entries import ATTRIBUTES
from casa_assets.model.registry.contract import RobocasaRelease
from casa_assets.pipeline.families.run import build_asset, family_of, object_requests, params_of
from tests.built_libraries import keep
from tests.libraries import casa

ROOT = Path(__file__).parents[2]
SCRIPTS = Path(__file__).with_name("robocasa")
KITCHEN = "l_large__mediterranean"  # it affords every pick-and-place task
# A few of the tasks and resets of `./dev bench robocasa_resets`.
TASKS = ("PickPlaceCounterToSink", "PickPlaceFridgeShelfToDrawer", "PickPlaceDrawerToCounter", "PickPlaceCounterToOven")
RESETS, DRAWS = 2, 40
TIMEOUT_S = 1800


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory, cache: Path) -> Path:
    """The first member of every category, and a kitchen, as RoboCasa reads them."""
    root = tmp_path_factory.mktemp("robocasa_objects")
    members = [(family_of(request), params_of(request)) for request in object_requests([], 1, 0)]
    keep(root / "library", [build_asset(family, params, cache) for family, params in members])
    done = casa("export", "robocasa", "--scenes", KITCHEN, "--library", root / "library", "--out", root / "out")
    assert done.returncode == 0, done.stderr[-4000:]
    return root / "out"


def run(script: str, *arguments: object) -> str:
    """What a script prints in RoboCasa's environment."""
    python = ROOT / os.environ.get("CASA_ROBOCASA", ".venv-robocasa/bin/python")
    assert python.is_file(), f"{python} is missing; './dev consumers' makes it, or name one with CASA_ROBOCASA"
    command = [str(python), str(SCRIPTS / script), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    assert done.returncode == 0, done.stderr[-4000:]
    return done.stdout


@pytest.fixture(scope="module")
def drawn(exported: Path) -> list[dict[str, Any]]:
    """What each atomic task asks for, and what RoboCasa drew of ours."""
    line = run("list_groups.py", exported, DRAWS).splitlines()[-1]
    rows: list[dict[str, Any]] = json.loads(line)["casa"]
    return rows


@pytest.mark.consumers
class TestGroups:
    def test_they_are_read_from_robocasas_source(self, drawn: list[dict[str, Any]]) -> None:
        groups = [row["groups"] for row in drawn]
        asked = {name for names in groups for name in ([names] if isinstance(names, str) else names)}
        assert {"all", "fruit", "vegetable", "mug", "plate", "oven_tray", "cookware", "tool", "sandwich_bread"} <= asked
        assert {name for row in drawn for name in row["filters"]} <= {
            use.value for use in ATTRIBUTES[RobocasaRelease.V1_0]
        }
        assert sum(row["task"].startswith("PickPlace") for row in drawn) > 40

    def test_each_can_be_drawn_from_ours(self, drawn: list[dict[str, Any]]) -> None:
        missing = [row for row in drawn if row["error"]]
        assert [f"{row['task']}: {row['groups']} {row['filters']}: {row['error']}" for row in missing] == []

    def test_groups_of_many_kinds_give_many(self, drawn: list[dict[str, Any]]) -> None:
        for row in drawn:
            if row["groups"] in ("all", "food", "vegetable", "fruit"):
                assert len(row["categories"]) >= 8, row


@pytest.mark.consumers
def test_pick_and_place_tasks_reset_with_our_objects(exported: Path, tmp_path: Path) -> None:
    jobs = [{"task": task, "kitchens": [KITCHEN], "seed": seed, "resets": RESETS} for seed, task in enumerate(TASKS)]
    (tmp_path / "jobs.json").write_text(json.dumps(jobs), encoding="utf-8")
    printed = run("reset_tasks.py", exported, tmp_path / "jobs.json")
    rows = [json.loads(line) for line in printed.splitlines() if line.startswith("{")]
    assert len(rows) == len(TASKS) * RESETS
    assert [f"{row['task']} #{row['number']}: {row['error']}" for row in rows if row["error"]] == []
    assert all(row["categories"] for row in rows)
