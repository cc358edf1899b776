"""Convex decomposition by CoACD or V-HACD, in a child process."""

from __future__ import annotations

import io
import json
import os
import resource
import subprocess
import sys
from dataclasses import asdict, dataclass

import numpy as np

from casa_assets.core.numeric import Floats, Ints
from casa_assets.core.system import lower_limit


@dataclass(frozen=True)
class Budget:
    """Limits of a decomposition.

    `hulls`: most hulls. `hull_vertices`: most vertices of each. `voxels`: cubes that V-HACD works on. `threshold`:
    CoACD's concavity threshold, 0..1 of the longest side. `cpu_s`: CPU seconds (not wall: a busy machine must not
    change the outcome). `memory_bytes`: address space.
    """

    hulls: int
    hull_vertices: int = 64
    threshold: float = 0.05
    voxels: int = 400_000
    cpu_s: int = 20
    memory_bytes: int = 6_000_000_000


class DecompositionFailed(Exception):
    """The child died or ran out of its budget; says how."""


def decompose(method: str, vertices: Floats, faces: Ints, budget: Budget) -> list[Floats]:
    """Vertices of each hull, metres, by `coacd` (of a closed manifold) or `vhacd`. Raises DecompositionFailed: why."""
    if not len(faces) or not np.isfinite(vertices).all() or not np.ptp(vertices, axis=0).max() > 0:
        raise DecompositionFailed(f"{method} was not tried: the mesh has no extent, or coordinates that are no numbers")
    lowest, extent = vertices.min(axis=0), float(np.ptp(vertices, axis=0).max())
    stream = io.BytesIO()
    np.savez(stream, vertices=(vertices - lowest) / extent, faces=faces, budget=np.array(json.dumps(asdict(budget))))
    command = [sys.executable, "-m", "casa_assets.ingest.collision.decompose", method]
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONHASHSEED": "0"}
    # No limit by the clock: a busy machine would change the outcome. The worker pool ends what hangs.
    process = subprocess.run(command, input=stream.getvalue(), capture_output=True, env=environment, check=False)
    if process.returncode != 0:
        last_line = process.stderr.decode("utf-8", "replace").strip().splitlines()[-1:] or ["no words"]
        raise DecompositionFailed(f"{method} ended with {process.returncode}: {last_line[0][:200]}")
    with np.load(io.BytesIO(process.stdout)) as hulls:
        clouds = [hulls[f"arr_{i}"] * extent + lowest for i in range(len(hulls.files))]
    return [cloud for cloud in clouds if np.isfinite(cloud).all()]


def _coacd(vertices: Floats, faces: Ints, budget: Budget) -> list[Floats]:
    import coacd

    coacd.set_log_level("off")
    # Its search is kept short: with the defaults a dish rack of wires takes minutes, and is not kept open then either.
    parts = coacd.run_coacd(
        coacd.Mesh(vertices, faces.astype(np.int32)),
        threshold=min(max(budget.threshold, 0.01), 0.5),
        max_convex_hull=budget.hulls,
        preprocess_mode="off",
        mcts_nodes=10,
        mcts_iterations=20,
        mcts_max_depth=2,
        decimate=True,
        max_ch_vertex=budget.hull_vertices,
        seed=0,
    )
    return [np.asarray(points, dtype=np.float64) for points, _ in parts]


def _vhacd(vertices: Floats, faces: Ints, budget: Budget) -> list[Floats]:
    import vhacdx

    parts = vhacdx.compute_vhacd(
        vertices,
        faces.astype(np.uint32),
        maxConvexHulls=budget.hulls,
        resolution=budget.voxels,
        maxNumVerticesPerCH=budget.hull_vertices,
        minimumVolumePercentErrorAllowed=1.0,
        asyncACD=False,
    )
    return [np.asarray(points, dtype=np.float64) for points, _ in parts]


def main() -> int:
    """The child: limits itself, reads, decomposes, writes."""
    with np.load(io.BytesIO(sys.stdin.buffer.read())) as data:
        vertices, faces = data["vertices"], data["faces"]
        budget = Budget(**json.loads(str(data["budget"])))
    lower_limit(resource.RLIMIT_CPU, budget.cpu_s, budget.cpu_s + 5)
    lower_limit(resource.RLIMIT_AS, budget.memory_bytes, budget.memory_bytes)
    # The libraries print to standard output, so that is sent to standard error and the pipe is kept for the answer.
    answer = os.dup(1)
    os.dup2(2, 1)
    hulls = {"coacd": _coacd, "vhacd": _vhacd}[sys.argv[1]](vertices, faces, budget)
    packed = io.BytesIO()
    np.savez(packed, *hulls)
    with os.fdopen(answer, "wb") as out:
        out.write(packed.getvalue())
    return 0


if __name__ == "__main__":
    sys.exit(main())
