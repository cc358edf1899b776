"""casa-assets home: one page about a folder of output."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from casa_assets.cli.options import AsJson, Jobs, Pictures, Quiet, Verbose
from casa_assets.cli.output import Output, pluralize, working_on
from casa_assets.errors import BatchFault


def home(
    folder: Annotated[Path, typer.Argument(help="Folder of output.", exists=True, file_okay=False)] = Path("out"),
    pictures: Pictures = True,
    jobs: Jobs = 0,
    json_: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Write an overview page of a folder, index.html: kitchens, articulated assets, assets, and what was rejected.

    Kitchens without a picture with open doors get one, unless --no-pictures is given. Exit 0 when the page is written,
    2 on misuse, 3 when a picture could not be drawn because of a fault of the program; the page has the others.

    Example:

      casa-assets home out
    """
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.kitchens import eye_pictures
    from casa_assets.pipeline.reports import home as page
    from casa_assets.pipeline.reports import kitchens

    output, faults = Output(json_, quiet, verbose), list[BatchFault]()
    for shelf in page.scene_folders(folder):
        wanted = eye_pictures.missing(shelf.path) if pictures else []
        if not wanted:
            continue
        try:
            with working_on(output.console, "drawing", [path.parent.name for path in wanted]) as done:
                for path in eye_pictures.draw(shelf.path, wanted, jobs):
                    done(path.parent.name)
        except BatchFault as fault:
            faults.append(fault)
        output.line(f"Kitchens with their doors open: {pluralize(len(wanted), 'picture')} in {shelf.path}")
        with writing(shelf.path):
            kitchens.write(shelf.path)
    path = page.write(folder)
    output.made(folder.resolve().name, folder, page=str(path.resolve()))
    output.line(f"Page: {path.resolve()}")
    output.look_at_file(path)
    if faults:
        raise faults[0]
