"""casa-assets view, preview: look at assets and kitchens, in a viewer, on a page or in pictures."""

from __future__ import annotations

import gc
import os
import signal
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.markup import escape

from casa_assets.cli.options import (
    LIBRARY_HELP,
    Browser,
    Camera,
    Out,
    Photoreal,
    Port,
    Pose,
    ScenesFolder,
    WidthPx,
    complete_assets,
    complete_kitchens,
    shared,
)
from casa_assets.cli.output import Output, measures_at
from casa_assets.errors import CasaError, StopRequested

if TYPE_CHECKING:
    from casa_assets.show.view.subject import Subject

SCENES = Path("out/scenes")
NAMED = (
    "Folder or XML file of an asset or a kitchen, id of an asset, id of a kitchen (built if missing), a family "
    "(microwave/steel) or a category of objects (apple/3)."
)


@shared
def preview(
    output: Output,
    assets: Annotated[
        list[Path],
        typer.Argument(
            help="Asset folders, model.xml files, libraries; kitchens with --photoreal.",
            exists=True,
            autocompletion=complete_assets,
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
    from casa_assets.runs.outcome import writing
    from casa_assets.show.reports.pictures import draw, draw_stills
    from casa_assets.show.stills.photoreal import StillSettings

    if photoreal and (colliders or turntable):
        raise typer.BadParameter("--photoreal draws neither --colliders nor a --turntable")
    if camera and not photoreal:
        raise typer.BadParameter("is for stills of kitchens: give --photoreal too", param_hint="--camera")
    if pose and turntable:
        raise typer.BadParameter("a --turntable shows joints at zero", param_hint="--pose")
    if photoreal:
        frame = StillSettings(width_px, width_px * 9 // 16)
        drawn = draw_stills(assets, out, frame, pose, camera or ())
        lacking = "nothing found; name folders that hold a model.xml or a scene.json"
    else:
        drawn = draw(assets, out, width_px, colliders, turntable, pose)
        lacking = "no asset found; name folders that hold a model.xml"
    first: Path | None = None
    with writing(out):
        for picture in drawn:
            first = first or picture.subject
            output.made(picture.title, out, measures_at(picture.subject), picture=str(picture.path))
            output.line(str(picture.path))
    if first is None:
        raise CasaError(lacking)
    output.look(first)


def view(
    what: Annotated[str, typer.Argument(metavar="ASSET|SCENE", help=NAMED, autocompletion=complete_kitchens)],
    web: Annotated[
        bool, typer.Option("--web", help="Serve a page for the browser, also if there is a screen.")
    ] = False,
    pose: Pose = "",
    port: Port = 0,
    browser: Browser = True,
    library: Annotated[
        Path | None,
        typer.Option(
            "--library",
            help=f"{LIBRARY_HELP[:-1]}; ids are looked for in those below out/ where none is given.",
            exists=True,
            file_okay=False,
        ),
    ] = None,
    scenes_folder: ScenesFolder = SCENES,
) -> None:
    """Look at an asset or a kitchen: turn it, open its doors, light its burners, swap its style.

    With a screen MuJoCo's own viewer opens. Without one, or with --web, a page is served on this machine alone; over
    ssh the line to reach it from your own machine is printed. Ctrl-C ends it. A kitchen that is not on the disk is
    built in memory; only the cache is written.
    Exit 0 when it is closed, 2 on misuse.

    Examples:

      casa-assets view l_small__coastal --pose open
      casa-assets view out/library/mug/mug_0123456789 --web
    """
    from casa_assets.api.assets import has_screen
    from casa_assets.show.view.subject import LIBRARIES, find

    subject = find(what, scenes_folder, LIBRARIES if library is None else (library,))
    try:
        if web or not has_screen():
            _serve(subject, pose, port, browser)
        else:
            _show(subject, pose)
    except StopRequested as stop:
        if stop.args[0] != signal.SIGINT:
            raise
        typer.echo("", err=True)  # the shell's ^C is on a separate line; to look no longer is no failure
    gc.freeze()  # a last look for garbage among all that was built would make the end take seconds


def _show(subject: Subject, pose: str) -> None:
    from casa_assets.api.assets import show_model
    from casa_assets.show.stills.live_viewer import require_screen
    from casa_assets.show.view.model import mujoco_model
    from casa_assets.show.view.subject import cache_of

    require_screen()
    console = Console(stderr=True, highlight=False, soft_wrap=True)
    with console.status("starting") as status:

        def show_progress(doing: str, done: int, of: int) -> None:
            status.update(f"{doing} {done} of {of}" if of else doing)

        model = mujoco_model(subject, cache_of(subject), show_progress)
    console.print(
        "Double-click a door, then drag it with Ctrl and the right button. Space stops the time, Backspace goes back "
        "to the pose. --web shows a page instead."
    )
    show_model(model, pose, subject.id)


def _serve(subject: Subject, pose: str, port: int, browser: bool) -> None:
    from casa_assets.api.assets import serving
    from casa_assets.show.view.server import open_in_browser, tunnel_line

    # The address goes to standard output, where a program can read it, and notes for people to standard error.
    console = Console(stderr=True, highlight=False, soft_wrap=True)
    with serving(subject, pose, port) as server:
        typer.echo(server.address)
        console.print(f"{escape(subject.id)} is shown at the address above; Ctrl-C ends it")
        if tunnel := tunnel_line(server.server_port):
            console.print(f"from your own machine: [bold]{escape(tunnel)}[/], then open the address there")
        if browser and not os.environ.get("SSH_CONNECTION"):
            open_in_browser(server.address)
        server.serve_forever()
