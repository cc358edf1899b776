"""Reads a kitchen's USD with Newton, steps it on the CPU, and prints what came of it as one JSON object.

    python newton_kitchen.py scene_nested.usda STEPS

Runs in Newton's own environment. Two lines are what a user of Newton has to know. Without `register_custom_attributes`
it leaves out what our USD says to MuJoCo's solver. And where a spring (USD's drive, and MuJoCo's own) rests beyond the
range of its joint, as one that keeps an oven shut does, Newton moves the drive's target to the middle of the range and
so opens the oven: the drive has to go, MuJoCo's spring stays.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import newton
import numpy as np
import warp
from pxr import Usd

DT_S = 0.002


def main() -> None:
    warp.config.quiet = True
    builder = newton.ModelBuilder()
    newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
    read = builder.add_usd(sys.argv[1])
    keep_springs_alone(builder, sys.argv[1], read["path_joint_map"])
    model = builder.finalize(device="cpu")
    kinds = [newton.JointType(int(kind)).name for kind in model.joint_type.numpy()]
    labels = {int(number): path for path, number in read["path_joint_map"].items()}
    begun, ended = model.state(), model.state()
    newton.eval_fk(model, model.joint_q, model.joint_qd, begun)
    placed, set_to = begun.body_q.numpy().copy(), begun.joint_q.numpy().copy()
    solver = newton.solvers.SolverMuJoCo(model, use_mujoco_cpu=True)
    control = model.control()
    for _ in range(int(sys.argv[2])):
        begun.clear_forces()
        solver.step(begun, ended, control, None, DT_S)
        begun, ended = ended, begun
    stood = begun.body_q.numpy()
    went = np.linalg.norm(stood[:, :3] - placed[:, :3], axis=1)
    crept = np.abs(begun.joint_q.numpy() - set_to)
    firsts = model.joint_q_start.numpy()
    single = {path: float(crept[firsts[i]]) for i, path in labels.items() if kinds[i] in ("PRISMATIC", "REVOLUTE")}
    names = {int(number): path for path, number in read["path_body_map"].items()}
    found: dict[str, Any] = {
        "newton": newton.__version__,
        "bodies": {path: [float(v) for v in placed[number]] for number, path in names.items()},
        "masses": {path: float(model.body_mass.numpy()[number]) for number, path in names.items()},
        "kinds": {kind: kinds.count(kind) for kind in sorted(set(kinds))},
        "finite": bool(np.isfinite(stood).all() and np.isfinite(begun.joint_q.numpy()).all()),
        "farthest": [str(names.get(int(went.argmax()))), float(went.max())],
        "crept": single,
    }
    print(json.dumps(found))


def keep_springs_alone(builder: newton.ModelBuilder, file: str, joints: dict[str, int]) -> None:
    """Takes away drives of joints that have a spring of MuJoCo's, so that it does not count twice."""
    stage = Usd.Stage.Open(file)
    for path, number in joints.items():
        if stage.GetPrimAtPath(path).HasAttribute("mjc:stiffness"):
            builder.joint_target_ke[builder.joint_qd_start[number]] = 0.0


if __name__ == "__main__":
    main()
