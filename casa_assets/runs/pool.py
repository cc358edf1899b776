"""Run every job in a separate child process with limits on time and memory; no job can take another one down."""

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
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection, wait
from pathlib import Path
from signal import SIGKILL, SIGXCPU, Signals
from types import TracebackType
from typing import Any, Self

from casa_assets.core.system import require
from casa_assets.errors import CasaError
from casa_assets.projects import environment
from casa_assets.runs.limits import LEAST_WORKER_BYTES, Limits, WorkerFailure, plan_workers
from casa_assets.runs.server import MESSAGE_BYTES, OUT_OF_MEMORY

LOG = logging.getLogger(__name__)

# A function of a module, or its `module:name` where it shall not be imported here.
Step = Callable[..., Any] | str

MAX_TRIES = 2  # a job whose process was ended from outside is not to blame for it
MAX_SERVER_TRIES = 4
STUCK_S = 10.0  # for what the kernel does at once: ending a killed process, moving bytes between two processes
_CODE = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from casa_assets.runs.server import main; main(int(sys.argv[2]))"
)


def address_of(step: Step) -> str:
    """`module:name` of a function, by which processes that have not loaded it find it."""
    return step if isinstance(step, str) else f"{step.__module__}:{step.__qualname__}"


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


class Engine:
    """Runs the jobs of one run, each in a separate process with limits; a context manager.

    Nothing is started before the first job, and at the end no process of the run is left.

    Args:
        warm: called in the process that workers are forked from, so that what it loads is there for all. It may not
            draw: a process that has drawn cannot be forked.
    """

    def __init__(self, warm: Step) -> None:
        self._warm = [address_of(warm)]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """End what runs."""
        raise NotImplementedError

    def prepare(self, warm: Step) -> None:
        """Have one more function called before the next job."""
        self._warm.append(address_of(warm))

    def run(
        self, function: Step, jobs: Sequence[Any], started: Callable[[int], None] | None = None
    ) -> Iterator[tuple[int, Any]]:
        """Yield (number of the job, answer or WorkerFailure) as they finish.

        Args:
            function: of one argument; it answers with something picklable.
            jobs: picklable. started: is called with the number of each job when a worker takes it.
        """
        raise NotImplementedError


class Pool(Engine):
    """Workers for one run, on this machine.

    Fewer run at once, or each with less memory, where they would not fit into the memory of the machine together. A job
    that runs out of memory then, or is killed, is tried once more alone.

    Args:
        workers: jobs at once; 0: one per core.
        limits: of each job. warm: see Engine. least_bytes: memory that a job needs at least; see `plan_workers`.
    Raises:
        CasaError: no worker can be started; from `run` and `prepare`.
    """

    def __init__(self, workers: int, limits: Limits, warm: Step, least_bytes: int = LEAST_WORKER_BYTES) -> None:
        wanted = workers or len(os.sched_getaffinity(0))
        self._plan = plan_workers(wanted, limits.memory_bytes, least_bytes)
        self._workers, self._limits = self._plan.workers, replace(limits, memory_bytes=self._plan.memory_bytes)
        self._limits_alone = replace(limits, memory_bytes=self._plan.alone_bytes)
        super().__init__(warm)
        self._server: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None
        self._deaths = 0
        self._ticket = 0  # of the last worker; each try of a job has its own
        self._running: dict[int, _Running] = {}

    def prepare(self, warm: Step) -> None:
        """Have one more function called before the next fork."""
        super().prepare(warm)
        if self._control is not None:
            with suppress(OSError):
                self._control.send(pickle.dumps(("call", address_of(warm))))

    def run(
        self, function: Step, jobs: Sequence[Any], started: Callable[[int], None] | None = None
    ) -> Iterator[tuple[int, Any]]:
        """See Engine."""
        if len(jobs) > self._workers and self._plan.message:
            LOG.warning("%s", self._plan.message)
            self._plan = replace(self._plan, message="")
        queue = _Queue(deque(range(len(jobs))), deque(), dict.fromkeys(range(len(jobs)), 0), set())
        while queue.waiting or queue.alone or self._running:
            try:
                for number in self._jobs_to_start(queue):
                    control = self._control or self._start_server()
                    limits = self._limits_alone if number in queue.was_alone else self._limits
                    self._start(control, number, (address_of(function), jobs[number]), limits)
                    if started is not None:
                        started(number)
                finished = list(self._finished())
            except _ServerDied:
                finished = list(self._answers_of_ended_server())
            for number, answer in finished:
                if not (isinstance(answer, WorkerFailure) and self._requeue(number, answer, queue)):
                    yield number, answer

    def _jobs_to_start(self, queue: _Queue) -> Iterator[int]:
        """Numbers of the jobs to be started now."""
        while queue.waiting and len(self._running) < self._workers:
            yield queue.waiting.popleft()
        if queue.alone and not self._running:
            number = queue.alone.popleft()
            queue.was_alone.add(number)
            yield number

    def _requeue(self, number: int, failure: WorkerFailure, queue: _Queue) -> bool:
        """Put a job that may not be to blame for its end back into the queue; returns whether it is there."""
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
        for running in self._running.values():
            with suppress(OSError, EOFError):
                while running.channel.poll(STUCK_S):  # until its last holder is gone
                    running.channel.recv_bytes()
            running.channel.close()
        self._running.clear()
        self._server = self._control = None

    def _start(self, control: socket.socket, job: int, task: tuple[str, Any], limits: Limits) -> None:
        own_end, worker_end = socket.socketpair()
        # A worker that was stopped half-way through its answer must not hold up the others.
        for option in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO):
            own_end.setsockopt(socket.SOL_SOCKET, option, struct.pack("ll", int(STUCK_S), 0))
        self._ticket += 1
        running = self._running[self._ticket] = _Running(job, Connection(own_end.detach()), limits)
        with worker_end:
            try:
                socket.send_fds(control, [pickle.dumps(("fork", self._ticket, limits))], [worker_end.fileno()])
            except OSError as error:
                raise _ServerDied from error
        with suppress(OSError):  # where it died already, the server says so
            running.channel.send(task)

    def _start_server(self) -> socket.socket:
        if self._deaths >= MAX_SERVER_TRIES:
            raise CasaError(
                f"worker processes cannot be started: the server ended {self._deaths} times; see `casa-assets doctor`"
            )
        own_end, server_end = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        paths = json.dumps([os.path.abspath(p) for p in sys.path])  # noqa: PTH100  "" is the working folder
        with server_end:
            self._server = subprocess.Popen(
                [sys.executable, "-c", _CODE, paths, str(server_end.fileno())],
                pass_fds=[server_end.fileno()],
                env=environment(),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C in the terminal is for the pool alone
            )
        self._control = own_end
        with suppress(OSError):  # where it ended already, the next message finds out
            for function in self._warm:
                own_end.send(pickle.dumps(("call", function)))
        return own_end

    def _finished(self) -> Iterator[tuple[int, Any]]:
        """Wait for something to happen and yield what has finished."""
        assert self._control is not None
        open_ends = [running.channel for running in self._running.values() if not running.is_drained]
        ready = wait([self._control, *open_ends])
        for running in self._running.values():
            if running.channel in ready:
                _read(running)
        if self._control in ready:
            yield from self._receive(self._control)

    def _receive(self, control: socket.socket) -> Iterator[tuple[int, Any]]:
        try:
            data = control.recv(MESSAGE_BYTES)
        except OSError as error:
            raise _ServerDied from error
        if not data:
            raise _ServerDied
        word, number, *more = pickle.loads(data)  # noqa: S301  our own server wrote it
        if word == "failed":
            raise CasaError(f"worker processes cannot be started; see `casa-assets doctor`\n{more[0]}")
        if word == "started" and number in self._running:
            self._running[number].has_started = True
        elif word == "ended" and number in self._running:
            self._deaths = 0
            running = self._running.pop(number)
            yield running.job, self._verdict(running, *more)

    def _verdict(self, running: _Running, code: int, reason: str = "") -> Any:
        """Return the answer of a job whose process has ended, or a WorkerFailure if it did not answer."""
        while not running.is_drained and running.channel.poll(0):
            _read(running)
        running.channel.close()
        if running.answer is not None and running.answer[0] != OUT_OF_MEMORY:
            return running.answer[0]
        if running.answer is not None:
            reason = "memory"
        if not running.has_started:
            return WorkerFailure("unstarted", "no process was there for it")
        return _failure(running.limits, code, reason)

    def _answers_of_ended_server(self) -> Iterator[tuple[int, Any]]:
        """The server has ended: wait until its workers have, yield what they had answered, and close the pool."""
        if self._server is not None:
            self._server.kill()
        stopped, self._running = self._running, {}
        for running in stopped.values():
            while not running.is_drained and running.channel.poll(STUCK_S):
                _read(running)
            yield running.job, self._verdict(running, -SIGKILL, "server")
        self._deaths += 1
        self.close()


def _read(running: _Running) -> None:
    """Take the answer, or note that none will come."""
    try:
        running.answer = (pickle.loads(running.channel.recv_bytes()),)  # noqa: S301  a child of ours wrote it
    except (EOFError, OSError):
        running.is_drained = True
    except Exception as error:  # noqa: BLE001  whatever a broken answer does when it is unpacked
        running.answer = (WorkerFailure("error", f"{type(error).__name__}: {error}"),)


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


# Where jobs run: so many processes of this machine at once (0: one per core), or a cluster.
Workers = int | RayCluster


def open_engine(
    workers: Workers, limits: Limits, warm: Step, shared: Path, least_bytes: int = LEAST_WORKER_BYTES
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
    from casa_assets.runs.ray_engine import RayEngine

    return RayEngine(workers, limits, warm, shared, least_bytes)
