"""casa-assets fetch: download objects of Objaverse, to be ingested."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console


def fetch(
    uids: Annotated[list[str] | None, typer.Argument(help="Objaverse uids.")] = None,
    category: Annotated[str, typer.Option(help="LVIS category to take objects of, such as Mug.")] = "",
    most: Annotated[int, typer.Option(min=1, help="How many objects at most.")] = 20,
    into: Annotated[Path, typer.Option("--out", "--into", help="Folder for the download.")] = Path("out/objaverse"),
) -> None:
    """Download objects of Objaverse with the `objaverse` package, which needs a network.

    Examples:

      casa-assets fetch --category Mug --most 10

      casa-assets ingest out/objaverse/hf-objaverse-v1
    """
    from casa_assets.ingest.sources.objaverse import download

    if not uids and not category:
        raise typer.BadParameter("name uids, or a --category")
    folder = download(uids or [], category, most, into)
    Console().print(f"Objects: {folder}   Next: casa-assets ingest {folder}", highlight=False, soft_wrap=True)
