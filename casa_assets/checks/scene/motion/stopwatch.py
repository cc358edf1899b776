"""Measure how fast a scene loads and steps on this machine."""

from __future__ import annotations

import time
from pathlib import Path

import mujoco

from casa_assets.checks.motion.simulation import reset_to_start
from casa_assets.errors import CasaError

STEPS = 200


def time_loading_and_stepping(scene_xml: Path) -> tuple[float, float, float]:
    """Seconds to compile a file where nothing of it was compiled before, steps per second and seconds per step.

    Steps are taken from the key `start`; the first one allocates and is not timed. Seconds are those of the clock, or
    of the processor where these are fewer: on a busy machine the clock goes on while this process waits for its turn,
    and a scene is no slower for it.

    Raises:
        CasaError: the file does not load.
    """
    # MuJoCo keeps what it has made of meshes and pictures for as long as a process lives, so that a second load tells
    # little of the first.
    mujoco.mj_clearCache(mujoco.mj_getCache())
    begin = _now()
    try:
        model = mujoco.MjModel.from_xml_path(str(scene_xml))
    except ValueError as error:
        raise CasaError(f"{scene_xml}: it cannot be timed: {error}") from error
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
