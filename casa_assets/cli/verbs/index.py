"""casa-assets index: rebuild the index of a library, or export it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from casa_assets.cli.options import library_at
from casa_assets.cli.text import pluralize


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
    from casa_assets.pipeline.reports import index as books

    if parquet is not None:
        books.require_parquet()
    place = library_at(library)
    with place.locked(), writing(library):
        count = books.rebuild(place, EntryTable(place, force=True).entries)
    console = Console(soft_wrap=True, highlight=False)
    console.print(f"{pluralize(count, 'row')} in {library / books.NAME}")
    if parquet is not None:
        with writing(parquet.parent):
            books.export_parquet(place, parquet)
        console.print(f"{pluralize(count, 'row')} in {parquet}")
