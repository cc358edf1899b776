"""Reads a kitchen's USD with Newton, steps it on the CPU, and prints what came of it as one JSON object.

    python newton_kitchen.py scene.usda STEPS

Runs in Newton's own environment.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import newton
import numpy as np
import warp

DT_S = 0.002


def main() -> None:
    """Read, step, tell."""
    warp.config.quiet = True
    builder = newton.ModelBuilder()
    read = builder.add_usd(sys.argv[1])
    model = builder.finalize(device="cpu")
    kinds = [newton.JointType(int(kind)).name for kind in model.joint_type.numpy()]
    labels = {int(number): path for path, number in read["path_joint_map"].items()}
    begun, ended = model.state(), model.state()
    newton.eval_fk(model, model.joint_q, model.joint_qd, begun)
    placed = begun.body_q.numpy().copy()
    solver = newton.solvers.SolverMuJoCo(model, use_mujoco_cpu=True)
    control = model.control()
    for _ in range(int(sys.argv[2])):
        begun.clear_forces()
        solver.step(begun, ended, control, None, DT_S)
        begun, ended = ended, begun
    stood = begun.body_q.numpy()
    went = np.linalg.norm(stood[:, :3] - placed[:, :3], axis=1)
    names = {int(number): path for path, number in read["path_body_map"].items()}
    found: dict[str, Any] = {
        "newton": newton.__version__,
        "bodies": {path: [float(v) for v in placed[number]] for number, path in names.items()},
        "masses": {path: float(model.body_mass.numpy()[number]) for number, path in names.items()},
        "joints": {labels[i]: kind for i, kind in enumerate(kinds) if i in labels},
        "kinds": {kind: kinds.count(kind) for kind in sorted(set(kinds))},
        "shapes": int(model.shape_count),
        "finite": bool(np.isfinite(stood).all() and np.isfinite(begun.joint_q.numpy()).all()),
        "farthest": [str(names.get(int(went.argmax()))), float(went.max())],
        "fastest": float(np.abs(begun.joint_qd.numpy()).max()),
    }
    print(json.dumps(found))


if __name__ == "__main__":
    main()
