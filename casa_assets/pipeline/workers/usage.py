"""Measure CPU seconds and memory of a process with all that it started, as Linux counts them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter

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
    """CPU seconds, processes and memory of a process with all that it started.

    Attributes:
        cpu_s: processor seconds so far, of user and system. processes: how many run.
        memory_bytes: memory in use that is shared with no file; counted for several processes only, else 0.
    """

    cpu_s: float
    processes: int = 1
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
    """Every process that this one may see. Ref: proc(5), /proc/pid/stat; nothing where there is no such folder."""
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
            found[root] = Usage(sum(process.cpu_s for process in members), len(members), memory)
    return found


def _memory(pid: int) -> int:
    """Bytes of memory that a process has in use and shares with no file; 0 where it has ended."""
    with suppress(OSError, ValueError, IndexError):
        _, resident, shared = map(int, (PROC / str(pid) / "statm").read_text(encoding="ascii").split()[:3])
        return (resident - shared) * PAGE_BYTES
    return 0
