"""`casa-assets doctor`: what this machine has and lacks, and the command that fixes it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:
    from casa_assets.pipeline.doctor import Finding


def doctor(
    json_: Annotated[bool, typer.Option("--json", help="Print the findings as JSON.")] = False,
    output: Annotated[Path, typer.Option("--out", "--output", help="Folder that results would be written to.")] = Path(
        "out"
    ),
) -> None:
    """Look at this machine: Python, packages, rendering, disk. Exit code 1 where something needed is missing."""
    from casa_assets.pipeline.doctor import findings

    found = findings(output)
    missing = [finding for finding in found if finding.needed and not finding.ok]
    if json_:
        report = {"ok": not missing, "findings": [finding.model_dump(mode="json") for finding in found]}
        typer.echo(json.dumps(report, indent=2))
    else:
        _print(found, missing)
    raise typer.Exit(1 if missing else 0)


def _print(found: tuple[Finding, ...], missing: list[Finding]) -> None:
    console = Console()
    table = Table("", "what", "found", box=None, pad_edge=False)
    for finding in found:
        mark = ("ok", "green") if finding.ok else ("MISSING", "bold red") if finding.needed else ("note", "yellow")
        table.add_row(Text(*mark), finding.subject, Text(finding.message))
    console.print(table)
    console.print()
    for fix in dict.fromkeys(finding.fix for finding in found if finding.fix):
        subjects = ", ".join(finding.subject for finding in found if finding.fix == fix)
        console.print(Text(f"To fix {subjects}:\n    {fix}"), soft_wrap=True)
    if missing:
        console.print(f"Needed and missing: {', '.join(finding.subject for finding in missing)}.", style="bold red")
    else:
        console.print("Everything that is needed is here.", style="green")
