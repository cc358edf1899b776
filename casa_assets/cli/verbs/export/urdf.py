"""casa-assets export urdf: assets or whole kitchens as URDF."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from casa_assets.cli.verbs.export.rows import export_as

EXAMPLES = """
Examples:

  casa-assets export urdf out/library --out out/urdf               every asset of a library

  casa-assets export urdf out/library/mug/mug_0a1b2c3d4e --out one one asset

  casa-assets export urdf --scenes 'l_small__*' --out kitchens     kitchens, built where they are not kept

  casa-assets export urdf lib --out urdf --json > rows.jsonl       one JSON object per asset or kitchen
"""


def urdf(
    out: Annotated[Path, typer.Option(help="Folder to write: missing, empty, or an earlier export.")],
    source: Annotated[
        Path | None,
        typer.Argument(help="Library, or the folder of one asset in it.", exists=True, file_okay=False, readable=True),
    ] = None,
    scenes: Annotated[list[str] | None, typer.Option(help="Ids or globs of kitchens, such as 'l_small__*'.")] = None,
    jobs: Annotated[int, typer.Option(min=0, help="Processes that build kitchens; 0: one per core.")] = 0,
    with_review: Annotated[
        bool, typer.Option("--with-review", help="Write what a person has to decide about, see review.csv, too.")
    ] = False,
    json_: Annotated[bool, typer.Option("--json", help="One JSON object per asset or kitchen on standard output.")] = (
        False
    ),
) -> None:
    """Write assets or kitchens as URDF and compare what is read back; exit 0, 1 where one was refused, 2, 3."""
    from casa_assets.pipeline.export.urdf import URDF

    export_as(URDF, "URDF", source, scenes or [], out, jobs, with_review, json_)


urdf.__doc__ = f"{urdf.__doc__}\n{EXAMPLES}"
