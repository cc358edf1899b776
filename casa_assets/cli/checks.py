"""casa-assets checks: print the table of checks and rejections."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table


def checks(
    as_markdown: Annotated[bool, typer.Option("--markdown", help="As docs/checks.md has it.")] = False,
) -> None:
    """List every check that an asset must pass, with its code and why it matters."""
    from casa_assets.checks.table import TABLE
    from casa_assets.pipeline.books.check_docs import markdown

    if as_markdown:
        typer.echo(markdown(), nl=False)
        return
    table = Table("code", "severity", "looks at", "limit", "why")
    for row in TABLE:
        table.add_row(row.code, row.severity.value, row.subject.__name__, row.limit or "", row.why)
    Console().print(table)
