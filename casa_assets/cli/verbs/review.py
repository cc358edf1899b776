"""casa-assets review: a page in the browser on which a person decides about what was told on thin evidence."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from casa_assets.cli.options import LIBRARY_HELP, Browser, Port, library_at
from casa_assets.cli.text import pluralize


def review(
    library: Annotated[Path, typer.Argument(help=LIBRARY_HELP, exists=True, file_okay=False)] = Path("out/library"),
    port: Port = 0,
    browser: Browser = True,
) -> None:
    """Open a page on which you decide about assets in review: accept, reject, correct category, pose, size and mass.

    Each decision is written to review.csv of the library at once; the next `casa-assets ingest` applies it. Articulated
    meshes have a page of their own, on which parts are corrected too; `casa-assets articulate` applies review.json,
    which that page writes. Only this machine can open the pages; Ctrl-C ends them.
    Exit 0 when nothing is left to decide, 2 on misuse, 130 after Ctrl-C.

    Example:

      casa-assets review out/library
    """
    from casa_assets.errors import OutputError
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.local_server import open_in_browser
    from casa_assets.pipeline.review import ARTICULATED, ReviewServer

    console = Console(soft_wrap=True, highlight=False)
    place = library_at(library)
    with writing(library):
        try:
            server = ReviewServer(place, port)
        except OverflowError as error:
            raise OutputError(str(port), "is no port; give one from 1024 to 65535") from error
        with server:
            pages = []
            if server.waiting:
                console.print(f"{pluralize(len(server.waiting), 'input')} to decide about: {server.address}")
                pages.append(server.address)
            if server.articulated:
                pages.append(f"{server.address}{ARTICULATED}")
                console.print(f"{pluralize(len(server.articulated), 'articulated mesh')}: {pages[-1]}")
            if not pages:
                console.print("nothing is in review")
                return
            console.print("Ctrl-C ends it; then run the same command on the same sources again")
            for page in pages if browser else ():
                open_in_browser(page)
            server.serve_forever()
