"""Choose where jobs run: in processes of this machine, or on a Ray cluster."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, Self

from casa_assets.pipeline.optional_packages import require
from casa_assets.pipeline.workers import memory
from casa_assets.pipeline.workers.limits import Limits
from casa_assets.pipeline.workers.pool import Pool


@dataclass(frozen=True)
class RayCluster:
    """A Ray cluster that jobs run on.

    Attributes:
        address: of a cluster that is running, as `ray.init` takes it: `auto` or `host:6379`; empty: Ray is started on
            this machine, and ended with the run.
        most: jobs at once; 0: as many as the processors and the memory of the cluster allow.
    """

    address: str = ""
    most: int = 0


# Jobs that wait on a cluster beside those that run, as a part of them: no processor waits for the leading process.
WAITING_SHARE = 0.125


def waiting_jobs(workers: int) -> int:
    """How many jobs a cluster of so many workers is given beside those that run."""
    return math.ceil(WAITING_SHARE * workers)


# Where jobs run: so many processes of this machine at once (0: one per core), or a cluster.
Workers = int | RayCluster


class Engine(Protocol):
    """Runs jobs of one run, each in a process of its own with limits; a context manager."""

    def __enter__(self) -> Self:
        """Nothing is started before the first job."""

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """No process of the run is left."""

    def prepare(self, warm: str) -> None:
        """Have one more function called before the next job, as `Pool.prepare`."""

    def run(
        self, function: str, jobs: Sequence[Any], started: Callable[[int], None] | None = None
    ) -> Iterator[tuple[int, Any]]:
        """Yield (number of the job, answer or WorkerFailure) as they finish, as `Pool.run`."""


def open_engine(
    workers: Workers, limits: Limits, warm: str, shared: Path, least_bytes: int = memory.LEAST_WORKER_BYTES
) -> Engine:
    """The engine of a run.

    Args:
        limits: of each job. warm: see Pool. least_bytes: memory that a job needs at least.
        shared: folder for files of the run alone; every machine of a cluster must see it under the same path.
    Raises:
        CasaError: Ray is wanted and not installed.
    """
    if not isinstance(workers, RayCluster):
        return Pool(workers, limits, warm, least_bytes)
    require("ray", "ray", "--engine ray")
    from casa_assets.pipeline.workers.cluster.ray_engine import RayEngine

    return RayEngine(workers, limits, warm, shared, least_bytes)
