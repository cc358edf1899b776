"""CoACD with the defaults of obj2mjcf 0.0.25, in a process that can be stopped.

Ref: obj2mjcf 0.0.25, cli.py, CoacdArgs: every number below is its default, and so is what it leaves to CoACD.
"""

from __future__ import annotations

import io
import os
import resource
import subprocess
import sys

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

DEFAULTS = {
    "preprocess_resolution": 50,
    "threshold": 0.05,
    "max_convex_hull": -1,
    "mcts_iterations": 100,
    "mcts_max_depth": 3,
    "mcts_nodes": 20,
    "resolution": 2000,
    "pca": False,
    "seed": 0,
}


def run(points: Floats, faces: Ints, cpu_s: int) -> tuple[list[Floats], str]:
    """Vertices of each hull, and empty words; or no hull, and why. One thread, `cpu_s` CPU seconds at most."""
    packed = io.BytesIO()
    np.savez(packed, points=points, faces=faces, cpu=np.array(cpu_s))
    command = [sys.executable, "-c", "from benchmarks.ingest.peer_coacd import main; main()"]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, input=packed.getvalue(), capture_output=True, env=environment, check=False)
    if done.returncode:
        died = {-24: f"still running after {cpu_s} CPU seconds", -6: "aborted", -11: "segmentation fault"}
        return [], died.get(done.returncode, f"exit code {done.returncode}")
    with np.load(io.BytesIO(done.stdout)) as hulls:
        return [hulls[f"arr_{i}"] for i in range(len(hulls.files))], ""


def main() -> None:
    """The child."""
    import coacd

    with np.load(io.BytesIO(sys.stdin.buffer.read())) as data:
        points, faces, cpu = data["points"], data["faces"], int(data["cpu"])
    resource.setrlimit(resource.RLIMIT_CPU, (cpu, cpu + 5))
    answer = os.dup(1)
    os.dup2(2, 1)
    coacd.set_log_level("off")
    parts = coacd.run_coacd(coacd.Mesh(points, faces.astype(np.int32)), **DEFAULTS)
    packed = io.BytesIO()
    np.savez(packed, *(np.asarray(p, dtype=np.float64) for p, _ in parts))
    with os.fdopen(answer, "wb") as out:
        out.write(packed.getvalue())
