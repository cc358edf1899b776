"""What the exports of assets and kitchens have in common: options, rows on a progress bar, then words or JSON."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape

from casa_assets.cli import completion
from casa_assets.cli.options import OUT_HELP, more
from casa_assets.cli.output import Output, measures, measures_at
from casa_assets.cli.progress import bar
from casa_assets.cli.text import pluralize, terminal_safe

if TYPE_CHECKING:
    from casa_assets.pipeline.export.form import ExportResult, Form

ExportOut = Annotated[
    Path, typer.Option("--out", help=more(OUT_HELP, "a folder: missing, empty, or an earlier export."))
]
Source = Annotated[
    Path | None,
    typer.Argument(
        help="Library, or the folder of one asset in it.",
        exists=True,
        file_okay=False,
        readable=True,
        autocompletion=completion.assets,
    ),
]


def export_as(
    form: Form,
    word: str,
    source: Path | None,
    scenes: list[str],
    out: Path,
    jobs: int,
    with_review: bool,
    output: Output,
) -> None:
    """Write a library, an asset or kitchens in a form; exits with 1 where one was refused.

    Args:
        word: name of the form in a sentence.
    """
    from casa_assets.pipeline.export.form import export_assets, export_scenes

    if (source is None) == (not scenes):
        raise typer.BadParameter("give either a library or an asset's folder, or --scenes")
    if source is not None:
        rows = export_assets(form, source, out, with_review)
    else:
        rows = export_scenes(form, scenes, out, jobs)
    results: list[ExportResult] = []
    with bar(output.console) as progress, closing(rows) as running:
        task = progress.add_task("reading", total=None)
        for result in running:
            results.append(result)
            progress.update(
                task, total=result.total, completed=len(results), description=escape(terminal_safe(result.id))
            )
    known = folders_by_id(source) if output.as_json and source is not None else {}
    for result in results:
        measured = {name: result.facts[name] for name in measures(None) if name in result.facts}
        row = {"id": result.id, form.name: result.file, "message": result.message}
        row |= measured or measures_in(known, result.id)
        status = "exported" if result.file else "left_out" if result.is_left_out else "refused"
        output.row({"status": status, "verdict": status, "folder": str(out) if result.file else "", **row})
    if not output.as_json:
        _print_results(results, out, "asset" if source is not None else "kitchen", word, output)
        look([result.id for result in results if result.file], source, output)
    if not all(result.file or result.is_left_out for result in results):
        raise typer.Exit(1)


def look(ids: Sequence[str], source: Path | None, output: Output) -> None:
    """Print the command that shows the first of what was exported.

    Args:
        ids: of assets, or of kitchens where there is no source. source: library, or the folder of one asset.
    """
    from casa_assets.pipeline.library.library import CERTIFICATE

    if not ids:
        return
    if source is None:
        output.look(ids[0])
    elif (source / CERTIFICATE).is_file():
        output.look(source)
    else:
        output.look(ids[0], "--library", source)


def folders_by_id(source: Path) -> dict[str, Path]:
    """Folders of the accepted assets of a library, or the folder of one asset, by id."""
    from casa_assets.pipeline.library.library import CERTIFICATE, Library

    if (source / CERTIFICATE).is_file():
        return {source.name: source}
    return {folder.name: folder for folder in Library(source).accepted()}


def measures_in(known: dict[str, Path], asset_id: str) -> dict[str, Any]:
    """Mass and size of an asset; null where it is none of those known."""
    return measures_at(known[asset_id]) if asset_id in known else measures(None)


def _print_results(results: list[ExportResult], out: Path, what: str, word: str, output: Output) -> None:
    for result in results:
        if result.file:
            output.detail(f"exported {terminal_safe(result.id)}: {result.file}")
        elif result.is_left_out:
            output.line(f"left out {terminal_safe(result.id)}: {terminal_safe(result.message)}")
        else:
            output.wrong(f"refused {terminal_safe(result.id)}: {terminal_safe(result.message)}")
    written = [result for result in results if result.file]
    if not written:
        output.error("nothing was written")
        return
    place = terminal_safe(str(out))
    output.line(f"{pluralize(len(written), what)} as {word}; read {place}/README.md for how to load them")
