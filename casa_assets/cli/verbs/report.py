"""casa-assets report, index: a page about a library, and the table of its entries, made anew from them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from casa_assets.cli.options import library_at
from casa_assets.cli.text import pluralize


def report(
    library: Annotated[Path, typer.Option(help="The library.", exists=True, file_okay=False)] = Path("out/library"),
    output: Annotated[
        Path | None, typer.Option("--out", "--output", "-o", help="Default: report.html in the library.")
    ] = None,
    clip_weights: Annotated[
        str, typer.Option(help="Weights of CLIP that look at the pictures first, see `casa-assets find --help`.")
    ] = "",
) -> None:
    """Write one self-contained HTML page: counts, rejects by reason, every asset with picture and numbers.

    Example:

      casa-assets report --library out/library
    """
    from casa_assets.pipeline.clip import load_clip
    from casa_assets.pipeline.dedup import library_report
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.library.entry_table import EntryTable
    from casa_assets.pipeline.reports.report import write

    place = library_at(library)
    if clip_weights or library_report.read_library_report(library) is None:
        model = load_clip(clip_weights) if clip_weights else None
        with place.locked(), writing(library):
            library_report.compare_library(place, EntryTable(place), model)
    target = output or library / "report.html"
    with writing(target.parent):
        path = write(library, target)
    Console().print(f"Report: {path}", highlight=False, soft_wrap=True)


def index(
    library: Annotated[Path, typer.Option(help="The library.", exists=True, file_okay=False)] = Path("out/library"),
    parquet: Annotated[Path | None, typer.Option(help="Also write the rows to this Parquet file.")] = None,
) -> None:
    """Rebuild index.sqlite from the asset.json and reject.json files alone.

    Example:

      casa-assets index --library out/library --parquet assets.parquet
    """
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.library.entry_table import EntryTable
    from casa_assets.pipeline.reports import index as index_file

    if parquet is not None:
        index_file.require_parquet()
    place = library_at(library)
    with place.locked(), writing(library):
        count = index_file.rebuild(place, EntryTable(place, force=True).entries)
    console = Console(soft_wrap=True, highlight=False)
    console.print(f"{pluralize(count, 'row')} in {library / index_file.NAME}")
    if parquet is not None:
        with writing(parquet.parent):
            index_file.export_parquet(place, parquet)
        console.print(f"{pluralize(count, 'row')} in {parquet}")
