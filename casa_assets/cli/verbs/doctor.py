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
    """Print what is wrong, then what else there is to say; optional packages and those that are here on a line each."""
    wrong = [finding for finding in found if finding.needed and not finding.ok]
    rest = [finding for finding in found if finding not in wrong]
    notes = [finding for finding in rest if not finding.ok]
    for finding in wrong:
        _print_line(finding, output)
    if output.verbose:
        for finding in rest:
            _print_line(finding, output)
        return
    packages = [finding for finding in rest if finding.subject.startswith(PACKAGE)]
    for finding in notes:
        if finding not in packages and not _is_noise(finding, found):
            _print_line(finding, output)
    names = [finding.subject.removeprefix(PACKAGE) for finding in packages if not finding.ok]
    if names:
        words = f"optional, not installed or of another version: {', '.join(names)}; --verbose says more"
        output.console.print(_line("note", "yellow", "packages", words), soft_wrap=True, highlight=False)
    here = sum(finding.ok for finding in packages)
    if here:
        output.console.print(_line("ok", "green", "packages", f"{here} are here"), highlight=False)
    for finding in rest:
        if finding.ok and finding not in packages and not _is_noise(finding, found):
            _print_line(finding, output)


def _is_noise(finding: Finding, found: Sequence[Finding]) -> bool:
    """True for single renderers where there is one that draws."""
    return finding.subject.startswith(RENDERER) and any(f.ok for f in found if f.subject.startswith(RENDERER))


def _print_line(finding: Finding, output: Output) -> None:
    mark = ("ok", "green") if finding.ok else ("MISSING", "bold red") if finding.needed else ("note", "yellow")
    fix = f"; run: {finding.fix}" if finding.fix and not finding.ok else ""
    line = _line(*mark, finding.subject.removeprefix(PACKAGE), f"{finding.message}{fix}")
    console = output.failures if finding.needed and not finding.ok else output.console
    console.print(line, soft_wrap=True, highlight=False)


def _line(mark: str, style: str, subject: str, words: str) -> Text:
    return Text.assemble((f"{mark:8}", style), f"{subject:{SUBJECT_WIDTH}}  ", words)
