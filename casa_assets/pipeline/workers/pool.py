"""Run every job in a child process of its own with limits on time and memory; no job can take another one down."""

from __future__ import annotations

import json
import logging
import os
import pickle
import socket
import struct
import subprocess
import sys
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection, wait
from signal import SIGKILL, SIGXCPU, Signals
from types import TracebackType
from typing import Any, Self

from casa_assets.errors import CasaError
from casa_assets.pipeline.workers import memory
from casa_assets.pipeline.workers.limits import Limits, WorkerFailure
from casa_assets.pipeline.workers.server import MESSAGE_BYTES, OUT_OF_MEMORY

__all__ = ["Limits", "Pool", "WorkerFailure"]

LOG = logging.getLogger(__name__)

MAX_TRIES = 2  # a job whose process was ended from outside is not to blame for it
MAX_SERVER_TRIES = 4
STUCK_S = 10.0  # for what the kernel does at once: ending a killed process, moving bytes between two processes
_CODE = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from casa_assets.pipeline.workers.server import main; main(int(sys.argv[2]))"
)


class _ServerDied(Exception):
    """The process that forks is gone, and all workers with it."""


@dataclass
class _Running:
    """A job in a worker, with its limits there. `has_started`: the worker has."""

    job: int
    channel: Connection
    limits: Limits
    has_started: bool = False
    is_drained: bool = False
    answer: tuple[Any] | None = None


@dataclass
class _Queue:
    """Jobs that are still to be done: those for now, and those that run at the end, each alone with all memory."""

    waiting: deque[int]
    alone: deque[int]
    tries: dict[int, int]
    was_alone: set[int]


class Pool:
    """Workers for one run; a context manager, at whose end no process is left.

    Fewer run at once, or each with less memory, where they would not fit into the memory of the machine together. A job
    that runs out of memory then, or is killed, is tried once more alone.

    Args:
        workers: jobs at once; 0: one per core.
        limits: of each job.
        warm: `module:name` of a function that the server calls before it forks, so that what it loads is there for all.
            It may not draw: a process that has drawn cannot be forked.
        least_bytes: memory that a job needs at least; see memory.share.
    Raises:
        CasaError: no worker can be started; from `run` and `prepare`.
    """

    def __init__(self, workers: int, limits: Limits, warm: str, least_bytes: int = memory.LEAST_WORKER_BYTES) -> None:
        wanted = workers or len(os.sched_getaffinity(0))
        self._share = memory.plan_workers(wanted, limits.memory_bytes, least_bytes)
        self._workers, self._limits = self._share.workers, replace(limits, memory_bytes=self._share.memory_bytes)
        self._limits_alone = replace(limits, memory_bytes=self._share.alone_bytes)
        self._warm = [warm]
        self._server: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None
        self._deaths = 0
        self._ticket = 0  # of the last worker; each try of a job has its own
        self._running: dict[int, _Running] = {}

    def __enter__(self) -> Self:
        self._start_server()  # it gets ready while the caller looks for work
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def prepare(self, warm: str) -> None:
        """Have one more function called before the next fork."""
        self._warm.append(warm)
        if self._control is not None:
            with suppress(OSError):
                self._control.send(pickle.dumps(("call", warm)))

    def run(self, function: str, jobs: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        """Yield (number of the job, answer or WorkerFailure) as they finish.

        Args:
            function: `module:name` of a function of one argument; it answers with something picklable.
            jobs: picklable.
        """
        if len(jobs) > self._workers and self._share.message:
            LOG.warning("%s", self._share.message)
            self._share = replace(self._share, message="")
        queue = _Queue(deque(range(len(jobs))), deque(), dict.fromkeys(range(len(jobs)), 0), set())
        while queue.waiting or queue.alone or self._running:
            try:
                for number in self._due(queue):
                    control = self._control or self._start_server()
                    limits = self._limits_alone if number in queue.was_alone else self._limits
                    self._start(control, number, (function, jobs[number]), limits)
                finished = list(self._finished())
            except _ServerDied:
                finished = list(self._salvaged())
            for number, answer in finished:
                if not (isinstance(answer, WorkerFailure) and self._is_to_be_tried_again(number, answer, queue)):
                    yield number, answer

    def _due(self, queue: _Queue) -> Iterator[int]:
        """Jobs to be started now."""
        while queue.waiting and len(self._running) < self._workers:
            yield queue.waiting.popleft()
        if queue.alone and not self._running:
            number = queue.alone.popleft()
            queue.was_alone.add(number)
            yield number

    def _is_to_be_tried_again(self, number: int, failure: WorkerFailure, queue: _Queue) -> bool:
        """True if a job may not be to blame for its end; if so it is in the queue again."""
        if failure.reason == "unstarted":
            queue.waiting.appendleft(number)
            return True
        if number in queue.was_alone:
            return False
        if failure.reason == "memory":
            # With others beside it, it had less than it may use.
            again = self._limits.memory_bytes < self._limits_alone.memory_bytes
        else:
            queue.tries[number] += failure.reason in ("signal", "killed")
            again = 0 < queue.tries[number] < MAX_TRIES
        if again:
            # The system kills where memory runs out.
            (queue.waiting if failure.reason == "signal" else queue.alone).appendleft(number)
        return again

    def close(self) -> None:
        """End the server and all workers."""
        if self._control is not None:
            self._control.close()
        if self._server is not None:
            try:
                self._server.wait(STUCK_S)
            except subprocess.TimeoutExpired:
                self._server.kill()
                self._server.wait()
        for one in self._running.values():
            with suppress(OSError, EOFError):
                while one.channel.poll(STUCK_S):  # until its last holder is gone
                    one.channel.recv_bytes()
            one.channel.close()
        self._running.clear()
        self._server = self._control = None

    def _start(self, control: socket.socket, job: int, task: tuple[str, Any], limits: Limits) -> None:
        here, there = socket.socketpair()
        # A worker that was stopped half-way through its answer must not hold up the others.
        for option in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO):
            here.setsockopt(socket.SOL_SOCKET, option, struct.pack("ll", int(STUCK_S), 0))
        self._ticket += 1
        one = self._running[self._ticket] = _Running(job, Connection(here.detach()), limits)
        with there:
            try:
                socket.send_fds(control, [pickle.dumps(("fork", self._ticket, limits))], [there.fileno()])
            except OSError as error:
                raise _ServerDied from error
        with suppress(OSError):  # where it died already, the server says so
            one.channel.send(task)

    def _start_server(self) -> socket.socket:
        if self._deaths >= MAX_SERVER_TRIES:
            raise CasaError(
                f"worker processes cannot be started: the server ended {self._deaths} times; see `casa-assets doctor`"
            )
        here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        paths = json.dumps([os.path.abspath(p) for p in sys.path])  # noqa: PTH100  "" is the working folder
        with there:
            self._server = subprocess.Popen(
                [sys.executable, "-c", _CODE, paths, str(there.fileno())],
                pass_fds=[there.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C in the terminal is for the pool alone
            )
        self._control = here
        with suppress(OSError):  # where it ended already, the next message finds out
            for function in self._warm:
                here.send(pickle.dumps(("call", function)))
        return here

    def _finished(self) -> Iterator[tuple[int, Any]]:
        """Wait for something to happen and yield what has finished."""
        assert self._control is not None
        open_ends = [one.channel for one in self._running.values() if not one.is_drained]
        ready = wait([self._control, *open_ends])
        for one in self._running.values():
            if one.channel in ready:
                _read(one)
        if self._control in ready:
            yield from self._receive(self._control)

    def _receive(self, control: socket.socket) -> Iterator[tuple[int, Any]]:
        try:
            data = control.recv(MESSAGE_BYTES)
        except OSError as error:
            raise _ServerDied from error
        if not data:
            raise _ServerDied
        word, what, *more = pickle.loads(data)  # noqa: S301  our own server wrote it
        if word == "failed":
            raise CasaError(f"worker processes cannot be started; see `casa-assets doctor`\n{more[0]}")
        if word == "started" and what in self._running:
            self._running[what].has_started = True
        elif word == "ended" and what in self._running:
            self._deaths = 0
            one = self._running.pop(what)
            yield one.job, self._verdict(one, *more)

    def _verdict(self, one: _Running, code: int, reason: str = "") -> Any:
        """The answer of a job whose process is gone, or why there is none."""
        while not one.is_drained and one.channel.poll(0):
            _read(one)
        one.channel.close()
        if one.answer is not None and one.answer[0] != OUT_OF_MEMORY:
            return one.answer[0]
        if one.answer is not None:
            reason = "memory"
        if not one.has_started:
            return WorkerFailure("unstarted", "no process was there for it")
        return _failure(one.limits, code, reason)

    def _salvaged(self) -> Iterator[tuple[int, Any]]:
        """The server is gone: wait until its workers are, keep what they had answered, and make way for another."""
        if self._server is not None:
            self._server.kill()
        running, self._running = self._running, {}
        for one in running.values():
            while not one.is_drained and one.channel.poll(STUCK_S):
                _read(one)
            yield one.job, self._verdict(one, -SIGKILL, "server")
        self._deaths += 1
        self.close()


def _read(one: _Running) -> None:
    """Take the answer, or note that none will come."""
    try:
        one.answer = (pickle.loads(one.channel.recv_bytes()),)  # noqa: S301  a child of ours wrote it
    except (EOFError, OSError):
        one.is_drained = True
    except Exception as error:  # noqa: BLE001  whatever a broken answer does when it is unpacked
        one.answer = (WorkerFailure("error", f"{type(error).__name__}: {error}"),)


def _failure(limits: Limits, code: int, reason: str) -> WorkerFailure:
    """The failure of a process that ended without an answer.

    Args:
        code: its exit code, or less than 0: the signal that ended it. reason: why the server ended it, or empty.
    """
    if reason == "timeout" or code == -SIGXCPU:
        return WorkerFailure("timeout", f"used more than {limits.cpu_s:g} s of processor time and was stopped")
    if reason == "memory":
        return WorkerFailure("memory", f"needs more than {limits.memory_bytes / 1e9:.3g} GB of memory")
    if reason == "stuck":
        message = f"made no progress for {limits.idle_s:g} s, or took over {limits.wall_s:g} s, and was stopped"
        return WorkerFailure("stuck", message)
    if code == -SIGKILL:
        return WorkerFailure("signal" if reason else "killed", "the process was ended by SIGKILL, twice")
    if code < 0:
        return WorkerFailure("signal", f"the process was ended by {Signals(-code).name}, twice")
    return WorkerFailure("signal", f"the process ended with exit code {code} and without an answer, twice")
