"""casa-assets home: one page about a folder of output."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from casa_assets.cli.options import Jobs, Quiet
from casa_assets.cli.output import Output
from casa_assets.cli.text import pluralize


def home(
    folder: Annotated[Path, typer.Argument(help="Folder of output.", exists=True, file_okay=False)] = Path("out"),
    pictures: Annotated[bool, typer.Option(help="Draw kitchens, doors open, that have no such picture yet.")] = True,
    jobs: Jobs = 0,
    quiet: Quiet = False,
) -> None:
    """Write index.html of a folder: its kitchens, what was articulated, its assets, what was rejected and why.

    Example:

      casa-assets home out
    """
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.kitchens.eye_pictures import draw_missing
    from casa_assets.pipeline.reports import home as page
    from casa_assets.pipeline.reports import kitchens

    output = Output(quiet=quiet)
    for shelf in page.scene_folders(folder):
        drawn = list(draw_missing(shelf.path, jobs)) if pictures else []
        if drawn:
            output.line(f"{pluralize(len(drawn), 'picture')} of kitchens with their doors open in {shelf.path}")
            with writing(shelf.path):
                kitchens.write(shelf.path)
    path = page.write(folder)
    output.line(f"Page: {path.resolve()}")
