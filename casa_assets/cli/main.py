"""The Typer app and its verbs."""

from __future__ import annotations

import sys
from typing import Annotated

import typer
from rich.console import Console

from casa_assets import __version__
from casa_assets.cli.checks import checks
from casa_assets.cli.doctor import doctor
from casa_assets.cli.index import index
from casa_assets.cli.ingest import ingest
from casa_assets.cli.preview import preview
from casa_assets.cli.report import report
from casa_assets.errors import CasaError

app = typer.Typer(
    name="casa-assets",
    help="Raw 3D meshes into simulation-ready MJCF and USD, each with a picture and a certificate.",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for verb in (ingest, preview, report, index, checks, doctor):
    app.command()(verb)


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"casa-assets {__version__}")
        raise typer.Exit


@app.callback()
def common(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Raw 3D meshes into simulation-ready MJCF and USD, each with a picture and a certificate."""


def main() -> None:
    """Entry point: errors that are meant for a person are printed as one line, exit code 2."""
    try:
        app()
    except CasaError as error:
        Console(stderr=True, soft_wrap=True).print(f"[bold red]error:[/] {error}", highlight=False)
        sys.exit(2)


if __name__ == "__main__":
    main()
