"""Objects out of numbers as RoboCasa draws them: every group of its atomic tasks, and resets of some of them."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from casa_assets import registry
from casa_assets.addons.robocasa.objects import ATTRIBUTES, TASK_DRAWS, missing_draws
from casa_assets.families.build import build_asset, family_of, object_requests, params_of
from casa_assets.model.registry.contract import RobocasaRelease
from tests.support.library.built_libraries import keep
from tests.support.library.libraries import casa
from tests.support.program.environments import found_by, printed, rows_of

KITCHEN = "l_large__mediterranean"  # it affords every pick-and-place task
# A few of the tasks and resets of `./dev bench robocasa_resets`.
TASKS = ("PickPlaceCounterToSink", "PickPlaceFridgeShelfToDrawer", "PickPlaceDrawerToCounter", "PickPlaceCounterToOven")
RESETS, DRAWS = 2, 40
# What the source of all doors puts behind one is left out for these.
DISHWASHERS = ("OpenDishwasher", "CloseDishwasher")
TIMEOUT_S = 1800

pytestmark = pytest.mark.consumers


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory, cache: Path) -> Path:
    """The first member of every category, and a kitchen, as RoboCasa reads them."""
    root = tmp_path_factory.mktemp("robocasa_objects")
    members = [(family_of(request), params_of(request)) for request in object_requests([], 1, 0)]
    keep(root / "library", [build_asset(family, params, cache) for family, params in members])
    done = casa("export", "robocasa", root / "library", "--scenes", KITCHEN, "--out", root / "out")
    assert done.returncode == 0, done.stderr[-4000:]
    return root / "out"


Drawn = dict[str, list[dict[str, Any]]]


@pytest.fixture(scope="module")
def drawn_by_registry(exported: Path) -> Drawn:
    """What each atomic task asks for, and what RoboCasa drew of ours, in each of our registries."""
    return dict(found_by("robocasa", "robocasa/list_groups.py", exported, DRAWS, timeout_s=TIMEOUT_S))


def as_tuple(names: Any) -> tuple[str, ...]:
    return (names,) if isinstance(names, str) else tuple(names or ())


def test_groups_are_read_from_robocasas_source_and_drawn_from_ours_and_those_of_many_kinds_give_many(
    drawn_by_registry: Drawn,
) -> None:
    drawn = drawn_by_registry["casa"]
    asked = {name for row in drawn for name in as_tuple(row["groups"])}
    assert {"all", "fruit", "vegetable", "mug", "plate", "oven_tray", "cookware", "tool", "sandwich_bread"} <= asked
    uses = {use.value for use in ATTRIBUTES[RobocasaRelease.V1_0]}
    assert {name for row in drawn for name in row["filters"]} <= uses
    assert sum(row["task"].startswith("PickPlace") for row in drawn) > 40
    missing = [row for row in drawn if row["error"]]
    assert [f"{row['task']}: {row['groups']} {row['filters']}: {row['error']}" for row in missing] == []
    for row in drawn:
        assert row["groups"] not in ("all", "food", "vegetable", "fruit") or len(row["categories"]) >= 8, row


class TestTasks:
    """What `export robocasa` says of the tasks, against RoboCasa itself."""

    def test_each_draw_is_known(self, drawn_by_registry: Drawn) -> None:
        drawn = drawn_by_registry["casa"]
        for row in drawn:
            if row["task"] in DISHWASHERS and "graspable" in row["filters"]:
                continue
            most = tuple(math.inf if length is None else length for length in row["max_size"] or (None,) * 3)
            asked = (as_tuple(row["groups"]), as_tuple(row["exclude"]), most)
            alike = [d for d in TASK_DRAWS[row["task"]] if (d.groups, d.without, d.max_size) == asked]
            # That a door is of a refrigerator, say, is not in the source where a thing is put behind it.
            assert any(set(row["filters"]) <= {use.value for use in draw.uses} for draw in alike), row
        assert TASK_DRAWS.keys() == {row["task"] for row in drawn}

    def test_a_task_that_robocasa_cannot_reset_is_said_to_lack_something(
        self, drawn_by_registry: Drawn, exported: Path
    ) -> None:
        """A fifth of the categories has its only member in the registry to test with: many tasks lack something."""
        categories = registry.load().categories
        assets = json.loads((exported / "export.json").read_text(encoding="ascii"))["assets"]
        things = [(categories[row["category"]], tuple(row["size_m"])) for row in assets if row["split"] == "test"]
        missing = missing_draws(things)
        failed = {row["task"] for row in drawn_by_registry["casa_test"] if row["error"]}
        assert failed
        assert failed <= missing.keys()
        assert missing.keys() - failed <= {task for task in TASK_DRAWS if task.startswith(("Open", "Close"))}


def test_pick_and_place_tasks_reset_with_our_objects(exported: Path, tmp_path: Path) -> None:
    jobs = [{"task": task, "kitchens": [KITCHEN], "seed": seed, "resets": RESETS} for seed, task in enumerate(TASKS)]
    (tmp_path / "jobs.json").write_text(json.dumps(jobs), encoding="utf-8")
    asked = ("robocasa/reset_tasks.py", exported, tmp_path / "jobs.json")
    rows = rows_of(printed("robocasa", *asked, timeout_s=TIMEOUT_S))
    assert len(rows) == len(TASKS) * RESETS
    assert [f"{row['task']} #{row['number']}: {row['error']}" for row in rows if row["error"]] == []
    assert all(row["categories"] for row in rows)
