"""casa-assets check, doctor, review: what assets fail, what this machine lacks, what a person has to decide."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.text import Text

from casa_assets.cli import completion
from casa_assets.cli.options import LIBRARY_HELP, OUT_HELP, Browser, Port, library_at, more, shared
from casa_assets.cli.output import Output, measures_at, pluralize

if TYPE_CHECKING:
    from collections.abc import Sequence

    from casa_assets.cli.doctor import Finding


@shared
def check(
    output: Output,
    folders: Annotated[
        list[Path],
        typer.Argument(
            help="Folders of assets or kitchens.", exists=True, file_okay=False, autocompletion=completion.things
        ),
    ],
) -> None:
    """Run every check that applies on assets or kitchens in their folders; nothing is written.

    It finds what was changed by hand since they were made. `checks CODE` explains a code. Exit 0 when all pass, 1 when
    one does not, 2 on misuse.

    Example:  casa-assets check out/library/mug/mug_0123456789
    """
    from casa_assets.api.assets import check_folder

    failed = False
    for folder in folders:
        report = check_folder(folder)
        failed |= not report.passed
        verdict = "passed" if report.passed else "failed"
        facts = report.model_dump(mode="json", exclude={"subject"})
        output.made(report.subject, folder, measures_at(folder), verdict, **facts)
        for result in report.results if not output.as_json else ():
            number = result.reason if result.number is None else f"{result.number:.4g} {result.unit}".rstrip()
            output.detail(f"{result.code} {result.status.value}: {number}".removesuffix(": "))
        say = output.line if report.passed else output.wrong
        for issue in report.issues if not output.as_json else ():
            word = "advice" if issue.severity.value == "warning" else "error"
            say(f"{word} {issue.code} {issue.pointer}: {issue.message}")
        if not output.as_json:
            say(f"{verdict} {report.subject}: {report.tally}")
    if failed:
        raise typer.Exit(1)


PACKAGE, RENDERER = "package ", "renderer "
SUBJECT_WIDTH = 16


@shared
def doctor(
    output: Output,
    out: Annotated[
        Path, typer.Option("--out", help=more(OUT_HELP, "this folder is tested, nothing stays in it."))
    ] = Path("out"),
) -> None:
    """Test this machine (Python, packages, rendering, disk), and print the command that installs what is missing.

    Exit 0 when all that is needed is here, 1 when something is missing, 2 on misuse. What is optional and missing is a
    note, and does not change the exit code.

    Example:  casa-assets doctor --verbose
    """
    from casa_assets.cli.doctor import findings

    found = findings(out)
    missing = [finding for finding in found if finding.needed and not finding.ok]
    for finding in found:
        output.row({"id": finding.subject, "verdict": _verdict(finding), **finding.model_dump(mode="json")})
    if not output.as_json:
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


def review(
    library: Annotated[Path, typer.Argument(help=LIBRARY_HELP, exists=True, file_okay=False)] = Path("out/library"),
    port: Port = 0,
    browser: Browser = True,
) -> None:
    """Open a page on which you decide about assets in review: accept, reject, correct category, pose, size and mass.

    Each decision is written to review.csv of the library at once; the next `casa-assets ingest` applies it. Articulated
    meshes have a page of their own, on which parts are corrected too; `casa-assets articulate` applies review.json,
    which that page writes. Only this machine can open the pages; Ctrl-C ends them.
    Exit 0 when nothing is left to decide, 2 on misuse, 130 after Ctrl-C.

    Example:

      casa-assets review out/library
    """
    from casa_assets.errors import OutputError
    from casa_assets.runs.outcome import writing
    from casa_assets.show.local_server import open_in_browser
    from casa_assets.show.review import ARTICULATED, ReviewServer

    console = Console(soft_wrap=True, highlight=False)
    place = library_at(library)
    with writing(library):
        try:
            server = ReviewServer(place, port)
        except OverflowError as error:
            raise OutputError(str(port), "is no port; give one from 1024 to 65535") from error
        with server:
            pages = []
            if server.waiting:
                console.print(f"{pluralize(len(server.waiting), 'input')} to decide about: {server.address}")
                pages.append(server.address)
            if server.articulated:
                pages.append(f"{server.address}{ARTICULATED}")
                console.print(f"{pluralize(len(server.articulated), 'articulated mesh')}: {pages[-1]}")
            if not pages:
                console.print("nothing is in review")
                return
            console.print("Ctrl-C ends it; then run the same command on the same sources again")
            for page in pages if browser else ():
                open_in_browser(page)
            server.serve_forever()
