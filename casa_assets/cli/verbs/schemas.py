"""casa-assets schemas: print JSON Schemas of the files that other programs read or write."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from casa_assets.cli.options import AsJson
from casa_assets.cli.output import Output


def schemas(
    name: Annotated[
        str,
        typer.Argument(
            help="scene, scene_report, asset, behavior, plan or style; none: list them.", show_default=False
        ),
    ] = "",
    json_: AsJson = False,
) -> None:
    """Print the JSON Schema of scene.json, asset.json, behavior.json, the report.json of a kitchen, a plan or a style.

    With --json each is one line, with the file that it describes. Exit 0 when it is printed, 2 when there is no schema
    of this name.

    Example: casa-assets schemas scene > scene.schema.json
    """
    from casa_assets.pipeline.schemas import SCHEMAS, schema_text, title_of

    output = Output(json_)
    for known in (name,) if name else SCHEMAS:
        text = schema_text(known)  # raises UnknownId
        output.row({"id": known, "file": title_of(known), "schema": json.loads(text)})
        if not json_:
            typer.echo(text if name else known, nl=not name)
