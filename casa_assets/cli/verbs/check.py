"""casa-assets check: run every check on assets and kitchens where they are."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from casa_assets.cli import completion
from casa_assets.cli.options import AsJson, Quiet, Verbose
from casa_assets.cli.output import Output, measures_at


def check(
    folders: Annotated[
        list[Path],
        typer.Argument(
            help="Folders of assets or kitchens.", exists=True, file_okay=False, autocompletion=completion.things
        ),
    ],
    json_: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Run every check that applies on assets or kitchens in their folders; nothing is written.

    It finds what was changed by hand since they were made. `checks CODE` explains a code. Exit 0 when all pass, 1 when
    one does not, 2 on misuse.

    Example:  casa-assets check out/library/mug/mug_0123456789
    """
    from casa_assets.api.assets import check as run

    output, failed = Output(json_, quiet, verbose), False
    for folder in folders:
        report = run(folder)
        failed |= not report.passed
        verdict = "passed" if report.passed else "failed"
        facts = report.model_dump(mode="json", exclude={"subject"})
        output.made(report.subject, folder, measures_at(folder), verdict, **facts)
        for result in report.results if not json_ else ():
            number = result.reason if result.number is None else f"{result.number:.4g} {result.unit}".rstrip()
            output.detail(f"{result.code} {result.status.value}: {number}".removesuffix(": "))
        say = output.line if report.passed else output.wrong
        for issue in report.issues if not json_ else ():
            word = "advice" if issue.severity.value == "warning" else "error"
            say(f"{word} {issue.code} {issue.pointer}: {issue.message}")
        if not json_:
            say(f"{verdict} {report.subject}: {report.tally}")
    if failed:
        raise typer.Exit(1)
