"""The process that workers are forked from: it has imported the heavy libraries once, so that a worker costs little.

`main` is run by pipeline.pool in a process of its own. They talk over one socket in whole messages, pickled tuples:

    pool -> server   ("call", function)  ("fork", number) with the worker's end of a socket  ("kill", number)
    server -> pool   ("ready", function)  ("failed", function, why)  ("started", number)  ("ended", number, exit code)

Where the socket closes, the server kills its workers with all that they started, and ends.
"""

from __future__ import annotations

import ctypes
import importlib
import os
import pickle
import resource
import select
import signal
import socket
import sys
import traceback
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NoReturn

MESSAGE_BYTES = 65536
# Where all workers together want more than the machine has, the kernel is to end one of them and not the run.
# Ref: proc(5), /proc/pid/oom_score_adj: 0 is usual, 1000 goes first.
OOM_SCORE = 500
OOM_FILE = Path("/proc/self/oom_score_adj")
PR_SET_PDEATHSIG = 1  # Ref: prctl(2)


@dataclass(frozen=True)
class Limits:
    """What one job may use: wall seconds, and bytes of memory of its own (of its data, not of libraries mapped)."""

    seconds: float
    memory_bytes: int


@dataclass(frozen=True)
class Died:
    """A job that did not answer.

    Attributes:
        reason: timeout, memory, signal, error (and, within the pool, unstarted).
        says: for a person. trace: of a Python error, or empty.
    """

    reason: str
    says: str
    trace: str = ""


def main(descriptor: int) -> None:
    """Serve until the other end of the socket closes."""
    # One thread each: the pool has a worker for every core, and results must not depend on their number.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = "1"
    _Server(socket.socket(fileno=descriptor)).serve()


class _Server:
    def __init__(self, control: socket.socket) -> None:
        self._control = control
        self._workers: dict[int, int] = {}  # pid -> number of the job
        self._wake, self._alarm = os.pipe()
        os.set_blocking(self._wake, False)
        os.set_blocking(self._alarm, False)

    def serve(self) -> None:
        signal.signal(signal.SIGCHLD, lambda *_: None)
        signal.set_wakeup_fd(self._alarm, warn_on_full_buffer=False)
        try:
            while True:
                ready, _, _ = select.select([self._control.fileno(), self._wake], [], [])
                if self._wake in ready:
                    self._reap()
                if self._control.fileno() in ready and not self._obey():
                    break
        except OSError:
            pass  # the pool is gone
        finally:
            for pid in self._workers:
                _kill(pid)

    def _obey(self) -> bool:
        data, descriptors, *_ = socket.recv_fds(self._control, MESSAGE_BYTES, 1)
        if not data:
            return False
        word, what = pickle.loads(data)  # noqa: S301  our own pool wrote it
        if word == "call":
            self._call(what)
        elif word == "fork":
            self._fork(what, descriptors[0])
        else:
            for pid in [p for p, number in self._workers.items() if number == what]:
                _kill(pid)
        return True

    def _call(self, function: str) -> None:
        try:
            _find(function)()
        except Exception:  # noqa: BLE001  reported to the pool, which ends the run
            self._tell("failed", function, traceback.format_exc()[-MESSAGE_BYTES // 2 :])
        else:
            self._tell("ready", function)

    def _fork(self, number: int, descriptor: int) -> None:
        server = os.getpid()
        pid = os.fork()
        if pid == 0:
            signal.set_wakeup_fd(-1)
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            self._control.close()
            os.close(self._wake)
            os.close(self._alarm)
            _worker(Connection(descriptor), server)
        os.close(descriptor)
        self._workers[pid] = number
        self._tell("started", number)

    def _reap(self) -> None:
        with suppress(BlockingIOError):
            while os.read(self._wake, 4096):
                pass
        while self._workers:
            # Looked at before it is collected: until then nobody else can have its number, nor that of its group.
            ended = os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)
            if ended is None:
                return
            _kill(ended.si_pid)
            _, status = os.waitpid(ended.si_pid, 0)
            number = self._workers.pop(ended.si_pid, None)
            if number is not None:
                self._tell("ended", number, os.waitstatus_to_exitcode(status))

    def _tell(self, *message: Any) -> None:
        self._control.send(pickle.dumps(message))


def _kill(pid: int) -> None:
    """End a worker and all that it started."""
    for kill in (os.killpg, os.kill):
        with suppress(ProcessLookupError, PermissionError):
            kill(pid, signal.SIGKILL)


def _worker(channel: Connection, server: int) -> NoReturn:
    """One job, read from the channel, answered there."""
    try:
        _tie_to(server)
        os.setsid()  # what it starts is found by its group
        # Native libraries chat; a batch of thousands must stay readable.
        quiet = os.open(os.devnull, os.O_RDWR)
        for descriptor in (0, 1, 2):
            os.dup2(quiet, descriptor)
        answer = pickle.dumps(_answer(*channel.recv()))
    except BaseException as error:  # noqa: BLE001  a bug of ours or a library's is reported, and the batch goes on
        answer = pickle.dumps(Died("error", f"{type(error).__name__}: {error}"[:2000], traceback.format_exc()[-20000:]))
    try:
        channel.send_bytes(answer)
    finally:
        # GL drivers and USD hold threads that make a normal exit hang or crash; the answer is out.
        os._exit(0)


def _answer(function: str, job: Any, limits: Limits) -> Any:
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with suppress(OSError):
        OOM_FILE.write_text(str(OOM_SCORE), encoding="ascii")
    # Address space would count what drivers and thread arenas merely reserve, which is much on a machine of many cores.
    resource.setrlimit(resource.RLIMIT_DATA, (limits.memory_bytes, limits.memory_bytes))
    try:
        return _find(function)(job)
    except MemoryError:
        return Died("memory", f"needs more than {limits.memory_bytes / 1e9:.3g} GB of memory")


def _find(function: str) -> Any:
    module, name = function.split(":")
    return getattr(importlib.import_module(module), name)


def _tie_to(server: int) -> None:
    """End with the server, however it dies, so that no orphan writes into a library that is being resumed."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != server:
        os._exit(1)
