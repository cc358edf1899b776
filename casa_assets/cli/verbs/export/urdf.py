"""casa-assets export urdf: assets or whole kitchens as URDF."""

from __future__ import annotations

import json
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.markup import escape

from casa_assets.cli.progress import bar
from casa_assets.cli.text import pluralize, terminal_safe

if TYPE_CHECKING:
    from casa_assets.pipeline.export.urdf import UrdfResult

EXAMPLES = """
Examples:

  casa-assets export urdf out/library --out out/urdf               every asset of a library

  casa-assets export urdf out/library/mug/mug_0a1b2c3d4e --out one one asset

  casa-assets export urdf --scenes 'l_small__*' --out kitchens     kitchens, built where they are not kept

  casa-assets export urdf lib --out urdf --json > rows.jsonl       one JSON object per asset or kitchen
"""


def urdf(
    out: Annotated[Path, typer.Option(help="Folder to write: missing, empty, or an earlier export.")],
    source: Annotated[
        Path | None,
        typer.Argument(help="Library, or the folder of one asset in it.", exists=True, file_okay=False, readable=True),
    ] = None,
    scenes: Annotated[list[str] | None, typer.Option(help="Ids or globs of kitchens, such as 'l_small__*'.")] = None,
    jobs: Annotated[int, typer.Option(min=0, help="Processes that build kitchens; 0: one per core.")] = 0,
    with_review: Annotated[
        bool, typer.Option("--with-review", help="Write what a person has to decide about, see review.csv, too.")
    ] = False,
    json_: Annotated[bool, typer.Option("--json", help="One JSON object per asset or kitchen on standard output.")] = (
        False
    ),
) -> None:
    """Write assets or kitchens as URDF and compare what is read back; exit 0, 1 where one was refused, 2, 3."""
    from casa_assets.pipeline.export.urdf import export_assets, export_scenes

    if (source is None) == (not scenes):
        raise typer.BadParameter("give either a library or an asset's folder, or --scenes")
    rows = export_assets(source, out, with_review) if source is not None else export_scenes(scenes or [], out, jobs)
    results: list[UrdfResult] = []
    with bar(Console(stderr=True)) as progress, closing(rows) as running:
        task = progress.add_task("reading", total=None)
        for result in running:
            results.append(result)
            progress.update(
                task, total=result.total, completed=len(results), description=escape(terminal_safe(result.id))
            )
    if json_:
        for result in results:
            row = {"id": result.id, "urdf": result.urdf, "message": result.message}
            status = "exported" if result.urdf else "left_out" if result.is_left_out else "refused"
            typer.echo(json.dumps({"status": status, **row}, sort_keys=True))
    else:
        _print_results(results, out, "asset" if source is not None else "kitchen")
    if not all(result.urdf or result.is_left_out for result in results):
        raise typer.Exit(1)


urdf.__doc__ = f"{urdf.__doc__}\n{EXAMPLES}"


def _print_results(results: list[UrdfResult], out: Path, what: str) -> None:
    console = Console()
    for result in results:
        if not result.urdf:
            word = "[yellow]left out[/]" if result.is_left_out else "[red]refused[/]"
            line = f"{word} {escape(terminal_safe(result.id))}: {escape(terminal_safe(result.message))}"
            console.print(line, highlight=False, soft_wrap=True)
    written = [result for result in results if result.urdf]
    if not written:
        console.print("nothing was written", highlight=False)
        return
    place = escape(terminal_safe(str(out)))
    message = f"{pluralize(len(written), what)} as URDF; read {place}/README.md for how to load them"
    console.print(message, highlight=False, soft_wrap=True)
