"""Limits of one job, its use of resources, and the resources left on this machine: processor time, memory, disk.

Processor time and memory are counted as Linux does, for a process with all that it started. Disk means the space for
temporary files.
"""

from __future__ import annotations

import math
import os
import resource
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter

from casa_assets.core.system import lower_limit
from casa_assets.errors import OutputError

# A process that competes with others still gets some time; one with less than this part of a core hangs. A choice.
IDLE_CPU_SHARE = 0.001
# Seconds of the clock for each processor second of the limit, and at least; a choice: 20 jobs may share a core.
WALL_FACTOR, WALL_LEAST_S = 20.0, 1800.0


@dataclass(frozen=True)
class Limits:
    """Resources that one job may use, with all processes that it starts.

    Attributes:
        cpu_s: processor seconds. Wall time does not count: on a busy machine a job takes longer and ends the same.
        memory_bytes: private memory (its data, not mapped libraries).
        idle_s: a job that uses no processor time for this number of wall seconds hangs, and is ended.
    """

    cpu_s: float
    memory_bytes: int
    idle_s: float = 300.0

    @property
    def wall_s(self) -> float:
        """Seconds of the clock after which a job is given up, however busy the machine is."""
        return max(WALL_FACTOR * self.cpu_s, WALL_LEAST_S)


@dataclass(frozen=True)
class WorkerFailure:
    """A job that did not answer.

    Attributes:
        reason: `timeout` (of processor time), `stuck` (no progress: another run may end otherwise), `memory`, `killed`
            (by the system or a person, twice), `signal` (a crash of native code, twice), `error` (of Python), and
            within the pool `unstarted`.
        message: for a person. trace: of a Python error, or empty.
    """

    reason: str
    message: str
    trace: str = ""

    @property
    def text(self) -> str:
        """The message, and the trace where there is one."""
        return f"{self.message}\n{self.trace}" if self.trace else self.message


def restrict(limits: Limits) -> None:
    """Put the limits on this process, as far as the kernel can hold them; the server holds the rest."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    # A second more than the server allows, which counts all processes of the job: this is for when it cannot.
    lower_limit(resource.RLIMIT_CPU, math.ceil(limits.cpu_s) + 1, math.ceil(limits.cpu_s) + 5)
    # Address space would count what drivers and thread arenas merely reserve, which is much on a machine of many cores.
    lower_limit(resource.RLIMIT_DATA, limits.memory_bytes, limits.memory_bytes)


PROC = Path("/proc")
TICKS_PER_S = os.sysconf("SC_CLK_TCK")
PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")


@dataclass(frozen=True)
class Process:
    """One process, as /proc/<pid>/stat has it.

    Attributes:
        parent, session: numbers of processes. cpu_s: its own time and that of its children that it has waited for.
    """

    pid: int
    parent: int
    session: int
    cpu_s: float


@dataclass(frozen=True)
class Usage:
    """CPU seconds and memory of a process with all that it started.

    Attributes:
        cpu_s: processor seconds so far, of user and system.
        memory_bytes: memory in use that is shared with no file; counted for several processes only, else 0.
    """

    cpu_s: float
    memory_bytes: int = 0


def cpu_seconds() -> float:
    """Processor seconds of this process and of the children that it has waited for, of user and system."""
    return sum(os.times()[:4])


@dataclass
class StepClock:
    """Times the steps of a job, one after the other, from when it is made.

    Attributes:
        wall_s: step -> seconds of the clock. cpu_s: step -> processor seconds, those of ended children among them.
    """

    wall_s: dict[str, float] = field(default_factory=dict)
    cpu_s: dict[str, float] = field(default_factory=dict)
    _at: tuple[float, float] = field(default_factory=lambda: (perf_counter(), cpu_seconds()))

    def end(self, step: str) -> None:
        """End a step; the next one begins."""
        now = perf_counter(), cpu_seconds()
        self.wall_s[step] = now[0] - self._at[0]
        self.cpu_s[step] = round(now[1] - self._at[1], 2)
        self._at = now


def processes() -> Iterator[Process]:
    """Yield every process that this one may see; nothing if there is no /proc. Ref: proc(5), /proc/pid/stat."""
    with suppress(FileNotFoundError):
        for entry in os.scandir(PROC):
            if entry.name.isdigit():
                with suppress(OSError):  # it has just ended
                    text = (PROC / entry.name / "stat").read_text(encoding="utf-8", errors="replace")
                    row = text.rpartition(")")[2].split()
                    ticks = sum(map(int, row[11:15]))
                    yield Process(int(entry.name), int(row[1]), int(row[3]), ticks / TICKS_PER_S)


def trees(roots: Iterable[int]) -> dict[int, list[Process]]:
    """The processes that each root has started, itself among them, by the number of the root.

    A process belongs to the root that it descends from, or whose session it is in: one whose parent has ended is
    found by its session.
    """
    found: dict[int, list[Process]] = {root: [] for root in roots}
    by_pid = {process.pid: process for process in processes()}
    for process in by_pid.values():
        ancestor: Process | None = process
        while ancestor is not None:
            root = ancestor.pid if ancestor.pid in found else ancestor.session if ancestor.session in found else None
            if root is not None:
                found[root].append(process)
                break
            ancestor = by_pid.get(ancestor.parent)
    return found


def usage(roots: Iterable[int]) -> dict[int, Usage]:
    """Usage of each root process with all that it started; a root that has ended is left out."""
    found = {}
    for root, members in trees(roots).items():
        if members:
            memory = sum(_memory(process.pid) for process in members) if len(members) > 1 else 0
            found[root] = Usage(sum(process.cpu_s for process in members), memory)
    return found


def _memory(pid: int) -> int:
    """Bytes of memory that a process has in use and shares with no file; 0 where it has ended."""
    with suppress(OSError, ValueError, IndexError):
        _, resident, shared = map(int, (PROC / str(pid) / "statm").read_text(encoding="ascii").split()[:3])
        return (resident - shared) * PAGE_BYTES
    return 0


CGROUPS = Path("/sys/fs/cgroup")
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
    """Return the bytes that new processes may take, within the limits of the machine and of their control groups.

    None if the system does not say.
    """
    free = list(_of_groups(proc, cgroups))
    kilobytes = _number_in(proc / "meminfo", "MemAvailable:")
    with suppress(OSError, ValueError):
        free.append(os.sysconf("SC_PHYS_PAGES") * PAGE_BYTES if kilobytes is None else 1024 * kilobytes)
    return max(0, min(free)) if free else None


def _number_in(file: Path, key: str) -> int | None:
    """The number behind a key in a file of rows; None if it is not there."""
    with suppress(OSError, ValueError):
        for line in file.read_text(encoding="ascii").splitlines():
            name, value, *_ = line.split()
            if name == key:
                return int(value)
    return None


def _of_groups(proc: Path, root: Path) -> Iterator[int]:
    """Yield the bytes left within each control group that this process is in, and within those around it.

    Ref: https://docs.kernel.org/admin-guide/cgroup-v2.html#memory and cgroup-v1/memory.html. Within a container the
    path of the group may not exist; then the limits of the container are at the root.
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
            # Copies of files are given up by the system when memory is wanted.
            yield limit - used + (_number_in(folder / "memory.stat", cached_key) or 0)


# With less a job cannot count on its temporary files; those of readers and validators are a few megabytes. A choice.
LEAST_FREE_BYTES = 64_000_000


def full_disk() -> OutputError | None:
    """Return an error if the disk for temporary files of this machine is full, with advice; None if it has room."""
    advice = "make room, or set TMPDIR to a folder on another disk"
    try:
        place = tempfile.gettempdir()
        free = shutil.disk_usage(place).free
    except OSError as error:  # no folder can be written to, which is what a full disk looks like too
        return OutputError("folder for temporary files", f"{error.strerror}; {advice}")
    if free >= LEAST_FREE_BYTES:
        return None
    return OutputError(place, f"{free / 1e6:.1f} MB are free, jobs need {LEAST_FREE_BYTES / 1e6:.0f} MB; {advice}")
