"""What the exports of assets and kitchens have in common: rows on a progress bar, then words or JSON."""

from __future__ import annotations

import json
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from rich.console import Console
from rich.markup import escape

from casa_assets.cli.progress import bar
from casa_assets.cli.text import pluralize, terminal_safe

if TYPE_CHECKING:
    from casa_assets.pipeline.export.form import ExportResult, Form


def export_as(
    form: Form, word: str, source: Path | None, scenes: list[str], out: Path, jobs: int, with_review: bool, json_: bool
) -> None:
    """Write a library, an asset or kitchens in a form; exits with 1 where one was refused.

    Args:
        word: name of the form in a sentence. json_: tell it as one JSON object per asset or kitchen.
    """
    from casa_assets.pipeline.export.form import export_assets, export_scenes

    if (source is None) == (not scenes):
        raise typer.BadParameter("give either a library or an asset's folder, or --scenes")
    if source is not None:
        rows = export_assets(form, source, out, with_review)
    else:
        rows = export_scenes(form, scenes, out, jobs)
    results: list[ExportResult] = []
    with bar(Console(stderr=True)) as progress, closing(rows) as running:
        task = progress.add_task("reading", total=None)
        for result in running:
            results.append(result)
            progress.update(
                task, total=result.total, completed=len(results), description=escape(terminal_safe(result.id))
            )
    if json_:
        for result in results:
            row = {"id": result.id, form.name: result.file, "message": result.message}
            status = "exported" if result.file else "left_out" if result.is_left_out else "refused"
            typer.echo(json.dumps({"status": status, **row}, sort_keys=True))
    else:
        _print_results(results, out, "asset" if source is not None else "kitchen", word)
    if not all(result.file or result.is_left_out for result in results):
        raise typer.Exit(1)


def _print_results(results: list[ExportResult], out: Path, what: str, word: str) -> None:
    console = Console()
    for result in results:
        if not result.file:
            word = "[yellow]left out[/]" if result.is_left_out else "[red]refused[/]"
            line = f"{word} {escape(terminal_safe(result.id))}: {escape(terminal_safe(result.message))}"
            console.print(line, highlight=False, soft_wrap=True)
    written = [result for result in results if result.file]
    if not written:
        console.print("nothing was written", highlight=False)
        return
    place = escape(terminal_safe(str(out)))
    message = f"{pluralize(len(written), what)} as {word}; read {place}/README.md for how to load them"
    console.print(message, highlight=False, soft_wrap=True)
