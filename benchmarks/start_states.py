"""Seconds to draw and to check start states, size of their file, and microseconds of a reset.

    ./dev bench start_states [--scene l_small__coastal__o40] [--count 10] [--out out/bench]

All is of one process, by its processor time:

draw:     seconds for each state that is drawn, those that are given up included
check:    seconds for each state that is simulated anew
kB:       of the file
reset:    microseconds of `StartStates.reset`
copy:     microseconds of `data.qpos[:] = row`, which is what a reset cannot be faster than
forward:  microseconds of `mj_forward`, which gives poses and contacts

The scene is built first where it is missing. Writes start_states.json and .md into the folder of results.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np

import casa_assets as casa
from casa_assets.checks.start_states.draw import StateRequest
from casa_assets.pipeline.kitchens.recipe import recipes_named
from casa_assets.pipeline.kitchens.scene_folders import build_one
from casa_assets.pipeline.kitchens.start_states import draw_now, verdict

REPEATS = 2000
HEADS = ("scene", "states", "given up", "draw s", "check s", "kB", "reset us", "copy us", "forward us")


def main() -> int:
    """Measure, print, and write down."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", action="append", help="id; may be given again")
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--out", type=Path, default=Path("out/bench"))
    given = parser.parse_args()
    rows = [measured(name, given.count, given.out) for name in given.scene or ["l_small__coastal__o40"]]
    lines = [f"| {' | '.join(HEADS)} |", f"|{'---|' * len(HEADS)}"]
    lines += [f"| {' | '.join(str(row[head]) for head in HEADS)} |" for row in rows]
    (given.out / "start_states.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (given.out / "start_states.json").write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    print("\n".join(lines))
    return 0


def measured(name: str, count: int, out: Path) -> dict[str, object]:
    """A row of the table."""
    scenes = out / "start_states"
    (recipe,) = recipes_named([name], scenes)
    print(f"building {name}", file=sys.stderr)
    built = build_one(recipe, scenes, drawn=False)
    assert built.folder, built.message
    folder = Path(built.folder)
    begin = time.process_time()
    states, stage = draw_now(recipe, folder, StateRequest(count=count))
    drawn = time.process_time()
    report = verdict(states, stage)
    checked = time.process_time()
    assert report.passed, report.issues
    kitchen = casa.Kitchen(folder)
    model = kitchen.to_mjmodel()
    data, fitted = mujoco.MjData(model), kitchen.start_states(model)
    row, number = np.array(fitted.qpos[0]), iter(range(10**9))
    return {
        "scene": name,
        "states": len(states),
        "given up": sum(states.refused.values()),
        "draw s": round((drawn - begin) / count, 2),
        "check s": round((checked - drawn) / count, 2),
        "kB": round((folder / "start_states.npz").stat().st_size / 1000, 1),
        "reset us": each(lambda: fitted.reset(data, next(number) % len(fitted))),
        "copy us": each(lambda: data.qpos.__setitem__(slice(None), row)),
        "forward us": each(lambda: mujoco.mj_forward(model, data)),
    }


def each(work: Callable[[], None]) -> float:
    """Microseconds of processor time of one call."""
    begin = time.process_time()
    for _ in range(REPEATS):
        work()
    return round((time.process_time() - begin) / REPEATS * 1e6, 1)


if __name__ == "__main__":
    sys.exit(main())
