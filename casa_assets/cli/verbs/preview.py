"""casa-assets preview: pictures of assets."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from casa_assets.cli import completion
from casa_assets.cli.options import AsJson, Camera, Out, Photoreal, Pose, Quiet, Verbose, WidthPx
from casa_assets.cli.output import Output, measures_at
from casa_assets.errors import CasaError


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
    --camera is for such stills of kitchens. Exit 0 when the pictures are drawn, 2 when there is no asset or on other
    misuse.

    Examples:

      casa-assets preview out/library/mug/mug_0123456789
      casa-assets preview out/library --colliders --out sheets
      casa-assets preview out/scenes/l_small__coastal --photoreal
    """
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.reports.pictures import draw

    output = Output(json_, quiet, verbose)
    if photoreal:
        if colliders or turntable:
            raise typer.BadParameter("--photoreal draws neither --colliders nor a --turntable")
        _draw_stills(assets, out, width_px, pose, camera or (), output)
        return
    if camera:
        raise typer.BadParameter("is for stills of kitchens: give --photoreal too", param_hint="--camera")
    if pose and turntable:
        raise typer.BadParameter("a --turntable shows joints at zero", param_hint="--pose")
    first: Path | None = None
    with writing(out):
        for picture in draw(assets, out, width_px, colliders, turntable, pose):
            first = first or picture.asset
            output.made(picture.title, out, measures_at(picture.asset), picture=str(picture.path))
            output.line(str(picture.path))
    if first is None:
        raise CasaError("no asset found; name folders that hold a model.xml")
    output.look(first)


def _draw_stills(
    targets: list[Path], out: Path, width_px: int, pose: str, cameras: Sequence[str], output: Output
) -> None:
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.reports.pictures import draw_stills
    from casa_assets.preview.photoreal.render import StillSettings

    first: Path | None = None
    with writing(out):
        for written in draw_stills(targets, out, StillSettings(width_px, width_px * 9 // 16), pose, cameras):
            first = first or written.subject
            name = written.subject.resolve().name
            output.made(name, out, measures_at(written.subject), picture=str(written.path))
            output.line(str(written.path))
    if first is None:
        raise CasaError("nothing found; name folders that hold a model.xml or a scene.json")
    output.look(first)
