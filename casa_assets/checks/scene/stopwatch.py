"""How fast a scene loads and steps, here and now."""

from __future__ import annotations

import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import mujoco

STEPS = 200
START = "start"


def in_a_fresh_process(scene_xml: Path) -> tuple[float, float, float]:
    """Seconds to compile a file, steps per second and seconds per step, where nothing of it was compiled before.

    MuJoCo keeps what it has made of meshes and pictures for as long as a process lives, so that a second load tells
    little of the first. The file has to load.
    """
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(timed, scene_xml).result()


def timed(scene_xml: Path) -> tuple[float, float, float]:
    """The same in this process; steps are taken from the key `start`, and the first is not timed: it allocates."""
    begin = time.perf_counter()
    model = mujoco.MjModel.from_xml_path(str(scene_xml))
    loaded = time.perf_counter()
    data = mujoco.MjData(model)
    key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, START)
    if key >= 0:
        mujoco.mj_resetDataKeyframe(model, data, key)
    mujoco.mj_step(model, data)
    start = time.perf_counter()
    mujoco.mj_step(model, data, nstep=STEPS)
    seconds = max(time.perf_counter() - start, 1e-9)
    return loaded - begin, STEPS / seconds, float(model.opt.timestep)
