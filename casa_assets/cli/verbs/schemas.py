"""casa-assets schemas: print JSON Schemas of the files that other programs read."""

from __future__ import annotations

from typing import Annotated

import typer


def schemas(
    name: Annotated[
        str, typer.Argument(help="scene, scene_report, asset or behavior; none: list them.", show_default=False)
    ] = "",
) -> None:
    """Print the JSON Schema of scene.json, asset.json, behavior.json or the report.json of a kitchen.

    Exit 0 when it is printed, 2 when there is no schema of this name.

    Example: casa-assets schemas scene > scene.schema.json
    """
    from casa_assets.pipeline.schemas import SCHEMAS, schema_text

    if name:
        typer.echo(schema_text(name), nl=False)
        return
    for known in SCHEMAS:
        typer.echo(known)
