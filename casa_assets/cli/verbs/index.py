"""casa-assets index: the table of the entries of a library, rebuilt from them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from casa_assets.cli.options import AsJson, Library, Quiet, Verbose, library_at
from casa_assets.cli.output import Output, pluralize


def index(
    library: Library = Path("out/library"),
    parquet: Annotated[Path | None, typer.Option(help="Also write the rows to this Parquet file.")] = None,
    json_: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Rebuild index.sqlite from the asset.json and reject.json files alone.

    Exit 0 when it is written, 2 on misuse.

    Example:

      casa-assets index --library out/library --parquet assets.parquet
    """
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.library.entry_table import forget_entries
    from casa_assets.pipeline.tables import index as index_file
    from casa_assets.pipeline.tables.parquet import require_parquet

    if parquet is not None:
        require_parquet()
    place = library_at(library)
    with place.locked(), writing(library):
        forget_entries(place)
        count = index_file.rebuild(place)
    output, files = Output(json_, quiet, verbose), [library / index_file.NAME]
    if parquet is not None:
        with writing(parquet.parent):
            index_file.export_parquet(place, parquet)
        files.append(parquet)
    for file in files:
        output.made(file.stem, file.parent, file=str(file), rows=count)
        output.line(f"{pluralize(count, 'row')} in {file}")
