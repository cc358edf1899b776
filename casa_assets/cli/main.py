"""The Typer app and its verbs."""

from __future__ import annotations

import errno
import gc
import os
import signal
import sys
import traceback
from collections.abc import Sequence
from copy import copy
from types import FrameType
from typing import Annotated, NoReturn

import typer
from typer.main import get_command_name
from typer.models import CommandInfo

from casa_assets import __version__
from casa_assets.cli.group import Group, Verb, print_error
from casa_assets.cli.supervise import SIGNALS, StopRequested, supervised, unblock
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
from casa_assets.errors import BatchFault, CasaError
from casa_assets.show.stills import keep_from_mujoco

EXIT_MISUSE, EXIT_FAULT, EXIT_SIGNAL_BASE = 2, 3, 128
# What a file, a folder or a disk refuses, and no fault of the program: rights, room, or a name that cannot be.
ACCESS_ERRNOS = frozenset(
    {errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EMFILE, errno.ENFILE}
    | {errno.ENOTDIR, errno.EISDIR, errno.ENAMETOOLONG}
)

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
    # No record of a large library is in a cycle: to look for cycles among so many took a third of a run.
    gc.set_threshold(100_000, 20, 20)
    try:
        unblock()
        return _run_app()
    except StopRequested as stop:
        return EXIT_SIGNAL_BASE + int(stop.args[0])


def narrowed(whole: typer.Typer, words: Sequence[str]) -> typer.Typer:
    """The app with nothing but the command that the first words name; the whole app if they name none.

    Typer makes all commands with all their options before it looks at the words, which takes half the time of a start.
    """
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


# The signal that asked to stop, if one did.
_stopping: list[int] = []


def _on_signal(number: int, _: FrameType | None) -> NoReturn:
    for again in SIGNALS:
        signal.signal(again, signal.SIG_IGN)  # a second signal must not interrupt the cleaning up
    _stopping.append(number)
    sys.unraisablehook = lambda _: None  # the supervisor prints the one line about the signal
    raise StopRequested(number)


if __name__ == "__main__":
    main()
