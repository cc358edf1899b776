"""casa-assets report: a page about a library."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from casa_assets.cli.options import CLIP_HELP, IN_3D_HELP, OUT_HELP, Library, library_at, more, shared
from casa_assets.cli.output import Output, bar

if TYPE_CHECKING:
    from casa_assets.library.library import Library as LibraryFolder
    from casa_assets.show.page.page_models import PageModels
    from casa_assets.show.reports.gate import Condition
    from casa_assets.show.reports.library_page import WrittenReport


Junit = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Write JUnit XML too: a test case for each input and condition.")
]
Page = Annotated[Path | None, typer.Option(help=more(OUT_HELP, "report.html in the library by default."))]
Baseline = Annotated[
    Path | None, typer.Option(help="Earlier report.json or library; lists what is better, worse, new or gone.")
]
Sarif = Annotated[Path | None, typer.Option(metavar="FILE", help="Write SARIF 2.1.0 too, which code scanning shows.")]


@shared
def report(
    output: Output,
    library: Library = Path("out/library"),
    out: Page = None,
    baseline: Baseline = None,
    fail_on: Annotated[
        list[str] | None,
        typer.Option(help="Exit 1 if this holds: 'rejected-rate>5%', 'worse', 'FLT005', ...; may be repeated."),
    ] = None,
    junit: Junit = None,
    sarif: Sarif = None,
    clip_weights: Annotated[str, typer.Option(help=more(CLIP_HELP, "compares pictures first."))] = "",
    in_3d: Annotated[
        bool, typer.Option("--3d/--no-3d", help=more(IN_3D_HELP, "about 0.1 MB each, written once."))
    ] = False,
) -> None:
    """Write a page about a library, report.html, with every input in it, and report.json beside it.

    Counts by category, source and reason; sizes and masses against the usual ones. Up to 400 inputs the page holds
    pictures and all checks; of more it shows the pictures in the library and what did not pass, and it lists the 5,000
    that should be looked at first.

    --fail-on takes a count (entries, accepted, review, rejected, advice, not-run, size-outliers, mass-outliers, and
    with --baseline better, worse, appeared, gone), a share of it (rejected-rate), or the code of a check, alone or
    followed by >, >=, < or <= and a number. --json prints report.json, with a verdict. Exit 0 when the page is written,
    1 where a condition holds, 2 on misuse.

    Example:  casa-assets report --fail-on 'rejected-rate>5%' --fail-on 'review>0'
    """
    from casa_assets.runs.outcome import writing
    from casa_assets.show.reports.gate import parse
    from casa_assets.show.reports.library_page import CiFiles, write

    if out is not None and out.suffix.lower() != ".html":
        raise typer.BadParameter(f"{out} is no page: name a file that ends in .html", param_hint="--out")
    conditions: list[Condition] = []
    if fail_on:
        from casa_assets.show.reports.checks_page import codes  # here, since it loads all checks

        conditions = [parse(text, codes()) for text in fail_on]
    if baseline is None and any(one.needs_baseline for one in conditions):
        raise typer.BadParameter("compares with an earlier run; give one with --baseline", param_hint="--fail-on")
    target = out or library / "report.html"
    _compare_all(library_at(library), clip_weights)
    with writing(target.parent):
        models = _write_models(library, target, output) if in_3d else None
        written = write(library, target, baseline, conditions, models, CiFiles(junit, sarif))
    _tell(written, library, output)


def _tell(written: WrittenReport, library: Path, output: Output) -> None:
    """Print what became of the conditions, and where the report is. Raises typer.Exit where a condition holds."""
    if output.as_json:
        content = json.loads(written.json.read_text(encoding="utf-8"))
        verdict = "failed" if any(outcome.holds for outcome in written.outcomes) else "passed"
        output.made(library.resolve().name, written.page.parent, verdict=verdict, page=str(written.page), **content)
    for outcome in written.outcomes:
        console = output.failures if outcome.holds else output.console
        mark = f"[{'red' if outcome.holds else 'green'}]{outcome.mark}[/]"
        console.print(f"{mark} {escape(str(outcome))}", highlight=False, soft_wrap=True)
    output.line(f"JSON:   {written.json}")
    output.line(f"Report: {written.page}")
    output.look_at_file(written.page)
    if any(outcome.holds for outcome in written.outcomes):
        raise typer.Exit(1)


def _compare_all(library: LibraryFolder, clip_weights: str) -> None:
    """Run the checks of all assets together, where they never ran, or where CLIP is to look at the pictures first."""
    from casa_assets.library import library_report
    from casa_assets.library.clip import load_clip
    from casa_assets.library.entry_table import EntryTable
    from casa_assets.runs.outcome import writing

    if clip_weights or library_report.read_library_report(library.root) is None:
        model = load_clip(clip_weights) if clip_weights else None
        with library.locked(), writing(library.root):
            library_report.compare_library(library, EntryTable(library), model)


def _write_models(library: Path, target: Path, output: Output) -> PageModels:
    from casa_assets.show.page.page_models import models_of, write_models

    with bar(output.console) as progress:
        task = progress.add_task("models", total=None)
        for done, total in write_models(library, target):
            progress.update(task, total=total, completed=done)
    return models_of(target)
