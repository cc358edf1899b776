"""The program: all commands, the process that works and the one that watches over it, and exit codes."""

from __future__ import annotations

import ctypes
import errno
import gc
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from copy import copy
from types import FrameType
from typing import Annotated, NoReturn

import typer
from typer.main import get_command_name
from typer.models import CommandInfo

from casa_assets import __version__
from casa_assets.cli.group import Group, Verb, print_error
from casa_assets.cli.verbs.check import categories, check, checks, doctor, review, schemas
from casa_assets.cli.verbs.export import app as export
from casa_assets.cli.verbs.families import families, objects
from casa_assets.cli.verbs.library import app as library
from casa_assets.cli.verbs.library import find, report
from casa_assets.cli.verbs.meshes import articulate, fetch, ingest
from casa_assets.cli.verbs.project import init, make
from casa_assets.cli.verbs.scenes import app as scenes
from casa_assets.cli.verbs.textures import app as textures
from casa_assets.cli.verbs.view import preview, view
from casa_assets.errors import BatchFault, CasaError, StopRequested
from casa_assets.runs.limits import trees
from casa_assets.show.stills.opengl import keep_from_mujoco

EXIT_MISUSE, EXIT_FAULT, EXIT_SIGNAL_BASE = 2, 3, 128
# Refused by a file, a folder or a disk, and no fault of the program: rights, room, or a name that cannot be.
ACCESS_ERRNOS = frozenset(
    {errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EMFILE, errno.ENFILE}
    | {errno.ENOTDIR, errno.EISDIR, errno.ENAMETOOLONG}
)
SIGNALS = frozenset({signal.SIGINT, signal.SIGTERM, signal.SIGHUP})
STOP_GRACE_S = 2.0  # for the child to clean up after it was asked to stop
ORPHAN_GRACE_S = 0.5  # for what the child started to end by itself, once the child has ended
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36  # Ref: prctl(2)

MAKE, LOOK, JUDGE, HAND_ON = "Make", "Look", "Check and decide", "Export"
ABOUT = "Simulation-ready kitchens and assets as MJCF and USD, each with a picture and the results of its checks."

app = typer.Typer(
    name="casa-assets",
    cls=Group,
    help=ABOUT,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=(
        "Exit codes of all commands: 0 all is well; 1 some inputs failed, two things differ, a condition holds or "
        "nothing was found; 2 wrong use or a broken machine; 3 a fault of the program; 4 a person has to decide; "
        "130 Ctrl-C; 143 stopped by a signal."
    ),
)
for panel, verbs in {
    MAKE: (ingest, articulate, fetch, library, scenes, families, objects, textures, init, make),
    LOOK: (view, preview, report, find, categories),
    JUDGE: (review, check, checks, doctor),
    HAND_ON: (export, schemas),
}.items():
    for verb in verbs:
        if isinstance(verb, typer.Typer):
            app.add_typer(verb, rich_help_panel=panel)
        else:
            app.command(cls=Verb, rich_help_panel=panel)(verb)
# The signal that asked to stop, if one did.
_stopping: list[int] = []


def _version(requested: bool) -> None:
    if requested:
        typer.echo(f"casa-assets {__version__}")
        raise typer.Exit


@app.callback()
def common(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Simulation-ready kitchens and assets as MJCF and USD, each with a picture and the results of its checks."""


def main() -> None:
    """Entry point; exit code 0 or 1 is the verb's answer, 2 misuse or a broken machine, 3 a bug, 130 Ctrl-C."""
    sys.exit(supervised(run, print_error))


def run() -> int:
    """The command line in this process; returns its exit code. The only place that turns errors into codes."""
    for number in SIGNALS:
        signal.signal(number, _on_signal)
    # Names of strangers may hold what the terminal's encoding lacks.
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    keep_from_mujoco()
    # No record of a large library is in a cycle: to look for cycles among them took a third of a run.
    gc.set_threshold(100_000, 20, 20)
    try:
        unblock()
        return _run_app()
    except StopRequested as stop:
        return EXIT_SIGNAL_BASE + int(stop.args[0])


def narrowed(whole: typer.Typer, words: Sequence[str]) -> typer.Typer:
    """The app with nothing but the command that the first words name, if they do: to make all takes half of a start."""
    first = words[0] if words else ""
    commands = [one for one in whole.registered_commands if command_name(one) == first]
    groups = [one for one in whole.registered_groups if one.typer_instance and one.typer_instance.info.name == first]
    if not commands and not groups:
        return whole
    found = copy(whole)
    found.registered_commands, found.registered_groups = commands, [copy(one) for one in groups]
    for group in found.registered_groups:
        assert group.typer_instance is not None
        group.typer_instance = narrowed(group.typer_instance, words[1:])
    return found


def command_name(command: CommandInfo) -> str:
    """The word by which a command is called."""
    return command.name or get_command_name(command.callback.__name__ if command.callback else "")


def _run_app() -> int:
    is_completion = any(name.endswith("_COMPLETE") for name in os.environ)  # it asks for what the words could become
    try:
        (app if is_completion else narrowed(app, sys.argv[1:]))()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    except CasaError as error:
        print_error("error:", str(error))
        return EXIT_MISUSE
    except BatchFault as fault:
        if fault.traces:
            sys.stderr.write(f"{fault.traces.rstrip()}\n")
        print_error("bug:", f"{fault}; please report it with the traces of those")
        return EXIT_FAULT
    except OSError as error:
        if error.errno not in ACCESS_ERRNOS:
            return _report_crash()
        place = f"{error.filename}: " if error.filename else ""
        print_error(
            "error:", f"{place}{error.strerror}; look at rights and at the room on the disk, or name another place"
        )
        return EXIT_MISUSE
    except Exception:  # noqa: BLE001  exit code 1 would say that inputs were rejected
        return _report_crash()
    return 0


def _report_crash() -> int:
    if _stopping:
        return EXIT_FAULT  # an error of what the signal interrupted; the supervisor reports the signal
    traceback.print_exc()
    print_error("bug:", "this is a fault of the program; please report it with the lines above")
    return EXIT_FAULT


def _on_signal(number: int, _: FrameType | None) -> NoReturn:
    for again in SIGNALS:
        signal.signal(again, signal.SIG_IGN)  # a second signal must not interrupt the cleaning up
    _stopping.append(number)
    sys.unraisablehook = lambda _: None  # the supervisor prints the one line about the signal
    raise StopRequested(number)


def supervised(work: Callable[[], int], report: Callable[[str, str], None]) -> int:
    """Run `work` in a child process and end with its exit code, or 128 + signal number if a signal stopped it.

    A handler of Python waits for the native call that is under way, which may take minutes. So the verbs run in a
    child of a process that does nothing but wait: if it is asked to stop, it passes the signal on. It then ends the
    child, with all processes that the child started, if they have not ended by themselves soon after.

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
    # The last two: stopped by somebody who knew its number.
    by = stop if stop and code not in (0, 1, 2) else -code if -code in SIGNALS else code - 128
    if by in SIGNALS:
        report("stopped;", "the same command goes on from here")
        return 128 + by
    if code == -signal.SIGKILL:
        report("error:", "the system ended the program, perhaps for want of memory; the same command goes on from here")
        return 2
    if code < 0:
        name = signal.Signals(-code).name
        report("bug:", f"the program was ended by {name}: this is a fault of the program; please report it")
        return 3
    return code


def _prctl(option: int, value: int) -> None:
    ctypes.CDLL(None).prctl(option, value)


if __name__ == "__main__":
    main()
