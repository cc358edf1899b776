"""Fork server of the workers: it has imported the heavy libraries once, so that a worker costs little.

`main` is run by runs/pool.py in a separate process. They talk over one socket in whole messages, pickled tuples:

    pool -> server   ("call", function)  ("fork", number, limits) with the worker's end of a socket
    server -> pool   ("ready", function)  ("failed", function, why)  ("started", number)
                     ("ended", number, exit code, reason): a reason if the server ended it, as in WorkerFailure

The server adds up the processor time of each worker and of all that it started, and ends those over their limits.
If the socket closes, the server kills its workers with all that they started, and ends.
"""

from __future__ import annotations

import ctypes
import errno
import importlib
import os
import pickle
import select
import signal
import socket
import sys
import time
import traceback
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NoReturn

from casa_assets.core.system import WORKER
from casa_assets.runs.limits import IDLE_CPU_SHARE, Limits, Usage, WorkerFailure, restrict, trees, usage

MESSAGE_BYTES = 65536
# Not imported here: numpy is to be loaded after `main` has said how many threads it may have.
RECORDS = "casa_assets.model.record"
# Where all workers together want more than the machine has, the kernel is to end one of them and not the run.
# Ref: proc(5), /proc/pid/oom_score_adj: 0 is usual, 1000 goes first.
OOM_SCORE = 500
OOM_FILE = Path("/proc/self/oom_score_adj")
PR_SET_PDEATHSIG = 1  # Ref: prctl(2)
# Shortest and longest time between two checks of what the workers use, seconds.
SOONEST_S, LATEST_S = 0.02, 1.0
STUCK_S = 10.0  # for what the kernel does at once: ending a killed process
OUT_OF_MEMORY = WorkerFailure("memory", "")  # the pool knows the limit
# What dlopen(3) and CPython's thread module say where mmap(2) is refused.
OUT_OF_MEMORY_TEXTS = ("failed to map segment", "annot allocate memory", "can't start new thread")
# A job that fails where less than this is left of its memory fails for want of it, whatever a library calls the error:
# Pillow says "codec configuration error". A choice: no picture, mesh or renderer that a job loads first takes more.
LEAST_LEFT_BYTES = 64_000_000
# Exit code of a worker that has too little memory left to tell so. A choice: the number of the error of the system.
OUT_OF_MEMORY_EXIT = errno.ENOMEM


def main(descriptor: int) -> None:
    """Serve until the other end of the socket closes."""
    # One thread each: the pool has a worker for every core, and results must not depend on their number.
    # OpenUSD's threads take a tenth more of processor time for layers as small as a kitchen's.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "PXR_WORK_THREAD_LIMIT"):
        os.environ[name] = "1"
    os.environ[WORKER] = "1"
    _Server(socket.socket(fileno=descriptor)).serve()


@dataclass
class _Worker:
    """A job that runs.

    Attributes:
        number: of the job. started_at, active_at: when it started, and when it was last found to have used processor
            time; seconds of the monotonic clock. cpu_s: processor seconds that it had used by then.
        reason: why the server ended it, or empty. killed: when.
    """

    number: int
    limits: Limits
    started_at: float
    active_at: float
    cpu_s: float = 0.0
    reason: str = ""
    killed: float = 0.0

    def reason_to_end(self, used: Usage, now: float) -> str:
        """The reason to end it, if there is one."""
        if used.cpu_s - self.cpu_s > IDLE_CPU_SHARE * self.limits.idle_s:
            self.active_at, self.cpu_s = now, used.cpu_s
        if used.cpu_s > self.limits.cpu_s:
            return "timeout"
        if used.memory_bytes > self.limits.memory_bytes:
            return "memory"
        if now - self.active_at > self.limits.idle_s or now - self.started_at > self.limits.wall_s:
            return "stuck"
        return ""


class _Server:
    def __init__(self, control: socket.socket) -> None:
        self._control = control
        self._workers: dict[int, _Worker] = {}  # by pid
        self._next_check = 0.0
        self._wake, self._alarm = os.pipe()
        os.set_blocking(self._wake, False)
        os.set_blocking(self._alarm, False)

    def serve(self) -> None:
        """Answer the pool, reap workers and hold them to their limits until the pool closes its end."""
        signal.signal(signal.SIGCHLD, lambda *_: None)
        signal.set_wakeup_fd(self._alarm, warn_on_full_buffer=False)
        try:
            while True:
                wait = max(0.0, self._next_check - time.monotonic()) if self._workers else None
                ready, _, _ = select.select([self._control.fileno(), self._wake], [], [], wait)
                if self._wake in ready:
                    self._reap()
                if self._workers and time.monotonic() >= self._next_check:
                    self._enforce_limits()
                if self._control.fileno() in ready and not self._handle_message():
                    break
        except OSError:
            pass  # the pool is gone
        finally:
            for pid in self._workers:
                _kill(pid)
            # What was imported need not be taken apart: the run waits for the end of this process.
            os._exit(0)

    def _handle_message(self) -> bool:
        data, descriptors, *_ = socket.recv_fds(self._control, MESSAGE_BYTES, 1)
        if not data:
            return False
        word, what, *more = pickle.loads(data)  # noqa: S301  our own pool wrote it
        if word == "call":
            self._call(what)
        else:
            self._fork(what, more[0], descriptors[0])
        return True

    def _call(self, function: str) -> None:
        try:
            _find(function)()
            if RECORDS in sys.modules:  # else each worker would make the validators of records anew
                _find(f"{RECORDS}:complete_records")()
        except Exception:  # noqa: BLE001  reported to the pool, which ends the run
            self._send("failed", function, traceback.format_exc()[-MESSAGE_BYTES // 2 :])
        else:
            self._send("ready", function)

    def _fork(self, number: int, limits: Limits, descriptor: int) -> None:
        server = os.getpid()
        pid = os.fork()
        if pid == 0:
            signal.set_wakeup_fd(-1)
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            self._control.close()
            os.close(self._wake)
            os.close(self._alarm)
            _worker(Connection(descriptor), server, limits)
        os.close(descriptor)
        now = time.monotonic()
        self._workers[pid] = _Worker(number, limits, started_at=now, active_at=now)
        self._next_check = min(self._next_check, now + min(LATEST_S, limits.cpu_s))
        self._send("started", number)

    def _enforce_limits(self) -> None:
        """End the workers that are over their limits, and set the time of the next check: as soon as one could be."""
        now, rest = time.monotonic(), LATEST_S
        found = usage(self._workers)
        for pid, worker in list(self._workers.items()):
            used = found.get(pid)
            if used is not None and not worker.reason:
                worker.reason = worker.reason_to_end(used, now)
                if worker.reason:
                    worker.killed = now
                    _kill(pid)
                rest = min(rest, (worker.limits.cpu_s - used.cpu_s) / (os.cpu_count() or 1), worker.limits.idle_s / 4)
            elif worker.reason and now - worker.killed > STUCK_S:
                # Not even a kill ends a process that waits within the kernel, as for a disk that has gone away.
                del self._workers[pid]
                self._send("ended", worker.number, -signal.SIGKILL, worker.reason)
        self._next_check = now + max(SOONEST_S, rest)

    def _reap(self) -> None:
        with suppress(BlockingIOError):
            while os.read(self._wake, 4096):
                pass
        while self._workers:
            # Its children are killed before it is collected: until then no other process can get its number or group.
            ended = os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)
            if ended is None:
                return
            _kill(ended.si_pid)
            _, status = os.waitpid(ended.si_pid, 0)
            worker = self._workers.pop(ended.si_pid, None)
            if worker is not None:
                code = os.waitstatus_to_exitcode(status)
                reason = worker.reason or ("memory" if code == OUT_OF_MEMORY_EXIT else "")
                self._send("ended", worker.number, code, reason)

    def _send(self, *message: Any) -> None:
        self._control.send(pickle.dumps(message))


def _kill(pid: int) -> None:
    """End a worker and all that it started, also what it put into another session."""
    for process in trees([pid])[pid]:
        with suppress(ProcessLookupError, PermissionError):
            os.kill(process.pid, signal.SIGKILL)
    for kill in (os.killpg, os.kill):
        with suppress(ProcessLookupError, PermissionError):
            kill(pid, signal.SIGKILL)


def _worker(channel: Connection, server: int, limits: Limits) -> NoReturn:
    """One job, read from the channel, answered there."""
    try:
        # End with the server, however it dies, so that no orphan writes into a library that is being resumed.
        if sys.platform == "linux":
            ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != server:
            os._exit(1)
        os.setsid()  # what it starts is found by its session
        # Native libraries chat; a batch of thousands must stay readable.
        quiet = os.open(os.devnull, os.O_RDWR)
        for descriptor in (0, 1, 2):
            os.dup2(quiet, descriptor)
        function, job = channel.recv()
        with suppress(OSError):
            OOM_FILE.write_text(str(OOM_SCORE), encoding="ascii")
        restrict(limits)
        answer = pickle.dumps(_find(function)(job))
    except BaseException as error:  # noqa: BLE001  a bug of ours or a library's is reported, and the batch goes on
        answer = _pickled_failure(error)
    code = 0
    try:
        channel.send_bytes(answer)
    except MemoryError:
        code = OUT_OF_MEMORY_EXIT
    finally:
        # GL drivers and USD hold threads that make a normal exit hang or crash; the answer is out.
        os._exit(code)


def _pickled_failure(error: BaseException) -> bytes:
    """Return the pickled failure of a job that raised an error; ends the process if there is no memory to pickle it."""
    try:
        failure = OUT_OF_MEMORY
        if not _is_out_of_memory(error):  # cut to a length that can be sent
            message, trace = f"{type(error).__name__}: {error}"[:2000], traceback.format_exc()[-20000:]
            failure = WorkerFailure("error", message, trace)
        return pickle.dumps(failure)
    except MemoryError:
        os._exit(OUT_OF_MEMORY_EXIT)


def _is_out_of_memory(error: BaseException | None) -> bool:
    """Return whether an error, its cause or its context says that the memory limit was reached.

    If none of them says so, the remaining memory decides. Memory that the failed job holds counts as used, because its
    frames belong to the error.
    """
    while error is not None:
        if isinstance(error, MemoryError) or (isinstance(error, OSError) and error.errno == errno.ENOMEM):
            return True
        # The loader of shared libraries and the start of a thread have no error of their own for it.
        if isinstance(error, ImportError | RuntimeError) and any(text in str(error) for text in OUT_OF_MEMORY_TEXTS):
            return True
        error = error.__cause__ or error.__context__
    try:
        bytearray(LEAST_LEFT_BYTES)
    except MemoryError:
        return True
    return False


def _find(function: str) -> Any:
    module, name = function.split(":")
    return getattr(importlib.import_module(module), name)
