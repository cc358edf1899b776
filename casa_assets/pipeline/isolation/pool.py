"""Every job in a child process of its own: time and memory limits, and no job can take another one down."""

from __future__ import annotations

import json
import os
import pickle
import socket
import struct
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from signal import Signals
from types import TracebackType
from typing import Any, Self

from casa_assets.errors import CasaError
from casa_assets.pipeline.isolation.server import MESSAGE_BYTES, Died, Limits

__all__ = ["Died", "Limits", "Pool"]

TRIES = 2  # a job whose process was ended from outside is not to blame for it
SERVER_TRIES = 4
STUCK_S = 10.0  # for what the kernel does at once: ending a killed process, moving bytes between two processes
_CODE = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from casa_assets.pipeline.isolation.server import main; main(int(sys.argv[2]))"
)


class _ServerDied(Exception):
    """The process that forks is gone, and all workers with it."""


@dataclass
class _Running:
    """A job in a worker. `until` is None before the worker has started."""

    job: int
    channel: Connection
    until: float | None = None
    is_late: bool = False
    is_drained: bool = False
    answer: tuple[Any] | None = None


class Pool:
    """Workers for one run; a context manager, at whose end no process is left.

    Args:
        workers: jobs at once.
        limits: of each job.
        warm: `module:name` of a function that the server calls before it forks, so that what it loads is there for all.
    Raises:
        CasaError: no worker can be started; from `run` and `prepare`.
    """

    def __init__(self, workers: int, limits: Limits, warm: str) -> None:
        self._workers, self._limits = workers, limits
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
        """Yield (number of the job, answer or Died) as they finish.

        Args:
            function: `module:name` of a function of one argument; it answers with something picklable.
            jobs: picklable.
        """
        waiting = deque(range(len(jobs)))
        tries = [0] * len(jobs)
        while waiting or self._running:
            try:
                while waiting and len(self._running) < self._workers:
                    control = self._control or self._start_server()
                    number = waiting.popleft()
                    self._start(control, number, (function, jobs[number], self._limits))
                finished = list(self._finished())
            except _ServerDied:
                finished = list(self._salvaged())
            for number, answer in finished:
                if isinstance(answer, Died) and answer.reason in ("signal", "unstarted"):
                    tries[number] += answer.reason == "signal"
                    if tries[number] < TRIES:
                        waiting.appendleft(number)
                        continue
                yield number, answer

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

    def _start(self, control: socket.socket, job: int, task: tuple[str, Any, Limits]) -> None:
        here, there = socket.socketpair()
        # A worker that was stopped half-way through its answer must not hold up the others.
        for option in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO):
            here.setsockopt(socket.SOL_SOCKET, option, struct.pack("ll", int(STUCK_S), 0))
        self._ticket += 1
        one = self._running[self._ticket] = _Running(job, Connection(here.detach()))
        with there:
            try:
                socket.send_fds(control, [pickle.dumps(("fork", self._ticket))], [there.fileno()])
            except OSError as error:
                raise _ServerDied from error
        with suppress(OSError):  # where it died already, the server says so
            one.channel.send(task)

    def _start_server(self) -> socket.socket:
        if self._deaths >= SERVER_TRIES:
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
        deadlines = [one.until for one in self._running.values() if one.until is not None]
        soonest = min(deadlines, default=time.monotonic() + 1.0) - time.monotonic()
        ready = wait([self._control, *open_ends], timeout=max(0.0, min(soonest, 1.0)))
        for one in self._running.values():
            if one.channel in ready:
                _read(one)
        if self._control in ready:
            yield from self._hear(self._control)
        yield from self._late()

    def _hear(self, control: socket.socket) -> Iterator[tuple[int, Any]]:
        try:
            data = control.recv(MESSAGE_BYTES)
        except OSError as error:
            raise _ServerDied from error
        if not data:
            raise _ServerDied
        word, what, *more = pickle.loads(data)  # noqa: S301  our own server wrote it
        if word == "failed":
            raise CasaError(f"worker processes cannot be started; see `casa-assets doctor`\n{more[0]}")
        if word == "ready":
            self._deaths = 0
        elif word == "started" and what in self._running:
            self._running[what].until = time.monotonic() + self._limits.seconds
        elif word == "ended" and what in self._running:
            one = self._running.pop(what)
            yield one.job, self._verdict(one, more[0])

    def _late(self) -> Iterator[tuple[int, Any]]:
        """Have the late ones killed; yield those that not even that ended."""
        assert self._control is not None
        for ticket, one in list(self._running.items()):
            if one.until is None or time.monotonic() < one.until:
                continue
            if one.is_late:
                del self._running[ticket]
                yield one.job, self._verdict(one, 0)
            else:
                one.is_late, one.until = True, time.monotonic() + STUCK_S
                with suppress(OSError):
                    self._control.send(pickle.dumps(("kill", ticket)))

    def _verdict(self, one: _Running, code: int) -> Any:
        while not one.is_drained and one.channel.poll(0):
            _read(one)
        one.channel.close()
        if one.answer is not None:
            return one.answer[0]
        if one.until is None:
            return Died("unstarted", "no process was there for it")
        if one.is_late:
            return Died("timeout", f"still running after {self._limits.seconds:g} s and was stopped")
        if code < 0:
            return Died("signal", f"the process was ended by {Signals(-code).name}, twice")
        return Died("signal", f"the process ended with exit code {code} and without an answer, twice")

    def _salvaged(self) -> Iterator[tuple[int, Any]]:
        """The server is gone: wait until its workers are, keep what they had answered, and make way for another."""
        if self._server is not None:
            self._server.kill()
        running, self._running = self._running, {}
        for one in running.values():
            while not one.is_drained and one.channel.poll(STUCK_S):
                _read(one)
            yield one.job, self._verdict(one, -9)
        self._deaths += 1
        self.close()


def _read(one: _Running) -> None:
    """Take the answer, or note that none will come."""
    try:
        one.answer = (pickle.loads(one.channel.recv_bytes()),)  # noqa: S301  a child of ours wrote it
    except (EOFError, OSError):
        one.is_drained = True
    except Exception as error:  # noqa: BLE001  whatever a broken answer does when it is unpacked
        one.answer = (Died("error", f"{type(error).__name__}: {error}"),)
