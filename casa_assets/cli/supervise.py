"""A small process that starts the one that works, passes signals on to it, and sees that nothing of it is left.

A handler of Python waits for the native call that is under way, which may take minutes. So the verbs run in a child of
a process that does nothing but wait: if it is asked to stop, it passes the signal on. It then ends the child, with all
processes that the child started, if they have not ended by themselves soon after.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress

from casa_assets.runs.limits import trees

SIGNALS = frozenset({signal.SIGINT, signal.SIGTERM, signal.SIGHUP})
STOP_GRACE_S = 2.0  # for the child to clean up after it was told to stop
ORPHAN_GRACE_S = 0.5  # for what the child started to end by itself, once the child has ended
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36  # Ref: prctl(2)


class StopRequested(BaseException):
    """The user, or the system, asked the program to end; not an Exception, so that nothing on the way swallows it."""


def supervised(work: Callable[[], int], report: Callable[[str, str], None]) -> int:
    """Run `work` in a child process and end with its exit code, or 128 + signal number if a signal stopped it.

    Args:
        work: returns its exit code; it takes care of the signals itself, which are blocked when it is called.
        report: prints a mark, such as `error:`, and a line to standard error.
    """
    if sys.platform != "linux":
        return work()
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS | {signal.SIGCHLD})
    _prctl(PR_SET_CHILD_SUBREAPER, 1)  # what loses its parent becomes ours
    supervisor = os.getpid()
    child = os.fork()
    if child == 0:
        _prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != supervisor:
            os._exit(1)
        signal.pthread_sigmask(signal.SIG_SETMASK, before | SIGNALS)
        code = work()
        signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)  # the work is done, and a signal has nothing to stop
        sys.exit(code)
    status, stop = _wait(child)
    _end_descendants(0.0 if stop else ORPHAN_GRACE_S)
    code = _exit_code(status, stop, report)
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError):
            stream.flush()
    os._exit(code)  # a regular exit of Python takes a second on a busy machine, and there is nothing to clean up


def unblock() -> None:
    """Let signals through to this process, whose handlers are installed now."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)


def _wait(child: int) -> tuple[int, int]:
    """Wait until the child has ended: its status, and the signal that asked to stop, or 0."""
    stop, deadline = 0, float("inf")
    while True:
        left = min(max(0.0, deadline - time.monotonic()), 3600.0)
        received = signal.sigtimedwait(SIGNALS | {signal.SIGCHLD}, left)
        status = _reap(child)
        if status is not None:
            return status, stop or (received.si_signo if received is not None and received.si_signo in SIGNALS else 0)
        if received is not None and received.si_signo in SIGNALS and not stop:
            stop, deadline = received.si_signo, time.monotonic() + STOP_GRACE_S
            os.kill(child, stop)
        if time.monotonic() >= deadline:
            _kill_all()
            deadline = time.monotonic() + 0.1  # whatever was started meanwhile


def _reap(child: int) -> int | None:
    """Collect all that have ended; the status of the child if it is among them."""
    found = None
    with suppress(ChildProcessError):
        while True:
            pid, status = os.waitpid(-1, os.WNOHANG)
            if pid == 0:
                break
            if pid == child:
                found = status
    return found


def _end_descendants(patience_s: float) -> None:
    """Wait until all processes that the child had started have ended; kill those that do not within `patience_s`."""
    begin = time.monotonic()
    with suppress(ChildProcessError):
        while time.monotonic() - begin < patience_s + ORPHAN_GRACE_S:
            if os.waitpid(-1, os.WNOHANG)[0] == 0:
                if time.monotonic() - begin >= patience_s:
                    _kill_all()
                time.sleep(0.01)


def _kill_all() -> None:
    own = os.getpid()
    for process in trees([own])[own]:
        if process.pid != own:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(process.pid, signal.SIGKILL)


def _exit_code(status: int, stop: int, report: Callable[[str, str], None]) -> int:
    code = os.waitstatus_to_exitcode(status)
    if stop and code not in (0, 1, 2):
        report("stopped;", "the same command goes on from here")
        return 128 + stop
    if code in (-signal.SIGINT, -signal.SIGTERM, -signal.SIGHUP):
        report("stopped;", "the same command goes on from here")
        return 128 - code
    if code > 128 and code - 128 in SIGNALS:  # told to stop by somebody who knew its number
        report("stopped;", "the same command goes on from here")
    elif code == -signal.SIGKILL:
        report("error:", "the system ended the program, perhaps for want of memory; the same command goes on from here")
        return 2
    elif code < 0:
        name = signal.Signals(-code).name
        report("bug:", f"the program was ended by {name}: this is a fault of the program; please report it")
        return 3
    return code


def _prctl(option: int, value: int) -> None:
    ctypes.CDLL(None).prctl(option, value)
