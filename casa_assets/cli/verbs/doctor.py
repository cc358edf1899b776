"""`casa-assets doctor`: what this machine has and lacks, and the command that fixes it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.text import Text

from casa_assets.cli.options import OUT_HELP, AsJson, Quiet, Verbose, more
from casa_assets.cli.output import Output

if TYPE_CHECKING:
    from collections.abc import Sequence

    from casa_assets.pipeline.doctor import Finding

PACKAGE, RENDERER = "package ", "renderer "
SUBJECT_WIDTH = 16


def doctor(
    out: Annotated[
        Path, typer.Option("--out", help=more(OUT_HELP, "this folder is tested, nothing stays in it."))
    ] = Path("out"),
    json_: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Test this machine (Python, packages, rendering, disk), and print the command that installs what is missing.

    Exit 0 when all that is needed is here, 1 when something is missing, 2 on misuse. What is optional and missing is a
    note, and does not change the exit code.

    Example:  casa-assets doctor --verbose
    """
    from casa_assets.pipeline.doctor import findings

    output = Output(json_, quiet, verbose)
    found = findings(out)
    missing = [finding for finding in found if finding.needed and not finding.ok]
    for finding in found:
        output.row({"id": finding.subject, "verdict": _verdict(finding), **finding.model_dump(mode="json")})
    if not json_:
        _print(found, output)
    if missing:
        output.wrong(f"Needed and missing: {', '.join(finding.subject for finding in missing)}.")
        raise typer.Exit(1)
    output.line("Everything that is needed is here.")


def _verdict(finding: Finding) -> str:
    return "passed" if finding.ok else "failed" if finding.needed else "note"


def _print(found: Sequence[Finding], output: Output) -> None:
    """Print a line for each thing; what is as it should be among many of a kind is counted, or listed where asked."""
    here = [finding for finding in found if finding.subject.startswith(PACKAGE) and finding.ok]
    for finding in found:
        if output.verbose or not _is_noise(finding, found):
            _print_line(finding, output)
        elif here and finding is here[-1]:
            output.console.print(_line("ok", "green", "packages", f"{len(here)} are here"), highlight=False)


def _is_noise(finding: Finding, found: Sequence[Finding]) -> bool:
    """True for a package that is here, and for single renderers where there is one that draws."""
    if finding.subject.startswith(PACKAGE):
        return finding.ok
    return finding.subject.startswith(RENDERER) and any(f.ok for f in found if f.subject.startswith(RENDERER))


def _print_line(finding: Finding, output: Output) -> None:
    mark = ("ok", "green") if finding.ok else ("MISSING", "bold red") if finding.needed else ("note", "yellow")
    fix = f"; run: {finding.fix}" if finding.fix and not finding.ok else ""
    line = _line(*mark, finding.subject.removeprefix(PACKAGE), f"{finding.message}{fix}")
    console = output.failures if finding.needed and not finding.ok else output.console
    console.print(line, soft_wrap=True, highlight=False)


def _line(mark: str, style: str, subject: str, words: str) -> Text:
    return Text.assemble((f"{mark:8}", style), f"{subject:{SUBJECT_WIDTH}}  ", words)
