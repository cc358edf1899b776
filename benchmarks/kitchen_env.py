"""Steps per second of the environment in `examples/kitchen_env.py`, beside bare `mj_step` on the same model.

    ./dev bench kitchen_env [--plan l_small] [--style coastal] [--seconds 3] [--out out/bench]

One row for each form of the kitchen (full, light), with everything awake and with MuJoCo's sleep. All columns are of
one process, by its processor time, after half a second of the simulation in which things settle:

bare:      steps of 2 ms per second by `mj_step` alone, 25 at a time, as `env.step` takes them
env:       the same steps per second through `env.step` with random actions: observation, reward, state machines
pictures:  `env.step` and `env.render` (240 x 320 pixels) per second
reset:     milliseconds of a reset without pictures
repaint:   milliseconds of a reset that changes the pictures of the four surfaces too; full form alone, awake or not
renderer:  milliseconds of what repainting saves: making a renderer anew and drawing once

Says on standard error what it is at. Most of its time goes into pictures where there is no graphics card.
Writes kitchen_env.json and .md into the folder of results, and prints the latter.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
os.environ.setdefault("MUJOCO_GL", "egl")  # no screen is needed; MuJoCo looks at it while it is imported

import mujoco  # noqa: E402

import casa_assets as casa  # noqa: E402
from examples.kitchen_env import START_MICROWAVE, KitchenEnv  # noqa: E402

HEADS = (
    "form",
    "bare steps/s",
    "env steps/s",
    "share",
    "actions/s",
    "pictures/s",
    "reset ms",
    "repaint ms",
    "renderer ms",
)
STEPS_PER_ACTION, SETTLING_ACTIONS, RESETS, REPAINTS = 25, 10, 10, 3
Row = dict[str, float | str | None]


def main() -> int:
    """Measure, print, and write down."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plan", default="l_small")
    parser.add_argument("--style", default="coastal")
    parser.add_argument("--seconds", type=float, default=3.0, help="of each measurement")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "bench")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    forms: tuple[casa.Detail, ...] = ("full", "light")
    rows = [row for detail in forms for row in measure(options.plan, options.style, detail, options.seconds)]
    busy = os.getloadavg()[0]
    machine = f"{platform.machine()}, {os.cpu_count()} cores, load {busy:.1f}, MuJoCo {mujoco.__version__}"
    machine = f"{machine}, {options.plan} in {options.style}"
    text = page(machine, rows)
    result = {"machine": machine, "rows": rows}
    (options.out / "kitchen_env.json").write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    (options.out / "kitchen_env.md").write_text(text, encoding="utf-8")
    print(text)
    return 0


def measure(plan: str, style: str, detail: casa.Detail, seconds: float) -> list[Row]:
    """All columns of one form, with everything awake and with MuJoCo's sleep."""
    task = START_MICROWAVE._replace(plan=plan, style=style)
    say(f"{detail}: building {plan} in {style}")
    env, seeing = KitchenEnv(task, detail), KitchenEnv(task, detail, "rgb_array")
    rows = [
        measured(asleep(env, sleep), asleep(seeing, sleep), f"{detail}{', sleep' if sleep else ''}", seconds)
        for sleep in (False, True)
    ]
    if detail == "full":
        say("full: painting")
        for seed in range(2 * RESETS):  # so that nearly every picture has been painted once
            seeing.reset(seed=seed)
        repaint_ms = 1e3 / per_second(seeing, seeing.reset, 0.0, RESETS)
        say("full: renderers")
        renderer_ms = 1e3 / per_second(seeing, lambda: redraw(seeing), 0.0, REPAINTS)
        rows[0] |= {"repaint_ms": repaint_ms, "renderer_ms": renderer_ms}
    release(seeing)
    return rows


def measured(env: KitchenEnv, seeing: KitchenEnv, form: str, seconds: float) -> Row:
    """The columns that hang on sleep, of one environment without and one with pictures."""
    for one in (env, seeing):
        one.action_space.seed(0)
    say(f"{form}: steps")
    bare = per_second(settled(env), lambda: mujoco.mj_step(env.model, env.data, nstep=STEPS_PER_ACTION), seconds)
    actions = per_second(settled(env), lambda: env.step(env.action_space.sample()), seconds)
    reset_ms = 1e3 / per_second(env, env.reset, 0.0, RESETS)
    say(f"{form}: pictures")
    pictures = per_second(
        settled(seeing), lambda: (seeing.step(seeing.action_space.sample()), seeing.render()), seconds
    )
    return {
        "form": form,
        "bare": STEPS_PER_ACTION * bare,
        "env": STEPS_PER_ACTION * actions,
        "share": actions / bare,
        "actions": actions,
        "pictures": pictures,
        "reset_ms": reset_ms,
        "repaint_ms": None,
        "renderer_ms": None,
    }


def say(words: str) -> None:
    """What is being measured, with the seconds of processor time since the start."""
    print(f"{time.process_time():6.0f} s  {words}", file=sys.stderr, flush=True)


def settled(env: KitchenEnv) -> KitchenEnv:
    """The environment after a reset and half a second in which the fingertip hangs still."""
    env.reset(seed=0)
    for _ in range(SETTLING_ACTIONS):
        env.step(np.zeros(3, np.float32))
    return env


def asleep(env: KitchenEnv, sleep: bool) -> KitchenEnv:
    """The environment, in which what rests is left out of the simulation if so wished."""
    bit = int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    env.model.opt.enableflags = env.model.opt.enableflags | bit if sleep else env.model.opt.enableflags & ~bit
    return env


def release(env: KitchenEnv) -> None:
    """Give the memory of its renderer back."""
    if env.renderer:
        env.renderer.close()


def redraw(env: KitchenEnv) -> None:
    """What has to be done after a change of pictures where they are not uploaded one by one."""
    release(env)
    env.renderer = mujoco.Renderer(env.model, 240, 320)
    env.render()


def per_second(env: KitchenEnv, act: Callable[[], object], seconds: float, least: int = 3) -> float:
    """How often something can be done per second of processor time."""
    count, begin = 0, time.process_time()
    while count < least or time.process_time() - begin < seconds:
        act()
        count += 1
    assert np.isfinite(env.data.qpos).all(), "the simulation came apart"
    return count / (time.process_time() - begin)


def page(machine: str, rows: list[Row]) -> str:
    """The rows as a table."""
    lines = [f"| {' | '.join(HEADS)} |", f"|{'---|' * len(HEADS)}"]
    for row in rows:
        cells = [f"{row['bare']:,.0f}", f"{row['env']:,.0f}", f"{row['share']:.2f}", f"{row['actions']:,.0f}"]
        cells.append(f"{row['pictures']:,.1f}")
        cells += ["" if row[k] is None else f"{row[k]:.0f}" for k in ("reset_ms", "repaint_ms", "renderer_ms")]
        lines.append(f"| {row['form']} | {' | '.join(cells)} |")
    return "\n".join([machine, "", *lines, ""])


if __name__ == "__main__":
    raise SystemExit(main())
