"""casa-assets preview: pictures of assets, and path-traced stills of assets and kitchens."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from casa_assets.cli.options import Photoreal

if TYPE_CHECKING:
    from casa_assets.pipeline.reports.pictures import Picture


def preview(
    assets: Annotated[
        list[Path],
        typer.Argument(help="Asset folders, model.xml files, libraries; kitchens with --photoreal.", exists=True),
    ],
    output: Annotated[Path, typer.Option("--out", "--output", "-o", help="Folder for the pictures.")] = Path(
        "out/preview"
    ),
    size: Annotated[int, typer.Option(min=64, max=2048, help="Width and height of each picture, pixels.")] = 512,
    colliders: Annotated[bool, typer.Option("--colliders", help="Show the collision shapes.")] = False,
    turntable: Annotated[bool, typer.Option("--turntable", help="Also a turning picture of each.")] = False,
    photoreal: Photoreal = False,
    pose: Annotated[
        str, typer.Option("--pose", help="Pose of stills: closed, open or on, as far as it is there.")
    ] = "",
    camera: Annotated[
        list[str] | None, typer.Option("--camera", help="Cameras of kitchens; eye and cutaway where none is named.")
    ] = None,
) -> None:
    """Draw assets, and a contact sheet where there are several.

    With --photoreal the USD is drawn by a path tracer, Blender's Cycles, with real glass, metal and daylight; kitchens
    too. It takes a minute or two for each picture, needs no display and no graphics card, and says what to install.

    Examples:

      casa-assets preview out/library/mug/mug_0123456789

      casa-assets preview out/library --colliders --out sheets

      casa-assets preview out/scenes/l_small__coastal --photoreal
    """
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.reports.pictures import draw

    if photoreal:
        if colliders or turntable:
            raise typer.BadParameter("--photoreal draws neither --colliders nor a --turntable")
        _draw_stills(assets, output, size, pose, camera or ())
        return
    console = Console()
    made: list[Picture] = []
    with writing(output):
        for picture in draw(assets, output, size, colliders, turntable):
            made.append(picture)
            console.print(str(picture.path), highlight=False)
    if not made:
        Console(stderr=True).print("[red]no asset found[/]: name folders that hold a model.xml")
        raise typer.Exit(2)


def _draw_stills(targets: list[Path], output: Path, width_px: int, pose: str, cameras: Sequence[str]) -> None:
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.reports import stills
    from casa_assets.preview.photoreal.render import StillSettings

    made = 0
    with writing(output):
        for written in stills.draw(targets, output, StillSettings(width_px, width_px * 9 // 16), pose, cameras):
            made += 1
            typer.echo(str(written.path))
    if not made:
        Console(stderr=True).print("[red]nothing found[/]: name folders that hold a model.xml or a scene.json")
        raise typer.Exit(2)
