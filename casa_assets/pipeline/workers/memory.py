"""Measure the free memory of this machine and plan how many workers fit into it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

PROC, CGROUPS = Path("/proc"), Path("/sys/fs/cgroup")
# Part of the free memory that is left to the main process, the fork server and other programs; a choice.
RESERVED_SHARE = 0.1
# A worker with less than this fails on common inputs: a mesh of two million faces takes 1.9 GB.
LEAST_WORKER_BYTES = 2_000_000_000


@dataclass(frozen=True)
class WorkerPlan:
    """Number of workers and the memory of each.

    Attributes:
        workers: how many run at once. memory_bytes: limit of each. alone_bytes: limit of one that runs alone.
        message: for the user, where there are fewer workers than were asked for; else empty.
    """

    workers: int
    memory_bytes: int
    alone_bytes: int
    message: str = ""


def plan_workers(
    workers: int, memory_bytes: int, least_bytes: int = LEAST_WORKER_BYTES, free_bytes: int | None = None
) -> WorkerPlan:
    """Choose the number of workers and the memory of each so that all of them fit into what is free.

    First the limit of each is lowered, down to `least_bytes`; then their number.

    Args:
        workers: how many are wanted. memory_bytes: what one job may use. least_bytes: what each needs at least.
        free_bytes: of this machine; None: as it is now.
    """
    free = available() if free_bytes is None else free_bytes
    if free is None:
        return WorkerPlan(workers, memory_bytes, memory_bytes)
    usable = int(free * (1.0 - RESERVED_SHARE))
    alone = max(1, min(memory_bytes, usable))
    least_each = max(1, min(memory_bytes, least_bytes))
    fitting = max(1, min(workers, usable // least_each))
    each = max(1, min(memory_bytes, usable // fitting))
    message = ""
    if fitting < workers:
        message = (
            f"{fitting} instead of {workers} at once (--jobs): {free / 1e9:.3g} GB of memory are free, "
            f"and each may need {least_each / 1e9:.3g} GB"
        )
    return WorkerPlan(fitting, each, alone, message)


def available(proc: Path = PROC, cgroups: Path = CGROUPS) -> int | None:
    """Bytes that new processes may take: of the machine, and within the limits of its control groups.

    None where the system does not say.
    """
    free = [value for value in (_of_machine(proc), *_of_groups(proc, cgroups)) if value is not None]
    return max(0, min(free)) if free else None


def _of_machine(proc: Path) -> int | None:
    with suppress(OSError, ValueError, IndexError):
        for line in (proc / "meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    with suppress(OSError, ValueError):
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return None


def _of_groups(proc: Path, root: Path) -> Iterator[int]:
    """Bytes left within each control group that this process is in, and those around it.

    Ref: https://docs.kernel.org/admin-guide/cgroup-v2.html#memory and cgroup-v1/memory.html. Within a container the
    path of the group may not exist; then its own limits stand at the root.
    """
    with suppress(OSError):
        for line in (proc / "self" / "cgroup").read_text(encoding="utf-8").splitlines():
            number, controllers, path = line.split(":", 2)
            if number == "0":
                yield from _limits_up_the_tree(root, path, ("memory.max", "memory.current", "inactive_file"))
            elif "memory" in controllers.split(","):
                files = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
                yield from _limits_up_the_tree(root / "memory", path, files)


def _limits_up_the_tree(root: Path, path: str, files: tuple[str, str, str]) -> Iterator[int]:
    limit_file, usage_file, cached_key = files
    parts = [p for p in path.split("/") if p not in ("", "..")]
    for depth in range(len(parts), -1, -1):
        folder = root.joinpath(*parts[:depth])
        with suppress(OSError, ValueError):  # no such file, or the word "max": no limit here
            limit = int((folder / limit_file).read_text(encoding="ascii"))
            used = int((folder / usage_file).read_text(encoding="ascii"))
            yield limit - used + _cached(folder, cached_key)


def _cached(folder: Path, key: str) -> int:
    """Bytes of a group that hold copies of files, which the system gives up when memory is wanted."""
    with suppress(OSError, ValueError):
        for line in (folder / "memory.stat").read_text(encoding="ascii").splitlines():
            name, value = line.split()
            if name == key:
                return int(value)
    return 0
