"""casa-assets export: a library in the form that a runtime reads."""

from __future__ import annotations

import json
from collections import Counter
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from casa_assets.cli.progress import bar
from casa_assets.cli.text import pluralize, terminal_safe

if TYPE_CHECKING:
    from casa_assets.pipeline.export_robocasa import ExportResult

app = typer.Typer(name="export", help="A library in the form that a runtime reads.", no_args_is_help=True)

EXAMPLES = """
Examples:

  casa-assets export robocasa out/library --out out/robocasa      models, categories, splits, and how to add them

  casa-assets export robocasa lib --out ours --registry acme      under a registry of another name

  casa-assets export robocasa lib --out ours --json > rows.jsonl  one JSON object per asset
"""


@app.callback()
def common() -> None:
    """A library in the form that a runtime reads."""


def robocasa(
    library: Annotated[
        Path, typer.Argument(help="Library that ingest wrote.", exists=True, file_okay=False, readable=True)
    ],
    out: Annotated[Path, typer.Option(help="Folder to write: missing, empty, or an earlier export.")],
    registry: Annotated[str, typer.Option(help="Name of the object registry, and of the folder below objects/.")] = (
        "casa"
    ),
    json_: Annotated[bool, typer.Option("--json", help="One JSON object per asset on standard output.")] = False,
) -> None:
    """Write the loose objects of a library as RoboCasa v0.2 and v1.0 read them; exit 0, or 2 with OUT as it was."""
    from casa_assets.pipeline.export_robocasa import export

    results: list[ExportResult] = []
    with bar(Console(stderr=True)) as progress, closing(export(library, out, registry)) as running:
        task = progress.add_task("reading", total=None)
        for result in running:
            results.append(result)
            progress.update(
                task, total=result.total, completed=len(results), description=escape(terminal_safe(result.id))
            )
    if json_:
        for result in results:
            row = {name: value for name, value in vars(result).items() if name != "total"}
            typer.echo(json.dumps({"status": "exported" if result.model else "left_out", **row}, sort_keys=True))
        return
    _print_results(results, out)


robocasa.__doc__ = f"{robocasa.__doc__}\n{EXAMPLES}"
app.command()(robocasa)


def _print_results(results: list[ExportResult], out: Path, max_rows: int = 40) -> None:
    console = Console()
    written = [result for result in results if result.model]
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for name in ("category", "train", "test"):
        table.add_column(name, justify="left" if name == "category" else "right")
    counts = Counter((result.category, result.split) for result in written)
    kinds = sorted({result.category for result in written})
    for kind in kinds[:max_rows]:
        table.add_row(kind, str(counts[kind, "train"] or ""), str(counts[kind, "test"] or ""))
    if len(kinds) > max_rows:
        table.add_row(f"... and {len(kinds) - max_rows} more", "", "")
    console.print(table)
    for result in results:
        if not result.model:
            line = f"[yellow]left out[/] {escape(terminal_safe(result.id))}: {escape(terminal_safe(result.message))}"
            console.print(line, highlight=False, soft_wrap=True)
    place = escape(terminal_safe(str(out)))
    message = f"{pluralize(len(written), 'object')} in {pluralize(len(kinds), 'category')}"
    console.print(f"{message}; read {place}/README.md for how to add them", highlight=False, soft_wrap=True)
