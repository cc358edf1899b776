"""Ask a cluster to do jobs of tests/support/program/pool_jobs.py, and print what it answers, as JSON.

    python ask.py 127.0.0.1:6379 '[["answer", "word"], ["abort", ""]]' [--lose-ray]

With --lose-ray the process of Ray that this one is connected to is killed after a while. An answer is what the job
returned, or `{"reason": ..., "message": ...}`; `{"error": ...}` alone: the run ended.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import tempfile
import threading
import time
from contextlib import suppress
from pathlib import Path

import ray

from casa_assets.errors import CasaError
from casa_assets.runs.limits import Limits, WorkerFailure
from casa_assets.runs.pool import RayCluster
from casa_assets.runs.ray_engine import RayEngine

LIMITS = Limits(cpu_s=20, memory_bytes=1_000_000_000)


def lose_ray() -> None:
    """Kill the process of Ray that this one is connected to, once it is connected and at work."""
    while not ray.is_initialized():
        time.sleep(0.1)
    time.sleep(3.0)
    own = ray.get_runtime_context().get_node_id()
    (socket,) = (one["RayletSocketName"] for one in ray.nodes() if one["NodeID"] == own)
    for place in Path("/proc").glob("[0-9]*/cmdline"):
        with suppress(OSError):
            words = place.read_bytes().decode(errors="replace")
            if f"--raylet_socket_name={socket}\0" in words and "raylet/raylet" in words:
                os.kill(int(place.parent.name), signal.SIGKILL)


if __name__ == "__main__":
    if "--lose-ray" in sys.argv:
        threading.Thread(target=lose_ray, daemon=True).start()
    address, jobs = sys.argv[1], [tuple(job) for job in json.loads(sys.argv[2])]
    with tempfile.TemporaryDirectory() as shared:
        engine = RayEngine(
            RayCluster(address), LIMITS, "tests.support.program.pool_jobs:nothing", Path(shared), 1_000_000
        )
        found: dict[int, object] = {}
        try:
            with engine:
                for number, answer in engine.run("tests.support.program.pool_jobs:do", jobs):
                    is_failure = isinstance(answer, WorkerFailure)
                    found[number] = {"reason": answer.reason, "message": answer.message} if is_failure else answer
        except CasaError as error:
            print(json.dumps({"error": str(error)}))
        else:
            print(json.dumps([found[number] for number in range(len(jobs))]))
