"""casa-assets review: a page in the browser on which a person decides about what was told on thin evidence."""

from __future__ import annotations

import webbrowser
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from casa_assets.cli.options import library_at
from casa_assets.cli.text import pluralize


def review(
    library: Annotated[Path, typer.Argument(help="The library.", exists=True, file_okay=False)] = Path("out/library"),
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port on this machine; 0: any that is free.")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page.")] = True,
) -> None:
    """Decide about assets in review, in the browser: accept, reject, or correct kind, pose, size and mass.

    What is decided goes into review.csv of the library at once, and the next `casa-assets ingest` obeys it. Ctrl-C ends
    the page. Only this machine can open it.

    Example:

      casa-assets review out/library
    """
    from casa_assets.errors import OutputError
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.review.server import ReviewServer

    console = Console(soft_wrap=True, highlight=False)
    place = library_at(library)
    with writing(library):
        try:
            server = ReviewServer(place, port)
        except OverflowError as error:
            raise OutputError(str(port), "is no port; give one from 1024 to 65535") from error
        with server:
            if not server.waiting:
                console.print("nothing is in review")
                return
            console.print(f"{pluralize(len(server.waiting), 'input')} to decide about: {server.address}")
            console.print("Ctrl-C ends it; then run `casa-assets ingest` on the same sources again")
            if browser:
                webbrowser.open(server.address)
            server.serve_forever()
