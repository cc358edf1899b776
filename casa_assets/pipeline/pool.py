"""Every job in a child process of its own: time and memory limits, and no job can take another one down.

Children are forked from a server that has imported the heavy libraries once, so that a child costs milliseconds.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import resource
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

PR_SET_PDEATHSIG = 1  # Ref: prctl(2)


@dataclass(frozen=True)
class Limits:
    """What one job may use: wall seconds and bytes of address space."""

    seconds: float
    memory_bytes: int


@dataclass(frozen=True)
class Died:
    """A job that did not answer.

    Attributes:
        reason: timeout, memory, signal, error.
        says: for a person. trace: of a Python error, or empty.
    """

    reason: str
    says: str
    trace: str = ""


@dataclass
class _Running:
    number: int
    process: BaseProcess
    answer: Connection
    until: float


def run(function: Callable[[Any], Any], jobs: Sequence[Any], workers: int, limits: Limits) -> Iterator[tuple[int, Any]]:
    """Yield (number of the job, answer or Died) as they finish.

    Args:
        function: importable; answers with something picklable.
        jobs: picklable.
        workers: children at once.
    """
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["casa_assets.pipeline.preload"])
    running: dict[int, _Running] = {}
    waiting = list(enumerate(jobs))[::-1]
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                number, job = waiting.pop()
                here, there = context.Pipe(duplex=False)
                process = context.Process(target=_child, args=(function, job, limits, there), daemon=False)
                process.start()
                there.close()
                running[number] = _Running(number, process, here, time.monotonic() + limits.seconds)
            yield from _finished(running, limits)
    finally:
        for left in running.values():
            left.process.kill()


def _finished(running: dict[int, _Running], limits: Limits) -> Iterator[tuple[int, Any]]:
    soonest = min(r.until for r in running.values())
    ready = wait([r.answer for r in running.values()], timeout=max(0.0, min(soonest - time.monotonic(), 1.0)))
    for one in sorted(running.values(), key=lambda r: r.number):
        if one.answer in ready:
            answer = _read(one)
        elif time.monotonic() > one.until:
            one.process.kill()
            answer = Died("timeout", f"still running after {limits.seconds:g} s and was stopped")
        else:
            continue
        del running[one.number]
        one.answer.close()
        one.process.join()
        one.process.close()
        yield one.number, answer


def _read(one: _Running) -> Any:
    try:
        return one.answer.recv()
    except EOFError:
        one.process.join()
        code = one.process.exitcode or 0
        if code < 0:
            return Died("signal", f"the process was ended by {signal.Signals(-code).name}")
        return Died("signal", f"the process ended with exit code {code} and without an answer")


def _child(function: Callable[[Any], Any], job: Any, limits: Limits, answer: Connection) -> None:
    _tie_to_parent()
    resource.setrlimit(resource.RLIMIT_AS, (limits.memory_bytes, limits.memory_bytes))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    # Native libraries chat; a batch of thousands must stay readable.
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)
    os.dup2(quiet, 2)
    try:
        result: Any = function(job)
    except MemoryError:
        result = Died("memory", f"needs more than {limits.memory_bytes / 1e9:.3g} GB of memory")
    except Exception as error:  # noqa: BLE001  a bug of ours or a library's is reported, and the batch goes on
        result = Died("error", f"{type(error).__name__}: {error}", traceback.format_exc())
    answer.send(result)
    answer.close()
    sys.stdout.flush()
    # GL drivers and USD hold threads that make a normal exit hang or crash; the answer is out.
    os._exit(0)


def _tie_to_parent() -> None:
    """End with the parent, however it dies, so that no orphan writes into a library that is being resumed."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
