"""casa-assets checks: print the table of checks and rejections."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table


def checks(
    as_markdown: Annotated[bool, typer.Option("--markdown", help="As docs/reference/checks.md has it.")] = False,
) -> None:
    """List every check: its code, what it tests, and what to do where it fails."""
    from casa_assets import registry
    from casa_assets.checks.table.table import TABLE
    from casa_assets.pipeline.reports.checks_page import checks_markdown

    if as_markdown:
        typer.echo(checks_markdown(), nl=False)
        return
    limits = registry.load().limits
    table = Table("code", "title", "severity", "limit", "what is tested, and what to do", show_lines=False)
    for row in TABLE:
        limit = f"{limits[row.limit]:g} {row.unit}".strip() if row.limit else ""
        table.add_row(row.code, row.title, row.severity.value, limit, row.describe(limits))
    Console().print(table)
