"""Measure how fast a scene loads and steps on this machine.

Seconds are those of the clock, or of the processor where these are fewer: on a busy machine the clock goes on while
this process waits for its turn, and a scene is no slower for it.
"""

from __future__ import annotations

import time
from pathlib import Path

import mujoco

from casa_assets.checks.motion.simulation import reset_to_start
from casa_assets.checks.readers.mujoco_load import Loaded, load_asset_file

STEPS = 200


def timed_load(scene_xml: Path) -> tuple[Loaded, float]:
    """A file compiled where nothing of it was compiled before, and the seconds that this took."""
    # MuJoCo keeps what it has made of meshes and pictures for as long as a process lives, so that a second load tells
    # little of the first.
    mujoco.mj_clearCache(mujoco.mj_getCache())
    begin = _now()
    loaded = load_asset_file(scene_xml)
    return loaded, _since(begin)


def steps_per_second(model: mujoco.MjModel) -> float:
    """Steps from the key `start`; the first one allocates and is not timed."""
    data = mujoco.MjData(model)
    reset_to_start(model, data)
    mujoco.mj_step(model, data)
    begin = _now()
    mujoco.mj_step(model, data, nstep=STEPS)
    return STEPS / max(_since(begin), 1e-9)


def _now() -> tuple[float, float]:
    """Seconds of the clock, and of the processor in all threads of this process."""
    return time.perf_counter(), time.process_time()


def _since(begin: tuple[float, float]) -> float:
    """The fewer of the seconds of clock and processor since then."""
    return min(now - then for now, then in zip(_now(), begin, strict=True))
