"""What a kitchen costs MuJoCo in its three forms, beside kitchens of scene_synthesizer 1.15.0 in the same run.

    ./dev bench physics                                      three of ours, and the peer's six templates
    ./dev bench physics u_large__rustic --no-peer

For each form (full, light, batch): primitives and meshes that touch, pairs of them that could meet (candidate pairs, as
mujoco_warp counts them), degrees of freedom, contacts and constraint rows at rest; then times real time of one core
with ten boxes and balls dropped in: everything awake, at work (MuJoCo 4's sleep, while two doors and one thing are
pushed), and everything at rest asleep; then that of all cores together, which `mujoco.rollout` steps from the start
state with sleep, in chunks of a second. Writes out/bench/physics.json, and prints the table.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
import time
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np
from mujoco import rollout

import casa_assets as casa
from benchmarks.kitchens import OUT, SHAPES, TOOLS, machine, peer_python, run
from benchmarks.rooms import measure
from casa_assets.checks.scene.light_forms import candidate_pairs

FORMS: tuple[casa.Detail, ...] = ("full", "light", "batch")
DEFAULT = ("one_wall_small__coastal", "l_small__modern_1", "u_large__rustic")
DROPPED = 10
# Kitchens that `mujoco.rollout` steps for each core, and for how long at a time.
ROLLED_PER_CORE, ROLLED_S = 4, 1.0
# Column -> how its numbers are written.
COLUMNS = {
    "colliders": "{:,}",
    "pairs": "{:,}",
    "nv": "{}",
    "contacts": "{}",
    "rows": "{}",
    "awake": "{:.1f}",
    "at work": "{:.0f}",
    "asleep": "{:.0f}",
    "all cores": "{:.0f}",
}

Row = dict[str, Any]


def main() -> None:
    """Measure, print, and write down."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=DEFAULT, help="ids of ours")
    parser.add_argument("--no-peer", action="store_true")
    options = parser.parse_args()
    print(f"{machine()}, MuJoCo {mujoco.__version__}; times real time with {DROPPED} things dropped in\n")
    print(f"| kitchen | {' | '.join(COLUMNS)} |\n|{'---|' * (len(COLUMNS) + 1)}")
    rows: list[Row] = []
    for row in _measured(options.scenes, not options.no_peer):
        rows.append(row)
        cells = [form.format(row[column]) for column, form in COLUMNS.items()]
        print(f"| {row['kitchen']} | {' | '.join(cells)} |", flush=True)
    OUT.mkdir(parents=True, exist_ok=True)
    text = json.dumps({"machine": machine(), "rows": rows}, indent=1)
    (OUT / "physics.json").write_text(text + "\n", encoding="utf-8")


def _measured(scenes: list[str], with_peer: bool) -> Iterator[Row]:
    for scene in scenes:
        for form in FORMS:
            yield measured(f"{scene}, {form}", casa.kitchen(scene, detail=form).to_mjspec())
    for template in SHAPES if with_peer else ():
        with tempfile.TemporaryDirectory() as folder:
            run([peer_python(), TOOLS / "peer.py", f"kitchen_{template}", "0", folder])
            yield measured(f"peer {template}", mujoco.MjSpec.from_file(f"{folder}/kitchen.urdf"))


def measured(name: str, spec: mujoco.MjSpec) -> Row:
    """A row of the table."""
    model = spec.compile()
    model.opt.timestep = measure.STEP_S
    sleep = int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    model.opt.enableflags &= ~sleep
    first = measure.start(model)
    colliders = int(((model.geom_contype | model.geom_conaffinity) != 0).sum())
    row: Row = {"kitchen": name, "colliders": colliders, "pairs": int(candidate_pairs(model).sum()), "nv": model.nv}
    data = measure.start(model)
    mujoco.mj_step(model, data, nstep=measure.SETTLE_STEPS)
    row |= {"contacts": int(data.ncon), "rows": int(data.nefc)}
    model.opt.enableflags |= sleep
    row["all cores"] = _rolled(model, first)
    loose, _ = measure.with_loose(spec, model, first, DROPPED, bare=False)
    for column, asleep, push in (("awake", False, None), ("at work", True, measure.stir), ("asleep", True, None)):
        row[column] = measure.pace(loose, model, first, asleep, push)["real_time"]
    return row


def _rolled(model: mujoco.MjModel, first: mujoco.MjData) -> float:
    """Seconds that all cores together simulate in a second, of a chunk that comes after one in which things settle."""
    cores = os.cpu_count() or 1
    threads = [mujoco.MjData(model) for _ in range(cores)]
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.empty(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, first, state, kind)
    states = np.tile(state, (ROLLED_PER_CORE * cores, 1))
    steps = round(ROLLED_S / measure.STEP_S)
    states = rollout.rollout(model, threads, states, nstep=steps)[0][:, -1]
    begin = time.perf_counter()
    rollout.rollout(model, threads, states, nstep=steps)
    return len(states) * steps * measure.STEP_S / (time.perf_counter() - begin)


if __name__ == "__main__":
    main()
