"""Measure how fast a scene loads and steps on this machine."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import mujoco

from casa_assets.checks.motion.simulation import reset_to_start
from casa_assets.checks.readers.mujoco_load import native_warnings
from casa_assets.errors import CasaError

STEPS = 200


def in_a_fresh_process(scene_xml: Path) -> tuple[float, float, float]:
    """Seconds to compile a file, steps per second and seconds per step, where nothing of it was compiled before.

    MuJoCo keeps what it has made of meshes and pictures for as long as a process lives, so that a second load tells
    little of the first.

    Raises:
        CasaError: the process ended with an error, as where the file does not load.
    """
    # Not by multiprocessing, whose children first import the program that they were started from, for seconds.
    command = [sys.executable, "-m", __name__, str(scene_xml)]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    if done.returncode:
        raise CasaError(f"{scene_xml}: it cannot be timed: {done.stderr.strip()[-400:]}")
    load_s, steps_per_s, timestep_s = json.loads(done.stdout.splitlines()[-1])
    return float(load_s), float(steps_per_s), float(timestep_s)


def timed(scene_xml: Path) -> tuple[float, float, float]:
    """Loading and stepping time in this process, from the key `start`; the first step allocates and is not timed.

    Seconds of the clock, or of the processor where these are fewer: on a busy machine the clock goes on while this
    process waits for its turn, and a scene is no slower for it.
    """
    begin = _now()
    model = mujoco.MjModel.from_xml_path(str(scene_xml))
    load_s = _since(begin)
    data = mujoco.MjData(model)
    reset_to_start(model, data)
    mujoco.mj_step(model, data)
    begin = _now()
    mujoco.mj_step(model, data, nstep=STEPS)
    return load_s, STEPS / max(_since(begin), 1e-9), float(model.opt.timestep)


def _now() -> tuple[float, float]:
    """Seconds of the clock, and of the processor in all threads of this process."""
    return time.perf_counter(), time.process_time()


def _since(begin: tuple[float, float]) -> float:
    """The fewer of the seconds of clock and processor since then."""
    return min(now - then for now, then in zip(_now(), begin, strict=True))


if __name__ == "__main__":
    with native_warnings():
        times = timed(Path(sys.argv[1]))
    sys.stdout.write(json.dumps(times))
