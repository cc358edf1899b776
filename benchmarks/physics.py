"""Sizes and pace of a kitchen in its three forms, full, light and batch, in one run.

    ./dev bench physics
    ./dev bench physics -- u_large__rustic l_small__coastal --seconds 4

For each form: primitives that touch, pairs that an engine looks at, degrees of freedom, contacts and constraint rows at
rest with everything awake and with sleep, and how many seconds one core simulates in a second, awake and with sleep.
"""

from __future__ import annotations

import argparse
import time

import mujoco

import casa_assets as casa
from casa_assets.checks.motion.simulation import reset_to_start
from casa_assets.checks.scene.batch.size import candidate_pairs

FORMS = ("full", "light", "batch")
DEFAULT = ("one_wall_small__coastal", "l_small__modern_1", "u_large__rustic")
SETTLE_S = 0.5
HEADS = (
    "kitchen",
    "form",
    "colliders",
    "pairs",
    "nv",
    "contacts",
    "rows",
    "x real time",
    "rows asleep",
    "x real time asleep",
)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", default=DEFAULT, help="ids of kitchens")
    parser.add_argument("--seconds", type=float, default=4.0, help="simulated for each number")
    arguments = parser.parse_args()
    print(f"| {' | '.join(HEADS)} |\n|{'---|' * len(HEADS)}")
    for scene in arguments.scenes:
        for form in FORMS:
            print(f"| {scene} | {form} | {' | '.join(measured(scene, form, arguments.seconds))} |", flush=True)


def measured(scene: str, form: casa.Weight, seconds: float) -> list[str]:
    """A row of the table."""
    model = casa.load_scene(scene, weight=form)
    colliders = int(((model.geom_contype | model.geom_conaffinity) != 0).sum())
    awake, asleep = (paced(model, sleep, seconds) for sleep in (False, True))
    sizes = (colliders, int(candidate_pairs(model).sum()), int(model.nv))
    return [f"{number:,}" for number in (*sizes, *awake[:2])] + [
        f"{awake[2]:.1f}",
        f"{asleep[1]:,}",
        f"{asleep[2]:.0f}",
    ]


def paced(model: mujoco.MjModel, sleep: bool, seconds: float) -> tuple[int, int, float]:
    """Contacts and constraint rows at rest, and simulated seconds per second."""
    flag = int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    saved = int(model.opt.enableflags)
    model.opt.enableflags = saved | flag if sleep else saved & ~flag
    data = mujoco.MjData(model)
    reset_to_start(model, data)
    mujoco.mj_step(model, data, nstep=round(SETTLE_S / model.opt.timestep))
    begin = time.perf_counter()
    mujoco.mj_step(model, data, nstep=round(seconds / model.opt.timestep))
    pace = seconds / (time.perf_counter() - begin)
    model.opt.enableflags = saved
    return int(data.ncon), int(data.nefc), pace


if __name__ == "__main__":
    main()
