"""Resets RoboCasa's tasks again and again on exported kitchens and prints one line of JSON for each reset.

    python reset_tasks.py EXPORT JOBS

JOBS: a file of JSON rows {"task", "kitchens", "seed", "resets"}. The task is made once by `robosuite.make` and draws
one of the kitchens at each reset; after an error it is made anew with another seed. Each line has the task, its number,
the kitchen, the categories of what was drawn, how often RoboCasa tried to make the scene (it gives up at 50), seconds,
and `error`, empty where nothing is amiss. Runs in RoboCasa's own environment, RoboCasa as it is.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
import time
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from robocasa.environments.kitchen.kitchen import Kitchen
from run_tasks import engine_warnings, make, registered, why

NEXT_SEED = 1000  # from the seed of one environment to that of the next one of the same job


def count_attempts() -> list[int]:
    """A list with the number of attempts at the scene of the reset that runs."""
    loads, attempts = Kitchen._load_model, [0]

    def load(self: Any, attempt_num: int = 1) -> Any:
        attempts[0] = max(attempts[0], attempt_num)
        return loads(self, attempt_num=attempt_num)

    Kitchen._load_model = load
    return attempts


def reset(env: Any) -> str:
    env.reset()
    if told := engine_warnings(env):
        return f"warnings: {told}"
    return "" if np.isfinite(env.sim.data.qpos).all() else "positions are not finite"


def run(job: dict[str, Any], kitchens: Any, attempts: list[int]) -> Iterator[dict[str, Any]]:
    env: Any = None
    seed = job["seed"]
    for number in range(job["resets"]):
        began, attempts[0] = time.perf_counter(), 0
        row: dict[str, Any] = {"task": job["task"], "number": number, "seed": seed, "kitchen": "", "categories": []}
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                if env is None:
                    env = make({**job, "seed": seed}, kitchens)
                row["error"] = reset(env)
            row["kitchen"] = kitchens.kitchen_of(env)
            row["categories"] = [cfg["info"]["cat"] for cfg in env.object_cfgs]
        except Exception as error:  # noqa: BLE001 - each reset answers for itself
            row["error"] = why(error)
            row["trace"] = traceback.format_exc()[-2000:]
            env, seed = None, seed + NEXT_SEED
        yield {**row, "attempts": attempts[0], "seconds": round(time.perf_counter() - began, 2)}
    if env is not None:
        env.close()


def main() -> None:
    jobs = json.loads(Path(sys.argv[2]).read_text(encoding="utf-8"))
    kitchens = registered(sys.argv[1])
    attempts = count_attempts()
    for job in jobs:
        for row in run(job, kitchens, attempts):
            print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
