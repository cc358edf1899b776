"""casa-assets export robocasa: libraries and kitchens as RoboCasa reads them."""

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
    from casa_assets.pipeline.export.robocasa_kitchens import KitchenResult
    from casa_assets.pipeline.export_robocasa import ExportResult

SCENES = Path("out/scenes")  # where finishes are found that the id of a scene has as a digest alone
States = Annotated[
    Path | None,
    typer.Option(help="Folder of scenes whose start states (scenes states) are written too.", file_okay=False),
]
EXAMPLES = """
Examples:

  casa-assets export robocasa out/library --out out/robocasa      models, categories, splits, and how to add them

  casa-assets export robocasa lib --out ours --registry acme      under a registry of another name

  casa-assets export robocasa lib --out ours --json > rows.jsonl  one JSON object per asset

  casa-assets export robocasa --scenes 'l_small__*' --objects lib --out ours    kitchens, and objects to put in them
"""


def robocasa(
    library: Annotated[
        Path | None,
        typer.Argument(help="Library that ingest wrote.", exists=True, file_okay=False, readable=True),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder to write: missing, empty, or an earlier export.")] = ...,  # type: ignore[assignment]
    scenes: Annotated[
        list[str] | None, typer.Option(help="Kitchens: ids or globs, such as 'l_small__*'. May be given again.")
    ] = None,
    objects: Annotated[
        Path | None, typer.Option(help="The library, as an option.", exists=True, file_okay=False, readable=True)
    ] = None,
    registry: Annotated[str, typer.Option(help="Name of the object registry, and of the folder below objects/.")] = (
        "casa"
    ),
    jobs: Annotated[int, typer.Option(min=0, help="Processes that build kitchens; 0: one per core.")] = 0,
    with_review: Annotated[
        bool, typer.Option("--with-review", help="Write what a person has to decide about, see review.csv, too.")
    ] = False,
    states: States = None,
    json_: Annotated[bool, typer.Option("--json", help="One JSON object per asset and kitchen on standard output.")] = (
        False
    ),
) -> None:
    """Write loose objects of a library, and kitchens, as RoboCasa reads them; exit 0, 1 where one was refused, 2, 3.

    Objects are for v0.2 and v1.0, kitchens for v1.0. One that cannot be built is told, and the others are written;
    after 2 or 3 OUT is as it was.
    """
    from casa_assets.pipeline.export.robocasa_kitchens import KitchenResult
    from casa_assets.pipeline.export_robocasa import export
    from casa_assets.pipeline.kitchens.scene_folders import recipes_named

    if library is not None and objects is not None:
        raise typer.BadParameter("give the library once", param_hint="--objects")
    if library is None and objects is None and not scenes:
        raise typer.BadParameter("give a library, --scenes, or both")
    recipes = recipes_named(scenes or [], states or SCENES)
    results: list[ExportResult] = []
    kitchens: list[KitchenResult] = []
    running = export(library or objects, out, registry, recipes, jobs, with_review, states)
    with bar(Console(stderr=True)) as progress, closing(running):
        task = progress.add_task("reading", total=None)
        for result in running:
            done: list[ExportResult] | list[KitchenResult]
            if isinstance(result, KitchenResult):
                kitchens.append(result)
                done = kitchens
            else:
                results.append(result)
                done = results
            progress.update(task, total=result.total, completed=len(done), description=escape(terminal_safe(result.id)))
    if json_:
        _print_json(results, kitchens)
    else:
        if results:
            _print_results(results, out)
        _print_kitchens(kitchens, out)
    if any(kitchen.message for kitchen in kitchens):
        raise typer.Exit(1)


robocasa.__doc__ = f"{robocasa.__doc__}\n{EXAMPLES}"


def _print_json(results: list[ExportResult], kitchens: list[KitchenResult]) -> None:
    """A line for each object, then one for each kitchen."""
    for result in results:
        row = {name: value for name, value in vars(result).items() if name != "total"}
        typer.echo(json.dumps({"status": "exported" if result.model else "left_out", **row}, sort_keys=True))
    for kitchen in kitchens:
        facts: dict[str, object]
        if kitchen.message:
            facts = {"status": "refused_kitchen", "id": kitchen.id, "message": kitchen.message}
        else:
            counts = {"number": kitchen.number, "fixtures": kitchen.fixtures}
            facts = {"status": "exported_kitchen", "id": kitchen.id, **counts}
        typer.echo(json.dumps(facts, sort_keys=True))


def _print_kitchens(kitchens: list[KitchenResult], out: Path) -> None:
    console = Console()
    for kitchen in kitchens:
        count = sum(kitchen.fixtures.values())
        if kitchen.message:
            line = f"[red]refused[/] {kitchen.id}: {escape(terminal_safe(kitchen.message))}"
        else:
            line = f"kitchen [bold]{kitchen.id}[/] of {count} fixtures, number {kitchen.number}"
        console.print(line, highlight=False, soft_wrap=True)
    if written := [kitchen for kitchen in kitchens if not kitchen.message]:
        place = escape(terminal_safe(str(out)))
        message = f"{pluralize(len(written), 'kitchen')}; read {place}/README.md for how to open them"
        console.print(message, highlight=False, soft_wrap=True)


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
