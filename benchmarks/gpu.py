"""Steps per second of kitchens in mujoco_warp on an NVIDIA GPU, beside another scene in the same run.

    ./dev bench gpu
    ./dev bench gpu --peer mujoco_warp/benchmarks/kitchen/kitchen.xml --worlds 1 4096

Rows: one kitchen, sixteen side by side (`casa.batch`), and the scene named by `--peer`, such as DeepMind's kitchen out
of the benchmarks of mujoco_warp's repository. In each world of ours a stand-in of a robot moves and a drawer is pulled,
so that not everything sleeps. Without an NVIDIA GPU it says so and measures nothing, unless `--device cpu` asks for it.
"""

from __future__ import annotations

import argparse
import sys
import sysconfig
import time
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import casa_assets as casa

WORLDS = (1, 256, 1024, 4096)
PLANS = ("galley", "l_small", "u_small", "one_wall_small")
STYLES = ("coastal", "rustic", "modern_1", "scandinavian")
KITCHENS = [f"{plan}__{style}" for plan in PLANS for style in STYLES]
HEADS = ("scene", "worlds", "steps/s", "contacts per world", "GPU memory, MB")
WARM_UP, PULL_N, SWING_NM = 20, 20.0, 10.0
# A base that drives, and an arm.
ROBOT = """<mujoco><worldbody><body name="base" pos="0 0 0.2">
  <joint name="x" type="slide" axis="1 0 0" damping="60"/><joint name="yaw" type="hinge" axis="0 0 1" damping="60"/>
  <geom type="box" size="0.22 0.18 0.15" mass="40"/>
  <body pos="0.1 0 0.5"><joint name="lift" type="hinge" axis="0 1 0" damping="3"/>
    <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03" mass="1"/>
    <body pos="0.33 0 0"><joint name="elbow" type="hinge" axis="0 1 0" damping="3"/>
      <geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.03" mass="1"/></body></body></body></worldbody>
  <actuator><motor joint="x" gear="4"/><motor joint="yaw"/><motor joint="lift"/><motor joint="elbow"/></actuator>
</mujoco>"""


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--worlds", type=int, nargs="+", default=WORLDS, help="numbers of worlds")
    parser.add_argument("--steps", type=int, default=500, help="that are timed")
    parser.add_argument("--peer", type=Path, help="MJCF of a scene to compare with")
    parser.add_argument("--device", default="cuda:0", help="as warp names it")
    parser.add_argument("--packages", type=Path, help="folder that mujoco_warp is installed in, such as .venv-engines'")
    arguments = parser.parse_args()
    own = Path(".venv-engines/lib") / f"python{sysconfig.get_python_version()}" / "site-packages"
    sys.path.append(str(arguments.packages or own))
    import warp as wp

    wp.config.quiet = True
    wp.init()
    if arguments.device != "cpu" and not wp.is_cuda_available():
        print("not measured: there is no NVIDIA GPU here")
        return
    print(f"{wp.get_device(arguments.device).name}\n\n| {' | '.join(HEADS)} |\n|{'---|' * len(HEADS)}")
    with wp.ScopedDevice(arguments.device):
        for worlds in arguments.worlds:
            for name, kitchens in (("one kitchen", KITCHENS[:1]), ("16 kitchens side by side", KITCHENS)):
                if worlds >= len(kitchens):
                    row(name, worlds, ours(kitchens, worlds, arguments.device), arguments.steps)
            if arguments.peer:
                row(arguments.peer.stem, worlds, peer(arguments.peer, worlds), arguments.steps)


def row(name: str, worlds: int, stepped: Any, steps: int) -> None:
    """Print what a scene does; `stepped` steps it and gives mujoco_warp's Data."""
    import warp as wp

    data = stepped(WARM_UP)
    wp.synchronize()
    begin = time.perf_counter()
    stepped(steps)
    wp.synchronize()
    pace = worlds * steps / (time.perf_counter() - begin)
    device = wp.get_device()
    memory = f"{wp.get_mempool_used_mem_current(device) / 1e6:,.0f}" if device.is_cuda else "-"
    print(f"| {name} | {worlds:,} | {pace:,.0f} | {data.nacon.numpy()[0] / worlds:.1f} | {memory} |", flush=True)


def ours(kitchens: list[str], worlds: int, device: str) -> Any:
    """Steps kitchens in which a robot moves and a drawer is pulled."""
    batch = casa.batch(kitchens, worlds=worlds, robot=mujoco.MjSpec.from_string(ROBOT), device=device)
    forces = np.zeros((worlds, batch.kitchens[0].model.nv), dtype=np.float32)
    for number, kitchen in enumerate(batch.kitchens):
        model = kitchen.model
        slides = [joint for joint in kitchen.joints.values() if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE]
        far = max(slides, key=lambda joint: float(np.abs(model.jnt_range[joint]).max()))
        forces[number :: len(kitchens), model.jnt_dofadr[far]] = PULL_N * np.sign(model.jnt_range[far].sum())
    batch.engine.data.qfrc_applied.assign(forces)
    batch.engine.data.ctrl.fill_(SWING_NM)

    def step(count: int) -> Any:
        batch.step(count)
        return batch.engine.data

    return step


def peer(file: Path, worlds: int) -> Any:
    """Steps another scene as it begins, with room for twice the contacts that it has then."""
    import mujoco_warp as mjw
    import warp as wp

    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    put = mjw.put_model(model)
    many = mjw.put_data(model, data, nworld=worlds, nconmax=2 * data.ncon + 64, njmax=2 * data.nefc + 256)
    graph: Any = None
    if wp.get_device().is_cuda:
        mjw.step(put, many)
        with wp.ScopedCapture() as capture:
            mjw.step(put, many)
        graph = capture.graph

    def step(count: int) -> Any:
        for _ in range(count):
            if graph is None:
                mjw.step(put, many)
            else:
                wp.capture_launch(graph)
        return many

    return step


if __name__ == "__main__":
    main()
