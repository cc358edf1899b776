"""casa-assets checks: print the table of checks, or what single codes mean."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from casa_assets.cli.options import AsJson
from casa_assets.cli.output import Output
from casa_assets.cli.tables import TextTable

if TYPE_CHECKING:
    from casa_assets.pipeline.reports.checks_page import CodeFacts

# What becomes of a subject for which a check fails.
EFFECTS = {
    "error": "error: what fails is kept out of the library",
    "warning": "warning: advice that is kept with the asset",
    "rejection": "rejection: the input was not taken",
}


def checks(
    codes: Annotated[
        list[str] | None, typer.Argument(help="Codes of reports, such as USD002; none: all checks.")
    ] = None,
    as_markdown: Annotated[
        bool, typer.Option("--markdown", help="Print Markdown, as in docs/reference/checks.md.")
    ] = False,
    json_: AsJson = False,
) -> None:
    """List every check, or explain codes of a report: what is tested, its limit, and what to do when it fails.

    Exit 0 when it is printed, 2 when there is no such code.

    Examples:

      casa-assets checks
      casa-assets checks USD002 FLT005
    """
    from casa_assets.errors import UnknownId
    from casa_assets.pipeline.reports.checks_page import check_facts, checks_markdown, every_code

    if as_markdown:
        typer.echo(checks_markdown(), nl=False)
        return
    known = every_code() if codes else {}
    wanted = [code.upper() for code in codes or ()]
    for code in wanted:
        if code not in known:
            raise UnknownId("code", code, known, "`casa-assets checks` lists them")
    output = Output(json_)
    found = [known[code] for code in wanted] or list(check_facts())
    for facts in found:
        row = asdict(facts)
        output.row({"id": row.pop("code"), **row})
    if not json_:
        _print_each(found, output) if wanted else _print_table(found, output)


def _print_each(found: list[CodeFacts], output: Output) -> None:
    """Print what each code means, line by line."""
    for facts in found:
        output.line(f"{facts.code}  {facts.title}")
        lines = {"severity": EFFECTS[facts.severity], "looks at": facts.subject, "limit": _limit(facts)}
        for name, words in lines.items():
            if words:
                output.line(f"  {name + ':':10} {words}")
        output.line(f"  {facts.about}")


def _print_table(found: list[CodeFacts], output: Output) -> None:
    about = "what is tested, and what to do"
    table = TextTable(("code", "title", "severity", "limit", about), sentences=("title", about))
    for facts in found:
        table.add(facts.code, facts.title, facts.severity, _limit(facts), facts.about)
    table.print(output.console)


def _limit(facts: CodeFacts) -> str:
    return "" if facts.limit is None else f"{facts.limit:g} {facts.unit}".strip()
