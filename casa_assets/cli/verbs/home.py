"""casa-assets home: one page about a folder of output."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from casa_assets.cli.options import AsJson, Jobs, Pictures, Quiet, Verbose
from casa_assets.cli.output import Output
from casa_assets.cli.text import pluralize


def home(
    folder: Annotated[Path, typer.Argument(help="Folder of output.", exists=True, file_okay=False)] = Path("out"),
    pictures: Pictures = True,
    jobs: Jobs = 0,
    json_: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Write index.html of a folder: its kitchens, what was articulated, its assets, what was rejected and why.

    With pictures, kitchens that have none with their doors open get one. Exit 0 when it is written, 2 on misuse.

    Example:

      casa-assets home out
    """
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.kitchens.eye_pictures import draw_missing
    from casa_assets.pipeline.reports import home as page
    from casa_assets.pipeline.reports import kitchens

    output = Output(json_, quiet, verbose)
    for shelf in page.scene_folders(folder):
        drawn = list(draw_missing(shelf.path, jobs)) if pictures else []
        if drawn:
            output.line(f"{pluralize(len(drawn), 'picture')} of kitchens with their doors open in {shelf.path}")
            with writing(shelf.path):
                kitchens.write(shelf.path)
    path = page.write(folder)
    output.row({"page": str(path.resolve()), "folder": str(folder), "verdict": "made"})
    output.line(f"Page: {path.resolve()}")
