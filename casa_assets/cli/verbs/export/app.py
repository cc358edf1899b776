"""casa-assets export: libraries and kitchens in the form that another program reads."""

from __future__ import annotations

import typer

from casa_assets.cli.group import Group
from casa_assets.cli.verb import Verb
from casa_assets.cli.verbs.export.glb import glb
from casa_assets.cli.verbs.export.plugin import plugin
from casa_assets.cli.verbs.export.robocasa import robocasa
from casa_assets.cli.verbs.export.urdf import urdf

app = typer.Typer(
    name="export",
    cls=Group,
    help="Libraries and kitchens in the form that another program reads.",
    no_args_is_help=True,
)


@app.callback()
def common() -> None:
    """Libraries and kitchens in the form that another program reads."""


app.command(cls=Verb)(glb)
app.command(cls=Verb)(robocasa)
app.command(cls=Verb)(urdf)
app.command(cls=Verb)(plugin)
