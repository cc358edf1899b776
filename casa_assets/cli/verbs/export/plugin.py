"""casa-assets export plugin: assets in a form that a plug-in writes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from casa_assets.cli import completion
from casa_assets.cli.options import AsJson, Quiet, Verbose, WithReview
from casa_assets.cli.output import Output
from casa_assets.cli.verbs.export.rows import ExportOut, export_as


def plugin(
    name: Annotated[str, typer.Argument(help="Name of the exporter.")],
    source: Annotated[
        Path,
        typer.Argument(
            help="Library, or the folder of one asset in it.",
            exists=True,
            file_okay=False,
            readable=True,
            autocompletion=completion.assets,
        ),
    ],
    out: ExportOut,
    with_review: WithReview = False,
    json_: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Write assets in a form that a plug-in adds.

    Exit 0 when all were written, 1 where one was refused or the plug-in failed on it, 2 on misuse.

    Example:  casa-assets export plugin blocks out/library --out out/blocks --plugins
    """
    from casa_assets.pipeline.export.by_plugin import form_of

    export_as(form_of(name), name, source, [], out, 1, with_review, Output(json_, quiet, verbose))
