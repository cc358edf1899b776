"""casa-assets export glb: assets or whole kitchens as GLB, to look at in other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from casa_assets.cli.verbs.export.rows import export_as

EXAMPLES = """
Examples:

  casa-assets export glb out/library --out out/glb                every asset of a library

  casa-assets export glb out/library/mug/mug_0a1b2c3d4e --out one one asset

  casa-assets export glb --scenes l_small__coastal --out kitchens a kitchen, built where it is not kept

  casa-assets export glb lib --out all --layers                   with collision shapes and regions
"""


def glb(
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
    layers: Annotated[
        bool, typer.Option("--layers", help="Put collision shapes and regions into the files, too.")
    ] = False,
    json_: Annotated[bool, typer.Option("--json", help="One JSON object per asset or kitchen on standard output.")] = (
        False
    ),
) -> None:
    """Write assets or kitchens as GLB, which browsers and Blender show; exit 0, 1 where one was refused, 2, 3."""
    from casa_assets.pipeline.export.gltf import glb_form

    export_as(glb_form(layers), "GLB", source, scenes or [], out, jobs, with_review, json_)


glb.__doc__ = f"{glb.__doc__}\n{EXAMPLES}"
