"""Resource limits of one job in a worker process, and the failure of a job that gave no answer."""

from __future__ import annotations

import math
import resource
from dataclasses import dataclass

from casa_assets.core.process_limits import lower_limit

# A process that competes with others still gets some time; one with less than this part of a core hangs. A choice.
IDLE_CPU_SHARE = 0.001
# Seconds of the clock for each processor second of the limit, and at least; a choice: 20 jobs may share a core.
WALL_FACTOR, WALL_LEAST_S = 20.0, 1800.0


@dataclass(frozen=True)
class Limits:
    """Resources that one job may use, with all processes that it starts.

    Attributes:
        cpu_s: processor seconds. The clock decides nothing: on a busy machine a job takes longer and ends the same.
        memory_bytes: memory of its own (of its data, not of libraries mapped).
        idle_s: a job that uses no processor time for so many seconds of the clock hangs, and is ended.
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
