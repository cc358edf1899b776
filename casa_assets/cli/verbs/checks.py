"""casa-assets checks: print the table of checks and rejections."""

from __future__ import annotations

from typing import Annotated

import typer

from casa_assets.cli.options import AsJson
from casa_assets.cli.output import Output
from casa_assets.cli.tables import TextTable


def checks(
    as_markdown: Annotated[
        bool, typer.Option("--markdown", help="Print Markdown, as in docs/reference/checks.md.")
    ] = False,
    json_: AsJson = False,
) -> None:
    """List every check: its code, what it tests, and what to do when it fails.

    Exit 0.

    Example:  casa-assets checks --json
    """
    from casa_assets import registry
    from casa_assets.pipeline.reports.checks_page import checks_markdown
    from casa_assets.registry.plugins.checks import check_table, with_plugin_limits

    if as_markdown:
        typer.echo(checks_markdown(), nl=False)
        return
    output, limits = Output(json_), with_plugin_limits(registry.load().limits)
    about = "what is tested, and what to do"
    table = TextTable(("code", "title", "severity", "limit", about), sentences=("title", about))
    for row in check_table():
        value = limits[row.limit] if row.limit else None
        facts = {"title": row.title, "severity": row.severity.value, "limit": value, "unit": row.unit}
        output.row({"id": row.code, **facts, "about": row.describe(limits)})
        limit = "" if value is None else f"{value:g} {row.unit}".strip()
        table.add(row.code, row.title, row.severity.value, limit, row.describe(limits))
    if not json_:
        table.print(output.console)
