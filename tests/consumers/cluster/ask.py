"""Ask a cluster to do jobs of tests/pool_jobs.py, and print what it answers, as JSON.

    python ask.py 127.0.0.1:6379 '[["answer", "word"], ["abort", ""]]'

An answer is what the job returned, or `{"reason": ..., "message": ...}`; `{"error": ...}` alone: the run ended.
"""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path

from casa_assets.errors import CasaError
from casa_assets.pipeline.workers.cluster.ray_engine import RayEngine
from casa_assets.pipeline.workers.engine import RayCluster
from casa_assets.pipeline.workers.limits import Limits, WorkerFailure

LIMITS = Limits(cpu_s=20, memory_bytes=1_000_000_000)

if __name__ == "__main__":
    address, jobs = sys.argv[1], [tuple(job) for job in json.loads(sys.argv[2])]
    with tempfile.TemporaryDirectory() as shared:
        engine = RayEngine(RayCluster(address), LIMITS, "tests.pool_jobs:nothing", Path(shared), 1_000_000)
        found: dict[int, object] = {}
        try:
            with engine:
                for number, answer in engine.run("tests.pool_jobs:do", jobs):
                    is_failure = isinstance(answer, WorkerFailure)
                    found[number] = {"reason": answer.reason, "message": answer.message} if is_failure else answer
        except CasaError as error:
            print(json.dumps({"error": str(error)}))
        else:
            print(json.dumps([found[number] for number in range(len(jobs))]))
