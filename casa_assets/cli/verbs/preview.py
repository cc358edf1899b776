"""casa-assets preview: pictures of assets."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

if TYPE_CHECKING:
    from casa_assets.pipeline.reports.pictures import Picture


def preview(
    assets: Annotated[list[Path], typer.Argument(help="Asset folders, model.xml files, or libraries.", exists=True)],
    output: Annotated[Path, typer.Option("--out", "--output", "-o", help="Folder for the pictures.")] = Path(
        "out/preview"
    ),
    size: Annotated[int, typer.Option(min=64, max=2048, help="Width and height of each picture, pixels.")] = 512,
    colliders: Annotated[bool, typer.Option("--colliders", help="Show the collision shapes.")] = False,
    turntable: Annotated[bool, typer.Option("--turntable", help="Also a turning picture of each.")] = False,
) -> None:
    """Draw assets, and a contact sheet where there are several.

    Examples:

      casa-assets preview out/library/mug/mug_0123456789

      casa-assets preview out/library --colliders -o sheets
    """
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.reports.pictures import draw

    console = Console()
    made: list[Picture] = []
    with writing(output):
        for picture in draw(assets, output, size, colliders, turntable):
            made.append(picture)
            console.print(str(picture.path), highlight=False)
    if not made:
        Console(stderr=True).print("[red]no asset found[/]: name folders that hold a model.xml")
        raise typer.Exit(2)
