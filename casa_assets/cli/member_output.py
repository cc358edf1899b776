"""Print the outcomes of building members of families and of objects."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import typer

from casa_assets.cli.output import Output, measures_at
from casa_assets.cli.progress import working_on
from casa_assets.cli.tables import TextTable
from casa_assets.errors import BatchFault

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from casa_assets.model.issue import Report
    from casa_assets.pipeline.families.run import FamilyRequest, FamilyResult

# Problems of one check that are printed; the library keeps all of them.
MAX_TOLD = 12


def follow(running: Iterable[FamilyResult], requests: Sequence[FamilyRequest], output: Output) -> list[FamilyResult]:
    """Print each member that failed, and as JSON or in many words each, as it is done; returns all."""
    results: list[FamilyResult] = []
    with working_on(output.console, "building", [request.title for request in requests]) as done:
        for result in running:
            results.append(result)
            done(result.request.title)
            print_result(result, output)
    return results


def look(results: Sequence[FamilyResult], output: Output) -> None:
    """Print the command that shows the first member that passed."""
    output.look(*[result.folder for result in results if result.passed][:1])


def end(results: Sequence[FamilyResult]) -> None:
    """End with the exit code of a run: raises BatchFault after faults of the program, exit 1 where some failed."""
    if faults := [result.request.title for result in results if result.is_fault]:
        raise BatchFault(faults)
    if not all(result.passed for result in results):
        raise typer.Exit(1)


def json_row(result: FamilyResult) -> dict[str, object]:
    """What `--json` tells of a member."""
    return {
        "member": result.request.title,
        "id": result.asset_id,
        "folder": result.folder,
        "verdict": "passed" if result.passed else "failed",
        **measures_at(result.folder if result.passed else None),
        "passed": result.passed,
        "kept": result.is_kept,
        "message": result.message,
        "issues": [{"code": i.code, "pointer": i.pointer, "message": i.message} for i in result.problems],
        "build_s": round(result.build_s, 4),
        "write_s": round(result.write_s, 4),
        "draw_s": round(result.draw_s, 4),
        "check_s": round(result.check_s, 4),
        "cpu_s": round(result.cpu_s, 4),
        "bytes": result.size_bytes,
    }


def print_result(result: FamilyResult, output: Output, always: bool = False) -> None:
    """Print whether a member passed, how long it took, and every issue.

    Args:
        always: also of a member that passed, where the user did not ask for more words.
    """
    output.row(json_row(result))
    if result.passed and not (always or output.verbose):
        return
    console = output.console if result.passed else output.failures
    mark = "[green]passed[/]" if result.passed else "[red]failed[/]"
    seconds = f"build {result.build_s:.2f} s, write {result.write_s:.2f} s, check {result.check_s:.2f} s"
    where = f" {result.asset_id} ({seconds}, {result.size_bytes / 1e6:.2f} MB)" if result.asset_id else ""
    console.print(f"{mark} [bold]{result.request.title}[/]{where}", highlight=False, soft_wrap=True)
    for line in (result.message, *(f"  {i.code} {i.pointer}: {i.message}" for i in result.problems)):
        if line:
            console.print(line, markup=False, highlight=False, soft_wrap=True)


def print_summary(results: Sequence[FamilyResult], output: Output) -> None:
    """Print a table of medians, a row for each family or category."""
    from casa_assets.pipeline.families.run import summary

    names = ("family", "passed", "of", "build s", "write s", "draw s", "check s", "CPU s", "MB")
    table = TextTable(names, right=names[1:], title="median per member")
    for row in summary(list(results)):
        table.add(*row)
    table.print(output.console)
    if kept := sum(result.is_kept for result in results):
        output.line(f"{kept} of {len(results)} were there already and stay as they are")


def print_together(report: Report, titles: Mapping[str, str], output: Output) -> None:
    """Print what the checks of all members together found, the first few problems of each.

    Args:
        report: of a library. titles: code -> title of the checks that are told.
    """
    for result in report.results:
        if result.code not in titles:
            continue
        number = result.reason if result.number is None else f"{result.number:.3g} (limit {result.limit:g})"
        output.line(f"{result.code} {titles[result.code]}: {result.status.value}, {number}")
        found = [issue for issue in report.issues if issue.code == result.code]
        for issue in found if output.verbose else found[:MAX_TOLD]:
            output.line(f"  {issue.pointer}: {issue.message}")
        if len(found) > MAX_TOLD and not output.verbose:
            output.line(f"  and {len(found) - MAX_TOLD} more, in library.json")
