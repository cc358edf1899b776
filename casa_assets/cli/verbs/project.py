"""`casa-assets init` and `casa-assets make`: a user's project, and all that it makes."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from casa_assets.cli.options import DryRun, shared
from casa_assets.cli.output import Output
from casa_assets.projects import project_folder

if TYPE_CHECKING:
    from casa_assets.cli.project_runs import Step

VERDICTS = {0: "done", 4: "review"}  # of a run by its exit code; any other: failed
FAILED = (2, 3)  # exit codes after which the next command would fail too: misuse or a broken machine, a fault


@shared
def init(
    output: Output,
    folder: Annotated[Path, typer.Argument(help="Where the project is to be; the folder is made if it is missing.")],
) -> None:
    """Write a small working project: a plan, a style, textures, a category, objects, and what `make` makes of them.

    A project is a folder with a casa.yaml. Its files add to those of casa-assets, or replace them, for every command
    that is called in it. Exit 0 when it was written, 2 on misuse.

    Example:  casa-assets init my_kitchens
    """
    from casa_assets.cli.project.starter import write_starter
    from casa_assets.runs.outcome import writing

    with writing(folder):
        paths = write_starter(folder)
    for path in paths:
        output.made(path.relative_to(folder).as_posix(), path.parent)
        output.line(str(path))
    if not output.as_json and not output.quiet:
        output.error(f"Make what it describes: cd {shlex.quote(str(folder))} && casa-assets make")


@shared
def make(
    output: Output,
    dry_run: DryRun = False,
) -> None:
    """Call the commands that the project lists under `runs` in its casa.yaml, one after the other, in its folder.

    What an earlier call made and has not changed is kept. With --json each command prints its rows, followed by
    one row for the command. Exit 0 when all ended with 0, 1 when something was rejected or failed, 4 when a
    person has to decide, 2 on misuse or a broken machine: the commands behind are not called then.

    Example:  casa-assets make --project my_kitchens
    """
    from casa_assets.cli.main import app
    from casa_assets.cli.project_runs import steps_of
    from casa_assets.errors import CasaError
    from casa_assets.projects import SETTINGS
    from casa_assets.registry.read import load_project

    found = load_project()
    if found is None:
        raise CasaError(f"no {SETTINGS} here or above; write a project with `casa-assets init DIR`, or name one")
    steps = steps_of(*found, typer.main.get_command(app))
    if not steps:
        raise CasaError(f"{found[1].file}: lists no runs")
    codes = []
    for step in steps:
        words = shlex.join(("casa-assets", *step.words))
        if dry_run:
            output.row({"id": words, "verdict": "planned"})
            output.line(words)
            continue
        output.console.rule(words, align="left")
        codes.append(_call(step, output))
        output.row({"id": words, "verdict": VERDICTS.get(codes[-1], "failed"), "exit_code": codes[-1]})
        if codes[-1] in FAILED or codes[-1] < 0:
            break
    raise typer.Exit(_worst(codes))


def _call(step: Step, output: Output) -> int:
    """Call a command in a separate process, in the folder of the project; returns its exit code."""
    extra = [*(["--json"] if output.as_json and step.takes_json else []), *(["--quiet"] if output.quiet else [])]
    folder = project_folder()
    end = step.words.index("--") if "--" in step.words else len(step.words)
    words = (*step.words[:end], *extra, *step.words[end:])
    return subprocess.run((sys.executable, "-m", "casa_assets.cli.main", *words), cwd=folder, check=False).returncode


def _worst(codes: list[int]) -> int:
    """The exit code of all: a fault before misuse before rejections before decisions to be taken."""
    order = (3, 2, 1, 4, 0)
    known = [code if code in order else 3 if code < 0 else code for code in codes]
    return next((code for code in known if code not in order), next((code for code in order if code in known), 0))
