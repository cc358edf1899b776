"""All atomic tasks of RoboCasa v1.0 that kitchens afford, run by RoboCasa itself (see robocasa/run_tasks.py)."""

from __future__ import annotations

import json
import subprocess
from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest

from casa_assets.checks.design.robot.tasks import ATOMIC_TASKS
from tests.built_libraries import keep
from tests.consumers.robocasa.page import sentence
from tests.environments import python_of, rows_of
from tests.libraries import ROOT, casa
from tests.task_objects import task_objects

SCRIPT = Path(__file__).with_name("robocasa") / "run_tasks.py"
PAGE = ROOT / "docs" / "numbers.md"
# Each floor plan once, in ten of the twelve styles.
KITCHENS = (
    "galley__scandinavian",
    "g_large__modern_1",
    "g_small__farmhouse",
    "l_large__mediterranean",
    "l_small__coastal",
    "one_wall_large__industrial",
    "one_wall_small__modern_2",
    "u_large__rustic",
    "u_small__traditional_1",
    "wraparound__transitional_1",
)
SEEDS = (0, 1, 2)
KITCHENS_PER_TASK = 3
PROCESSES = 2
TIMEOUT_S = 5400


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Export of the kitchens and of objects of all kinds that the tasks ask for."""
    root = tmp_path_factory.mktemp("robocasa_tasks")
    keep(root / "library", task_objects())
    scenes = [part for name in KITCHENS for part in ("--scenes", name)]
    done = casa("export", "robocasa", root / "library", *scenes, "--out", root / "out")
    assert done.returncode == 0, done.stderr[-4000:]
    return root / "out"


@pytest.fixture(scope="module")
def afforded(exported: Path) -> dict[str, dict[str, bool]]:
    """Kitchen -> task -> what the export says, which is what scene.json does."""
    found = {}
    for name in KITCHENS:
        tasks = json.loads((exported / "kitchens" / name / "kitchen.json").read_text())["tasks"]
        found[name] = {task: task in tasks for task in ATOMIC_TASKS}
    return found


def chosen(afforded: dict[str, dict[str, bool]]) -> list[dict[str, Any]]:
    """Three kitchens for each task, or as many as afford it, so that all kitchens get about as many, and all seeds."""
    load: dict[str, int] = defaultdict(int)
    jobs = []
    tasks = sorted(afforded[KITCHENS[0]], key=lambda task: (sum(told[task] for told in afforded.values()), task))
    for task in tasks:
        able = sorted((name for name in KITCHENS if afforded[name][task]), key=lambda name: load[name])
        for seed, name in zip(SEEDS, able[:KITCHENS_PER_TASK], strict=False):
            jobs.append({"task": task, "kitchen": name, "seed": seed, "roll": not load[name]})
            load[name] += 1
    return jobs


def run(export: Path, jobs: list[dict[str, Any]], folder: Path) -> list[dict[str, Any]]:
    """What RoboCasa says of each job; jobs of one kitchen run after another."""
    python = python_of("robocasa")
    running = []
    jobs = sorted(jobs, key=lambda job: job["kitchen"])
    for number in range(PROCESSES):
        wanted, out, err = (folder / f"{number}.{end}" for end in ("json", "out", "err"))
        # Whole kitchens, as far as may be: the first job in a kitchen reads all its meshes.
        share = slice(len(jobs) * number // PROCESSES, len(jobs) * (number + 1) // PROCESSES)
        wanted.write_text(json.dumps(jobs[share]))
        command = [str(python), str(SCRIPT), str(export), str(wanted)]
        running.append((subprocess.Popen(command, stdout=out.open("w"), stderr=err.open("w")), out, err))
    answers = []
    for process, out, err in running:
        try:
            assert process.wait(TIMEOUT_S) == 0, err.read_text()[-4000:]
        finally:
            process.kill()
        answers += rows_of(out.read_text())
    assert len(answers) == len(jobs)
    return answers


def faults(answers: list[dict[str, Any]]) -> list[str]:
    return [f"{row['task']} {row['kitchen']} {row['seed']}: {row['error']}" for row in answers if row["error"]]


@pytest.fixture(scope="module")
def answers(
    exported: Path, afforded: dict[str, dict[str, bool]], tmp_path_factory: pytest.TempPathFactory
) -> list[dict[str, Any]]:
    return run(exported, chosen(afforded), tmp_path_factory.mktemp("jobs"))


@pytest.mark.consumers
class TestTasks:
    def test_each_afforded_task_is_reset_and_comes_to_its_goal(self, answers: list[dict[str, Any]]) -> None:
        assert faults(answers) == []

    def test_all_plans_and_seeds_are_used(
        self, answers: list[dict[str, Any]], afforded: dict[str, dict[str, bool]]
    ) -> None:
        assert {row["kitchen"] for row in answers if row["roll"]} == set(KITCHENS)
        assert {row["seed"] for row in answers} == set(SEEDS)
        for task in afforded[KITCHENS[0]]:
            able = sum(told[task] for told in afforded.values())
            assert sum(row["task"] == task for row in answers) == min(able, KITCHENS_PER_TASK)

    def test_the_page_says_what_ran(self, answers: list[dict[str, Any]], afforded: dict[str, dict[str, bool]]) -> None:
        ran = {(row["task"], row["kitchen"]): not row["error"] for row in answers}
        assert sentence(afforded, ran, KITCHENS) in PAGE.read_text(encoding="utf-8").splitlines()


@pytest.mark.certify
def test_every_task_in_every_kitchen_that_affords_it_with_every_seed(
    exported: Path, afforded: dict[str, dict[str, bool]], tmp_path: Path
) -> None:
    jobs = [
        {"task": task, "kitchen": name, "seed": seed, "roll": True}
        for name in KITCHENS
        for task, is_afforded in afforded[name].items()
        if is_afforded
        for seed in SEEDS
    ]
    assert faults(run(exported, jobs, tmp_path)) == []
