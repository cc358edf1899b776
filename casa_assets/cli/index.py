"""casa-assets index: rebuild the index of a library, or export it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console


def index(
    library: Annotated[Path, typer.Option(help="The library.", exists=True, file_okay=False)] = Path("out/library"),
    parquet: Annotated[Path | None, typer.Option(help="Also write the rows to this Parquet file.")] = None,
) -> None:
    """Rebuild index.sqlite from the asset.json and reject.json files alone.

    Example:

      casa-assets index --library out/library --parquet assets.parquet
    """
    from casa_assets.pipeline.books import index as books
    from casa_assets.pipeline.job import writing
    from casa_assets.pipeline.library import Library

    place = Library(library)
    with place.locked(), writing(library):
        count = books.rebuild(place)
    Console().print(f"{count} rows in {library / books.NAME}")
    if parquet is not None:
        books.export_parquet(place, parquet)
        Console().print(f"{count} rows in {parquet}")
