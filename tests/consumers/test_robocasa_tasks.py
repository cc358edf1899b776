"""All atomic tasks of RoboCasa v1.0 that kitchens afford, run by RoboCasa itself (see robocasa/run_tasks.py)."""

from __future__ import annotations

import hashlib
import json
import subprocess
from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest

from casa_assets import registry
from casa_assets.checks.design.tasks import ATOMIC_TASKS
from casa_assets.model.asset.asset import Asset, Link, split_of
from casa_assets.model.asset.material import Material
from casa_assets.model.record import Vec3
from tests.support.asset.asset_parts import CARDBOARD, PROVENANCE, box_collider, box_inertial, labels, seen
from tests.support.library.built_libraries import keep
from tests.support.library.libraries import ROOT, casa
from tests.support.program.environments import python_of, rows_of

# At least one for each group of objects that an atomic task of RoboCasa v1.0 draws from, as far as it can be grasped,
# washed, heated, cooked or cooled as that task demands.
SOLID = (
    *("apple", "lemon", "banana", "carrot", "corn", "tomato", "potato", "bell_pepper"),
    *("bread", "bread_flat", "sandwich_bread", "hotdog_bun", "bagel", "cake", "cupcake", "donut", "cheese"),
    *("hot_dog", "burrito", "fish", "steak", "chicken_drumstick", "egg", "ice_cube", "milk", "can", "wine"),
    *("rolling_pin", "tongs", "ladle", "whisk", "peeler", "measuring_cup", "spoon", "knife"),
)
VESSELS = ("plate", "bowl", "mug", "cup", "glass_cup", "pan", "pot", "saucepan", "oven_tray", "tray", "tupperware")
# They hold nothing here, but stand as themselves.
CLOSED = ("kettle_non_electric", "cutting_board")
# Those for which tasks leave little room: a plate between a microwave and the edge of the worktop, a tray on half of
# an oven's rack, a box that PackDessert makes 2.5 times as wide, bread and cake in the bowl of a stand mixer, flat
# bread that CheesyBread lays on a board, 1.5 times as wide, and cheese on it. The pan is the square in its round
# bowl, without the handle: a box around both would stand in the backguard behind a burner.
OWN_SIZES: dict[str, Vec3] = {
    "plate": (0.16, 0.16, 0.02),
    "pan": (0.19, 0.19, 0.06),
    "oven_tray": (0.32, 0.24, 0.02),
    "tupperware": (0.12, 0.1, 0.05),
    **dict.fromkeys(("bread", "cake"), (0.06, 0.05, 0.03)),
    "bread_flat": (0.12, 0.1, 0.02),
    "cheese": (0.04, 0.04, 0.02),
}


def task_object(name: str, first: int) -> Asset:
    """An object of a kind; digests of sources that begin with 1 are for training, those with 5 for testing."""
    digest = f"0000000{first}{hashlib.sha256(name.encode()).hexdigest()[8:]}"
    category = registry.load().categories[name]
    x, y, z = (round(side.typical, 4) for side in category.extents)
    size = OWN_SIZES.get(name, (x, y, z))
    boxes = _vessel(size) if name in VESSELS else [(size, (0.0, 0.0, size[2] / 2))]
    inertial = box_inertial(category.mass_kg.typical, size, (0.0, 0.0, size[2] / 2))
    visuals = tuple(seen(f"body_{k}", "paint", *box) for k, box in enumerate(boxes))
    colliders = tuple(box_collider(f"body_{k}_hull", *box) for k, box in enumerate(boxes))
    red, green, blue = (part / 255 for part in hashlib.sha256(name.encode()).digest()[:3])
    return Asset(
        id=f"{name}_{digest[:10]}",
        links=(Link(name="object", inertial=inertial, visuals=visuals, colliders=colliders),),
        materials=(Material(id="paint", base_color=(red, green, blue, 1.0)),),
        substances=(CARDBOARD,),
        labels=labels(name, (name,), category.qcode.id).replace(split=split_of(digest)),
        provenance=PROVENANCE.replace(sha256=digest),
    )


def _vessel(size: Vec3) -> list[tuple[Vec3, Vec3]]:
    """Size and middle of a floor and four walls, metres."""
    x, y, z = size
    wall = min(0.004, z / 3)
    return [
        ((x - 2 * wall, y - 2 * wall, wall), (0.0, 0.0, wall / 2)),
        *(((wall, y, z), (side * (x - wall) / 2, 0.0, z / 2)) for side in (-1, 1)),
        *(((x - 2 * wall, wall, z), (0.0, side * (y - wall) / 2, z / 2)) for side in (-1, 1)),
    ]


SCRIPT = Path(__file__).with_name("robocasa") / "run_tasks.py"
PAGE = ROOT / "docs" / "numbers.md"
# Each floor plan once, in ten of the twelve styles.
KITCHENS = (
    *("galley__scandinavian", "g_large__modern_1", "g_small__farmhouse", "l_large__mediterranean", "l_small__coastal"),
    *("one_wall_large__industrial", "one_wall_small__modern_2", "u_large__rustic", "u_small__traditional_1"),
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
    keep(root / "library", [task_object(name, k) for name in (*SOLID, *VESSELS, *CLOSED) for k in (1, 5)])
    scenes = [part for name in KITCHENS for part in ("--scenes", name)]
    done = casa("export", "robocasa", root / "library", *scenes, "--out", root / "out")
    assert done.returncode == 0, done.stderr[-4000:]
    return root / "out"


Afforded = dict[str, dict[str, bool]]


@pytest.fixture(scope="module")
def afforded(exported: Path) -> Afforded:
    """Kitchen -> task -> what the export says, which is what scene.json does."""
    found = {}
    for name in KITCHENS:
        tasks = json.loads((exported / "kitchens" / name / "kitchen.json").read_text())["tasks"]
        found[name] = {task: task in tasks for task in ATOMIC_TASKS}
    return found


def chosen(afforded: Afforded) -> list[dict[str, Any]]:
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
    running = []
    jobs = sorted(jobs, key=lambda job: job["kitchen"])
    for number in range(PROCESSES):
        wanted, out, err = (folder / f"{number}.{end}" for end in ("json", "out", "err"))
        # Whole kitchens, as far as may be: the first job in a kitchen reads all its meshes.
        share = slice(len(jobs) * number // PROCESSES, len(jobs) * (number + 1) // PROCESSES)
        wanted.write_text(json.dumps(jobs[share]))
        command = [str(python_of("robocasa")), str(SCRIPT), str(export), str(wanted)]
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
def answers(exported: Path, afforded: Afforded, tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    return run(exported, chosen(afforded), tmp_path_factory.mktemp("jobs"))


@pytest.mark.consumers
class TestTasks:
    def test_each_afforded_task_is_reset_and_comes_to_its_goal(self, answers: list[dict[str, Any]]) -> None:
        assert faults(answers) == []

    def test_all_plans_and_seeds_are_used(self, answers: list[dict[str, Any]], afforded: Afforded) -> None:
        assert {row["kitchen"] for row in answers if row["roll"]} == set(KITCHENS)
        assert {row["seed"] for row in answers} == set(SEEDS)
        for task in afforded[KITCHENS[0]]:
            able = sum(told[task] for told in afforded.values())
            assert sum(row["task"] == task for row in answers) == min(able, KITCHENS_PER_TASK)

    def test_the_page_says_what_is_afforded_and_how_much_of_it_ran(
        self, answers: list[dict[str, Any]], afforded: Afforded
    ) -> None:
        ran = {(row["task"], row["kitchen"]): not row["error"] for row in answers}
        found = {task: sum(told[task] for told in afforded.values()) for task in afforded[KITCHENS[0]]}
        assert (
            f"{sum(map(bool, found.values()))} of {len(found)} tasks are afforded by at least one of these kitchens, "
            f"{sum(found.values())} pairs of task and kitchen in all; {sum(ran.values())} of {len(ran)} that ran came "
            "to their goal."
        ) in PAGE.read_text(encoding="utf-8").splitlines()


@pytest.mark.certify
def test_every_task_in_every_kitchen_that_affords_it_with_every_seed(
    exported: Path, afforded: Afforded, tmp_path: Path
) -> None:
    pairs = [(name, task) for name, told in afforded.items() for task, is_afforded in told.items() if is_afforded]
    jobs = [{"task": task, "kitchen": name, "seed": k, "roll": True} for name, task in pairs for k in SEEDS]
    assert faults(run(exported, jobs, tmp_path)) == []
