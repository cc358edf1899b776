"""casa-assets preview: pictures of assets."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from casa_assets.cli import completion
from casa_assets.cli.options import AsJson, Camera, Out, Photoreal, Pose, Quiet, Verbose, WidthPx
from casa_assets.cli.output import Output


def preview(
    assets: Annotated[
        list[Path],
        typer.Argument(
            help="Asset folders, model.xml files, libraries; kitchens with --photoreal.",
            exists=True,
            autocompletion=completion.assets,
        ),
    ],
    out: Out = Path("out/preview"),
    width_px: WidthPx = 512,
    colliders: Annotated[bool, typer.Option("--colliders", help="Show the collision shapes.")] = False,
    turntable: Annotated[
        bool, typer.Option("--turntable", help="Also write an animated picture of each, turning.")
    ] = False,
    photoreal: Photoreal = False,
    pose: Pose = "",
    camera: Camera = None,
    json_: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Draw assets, and a contact sheet where there are several.

    With --photoreal the USD is drawn by a path tracer, Blender's Cycles, with real glass, metal and daylight; kitchens
    too. It takes a minute or two for each picture, needs no display and no graphics card, and says what to install.
    --pose and --camera are for such stills. Exit 0 when the pictures are drawn, 2 when there is no asset or on other
    misuse.

    Examples:

      casa-assets preview out/library/mug/mug_0123456789

      casa-assets preview out/library --colliders --out sheets

      casa-assets preview out/scenes/l_small__coastal --photoreal
    """
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.reports.pictures import draw

    output, count = Output(json_, quiet, verbose), 0
    if photoreal:
        if colliders or turntable:
            raise typer.BadParameter("--photoreal draws neither --colliders nor a --turntable")
        _draw_stills(assets, out, width_px, pose, camera or (), output)
        return
    with writing(out):
        for picture in draw(assets, out, width_px, colliders, turntable):
            count += 1
            output.row({"id": picture.title, "picture": str(picture.path), "verdict": "made"})
            output.line(str(picture.path))
    if not count:
        output.error("no asset found; name folders that hold a model.xml")
        raise typer.Exit(2)


def _draw_stills(
    targets: list[Path], out: Path, width_px: int, pose: str, cameras: Sequence[str], output: Output
) -> None:
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.reports import stills
    from casa_assets.preview.photoreal.render import StillSettings

    made = 0
    with writing(out):
        for written in stills.draw(targets, out, StillSettings(width_px, width_px * 9 // 16), pose, cameras):
            made += 1
            output.row({"picture": str(written.path), "verdict": "made"})
            output.line(str(written.path))
    if not made:
        output.error("nothing found; name folders that hold a model.xml or a scene.json")
        raise typer.Exit(2)
