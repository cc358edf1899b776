"""Servers of workers that have loaded already what they need, for runs that the process of the tests itself leads.

A server takes two or three seconds to load the libraries that its workers share. Here one process loads them once and
is forked for each server that the tests start, with the same socket and messages. The real start stays for runs of the
program as a process of its own, for pools of the tests' own jobs, and wherever environment, folder or path are others.
"""

from __future__ import annotations

import importlib
import json
import os
import pickle
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from casa_assets import projects
from casa_assets.projects import NO_PROJECT, VARIABLE
from casa_assets.runs import pool

OURS = "casa_assets."
ALWAYS = ("casa_assets.ingest.run.inputs:warm_survey", "casa_assets.ingest.run.steps:warm")
MESSAGE_BYTES = 65536
CODE = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from tests.support.program.warm_servers import serve; serve(int(sys.argv[2]))"
)
State = tuple[str, tuple[str, ...], dict[str, str]]


def serve(descriptor: int) -> None:
    """Fork a server for each socket that is sent, until the other end closes."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "PXR_WORK_THREAD_LIMIT"):
        os.environ[name] = "1"  # before numpy is loaded, as `server.main` does
    from casa_assets.model.record import complete_records
    from casa_assets.runs.server import main

    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # servers that have ended leave nothing
    control, warmed = socket.socket(fileno=descriptor), set[str]()
    while True:
        data, descriptors, *_ = socket.recv_fds(control, MESSAGE_BYTES, 1)
        if not data:
            os._exit(0)
        for function in (*ALWAYS, pickle.loads(data)):
            if function not in warmed:
                module, name = function.split(":")
                getattr(importlib.import_module(module), name)()
                complete_records()
                warmed.add(function)
        if pid := os.fork():
            os.close(descriptors[0])
            control.send(pickle.dumps(pid))
            continue
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        control.close()
        os.setsid()
        main(descriptors[0])


class Forked:
    """A server that is no child of this process, with what a pool asks of one."""

    def __init__(self, pid: int) -> None:
        self.pid = pid
        self._end: int | None = os.pidfd_open(pid)

    def wait(self, timeout: float | None = None) -> int:
        if self._end is not None:
            if not select.select([self._end], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired("server", timeout or 0.0)
            os.close(self._end)
            self._end = None
        return 0

    def kill(self) -> None:
        if self._end is not None:
            signal.pidfd_send_signal(self._end, signal.SIGKILL)


class WarmServers:
    """Starts servers for pools of this process: forked ones, or real ones where they would differ."""

    def __init__(self) -> None:
        self._start = pool.Pool._start_server
        self._warm = ""
        self._process: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None
        self._state: State | None = None
        self._path = os.environ.get("PYTHONPATH")

    def start(self, asking: pool.Pool) -> socket.socket:
        """In place of `Pool._start_server`: the same, knowing what the server is to load."""
        self._warm = asking._warm[0]
        return self._start(asking)

    def popen(self, words: Sequence[str], **options: Any) -> Any:
        """In place of `subprocess.Popen` in the pool."""
        # A test that puts a hook on the path wants it in the server, which may be the first.
        has_hook = os.environ.get("PYTHONPATH") != self._path
        if has_hook or not self._warm.startswith(OURS) or self._state not in (None, state()):
            return subprocess.Popen(words, **options)
        try:
            control = self._control or self._begin()
            socket.send_fds(control, [pickle.dumps(self._warm)], options["pass_fds"])
            return Forked(pickle.loads(control.recv(MESSAGE_BYTES)))
        except (OSError, EOFError):
            self.close()
            return subprocess.Popen(words, **options)

    def _begin(self) -> socket.socket:
        self._control, end = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._state = state()
        with end:
            words = [sys.executable, "-c", CODE, json.dumps(self._state[1]), str(end.fileno())]
            silent = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL)
            options = {"pass_fds": [end.fileno()], "env": self._state[2], "start_new_session": True}
            self._process = subprocess.Popen(words, **silent, **options)
        return self._control

    def close(self) -> None:
        if self._control is not None:
            self._control.close()
        if self._process is not None:
            self._process.wait()
        self._control = self._process = self._state = None


def state() -> State:
    """What a server takes over from the process that starts it."""
    environment = {key: text for key, text in projects.environment().items() if key != "PYTEST_CURRENT_TEST"}
    if environment.get(VARIABLE) == NO_PROJECT:
        del environment[VARIABLE]
    return str(Path.cwd()), tuple(os.path.abspath(place) for place in sys.path), environment  # noqa: PTH100


@contextmanager
def warm_servers() -> Iterator[None]:
    servers = WarmServers()

    def start(asking: pool.Pool) -> socket.socket:  # a method would not be bound to the pool
        return servers.start(asking)

    names = {name: getattr(subprocess, name) for name in ("DEVNULL", "TimeoutExpired")}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pool, "subprocess", SimpleNamespace(Popen=servers.popen, **names))
        patch.setattr(pool.Pool, "_start_server", start)
        try:
            yield
        finally:
            servers.close()
