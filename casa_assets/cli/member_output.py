"""Print the outcomes of building members of families and of objects."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from casa_assets.errors import BatchFault

if TYPE_CHECKING:
    from collections.abc import Mapping

    from casa_assets.model.issue import Report
    from casa_assets.pipeline.families.run import FamilyResult

# Problems of one check that are printed; the library keeps all of them.
MAX_TOLD = 12


def check_faults(results: list[FamilyResult]) -> None:
    """Raises BatchFault where some were not built by a fault of the program."""
    faults = [r.request.title for r in results if r.is_fault]
    if faults:
        raise BatchFault(faults)


def json_row(result: FamilyResult) -> dict[str, object]:
    """What `--json` tells of a member."""
    return {
        "member": result.request.title,
        "id": result.asset_id,
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


def print_result(result: FamilyResult, console: Console) -> None:
    """Print whether a member passed, how long it took, and every issue."""
    mark = "[green]passed[/]" if result.passed else "[red]failed[/]"
    seconds = f"build {result.build_s:.2f} s, write {result.write_s:.2f} s, check {result.check_s:.2f} s"
    console.print(
        f"{mark} [bold]{result.request.title}[/] {result.asset_id} ({seconds}, {result.size_bytes / 1e6:.2f} MB)"
    )
    if result.message:
        console.print(escape(result.message), highlight=False)
    for issue in result.problems:
        console.print(f"  [bold]{issue.code}[/] {escape(issue.pointer)}: {escape(issue.message)}", highlight=False)


def print_summary(results: list[FamilyResult], console: Console) -> None:
    """Print a table of medians, a row for each family or category."""
    from casa_assets.pipeline.families.run import summary

    table = Table(
        "family", "passed", "of", "build s", "write s", "draw s", "check s", "CPU s", "MB", title="median per member"
    )
    for row in summary(results):
        table.add_row(*row)
    console.print(table)
    if kept := sum(result.is_kept for result in results):
        console.print(f"{kept} of {len(results)} were there already and stay as they are", highlight=False)


def print_together(report: Report, titles: Mapping[str, str], console: Console) -> None:
    """Print what the checks of all members together found, the first few problems of each.

    Args:
        report: of a library. titles: code -> title of the checks that are told.
    """
    for result in report.results:
        if result.code not in titles:
            continue
        number = result.reason if result.number is None else f"{result.number:.3g} (limit {result.limit:g})"
        console.print(
            f"{result.code} {titles[result.code]}: {result.status.value}, {number}", highlight=False, soft_wrap=True
        )
        found = [issue for issue in report.issues if issue.code == result.code]
        for issue in found[:MAX_TOLD]:
            console.print(f"  {escape(issue.pointer)}: {escape(issue.message)}", highlight=False, soft_wrap=True)
        if len(found) > MAX_TOLD:
            console.print(f"  and {len(found) - MAX_TOLD} more, in library.json", highlight=False)
