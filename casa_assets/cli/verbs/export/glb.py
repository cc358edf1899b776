"""casa-assets export glb: assets or whole kitchens as GLB, to look at in other programs."""

from __future__ import annotations

from typing import Annotated

import typer

from casa_assets.cli.options import AsJson, Jobs, Kitchens, Quiet, Verbose, WithReview
from casa_assets.cli.output import Output
from casa_assets.cli.verbs.export.rows import ExportOut, Source, export_as

EXAMPLES = """
Examples:

  casa-assets export glb out/library --out out/glb       # a whole library
  casa-assets export glb out/library/mug/mug_0a1b2c3d4e --out one
  casa-assets export glb --scenes l_small__coastal --out kitchens
  casa-assets export glb lib --out all --layers          # collision shapes
"""


def glb(
    out: ExportOut,
    source: Source = None,
    scenes: Kitchens = None,
    jobs: Jobs = 0,
    with_review: WithReview = False,
    layers: Annotated[
        bool, typer.Option("--layers", help="Put collision shapes and regions into the files, too.")
    ] = False,
    json_: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Write assets or kitchens as GLB, which browsers and Blender show.

    Exit 0 when all were written, 1 where one was refused, 2 on misuse.
    """
    from casa_assets.pipeline.export.gltf import glb_form

    export_as(glb_form(layers), "GLB", source, scenes or [], out, jobs, with_review, Output(json_, quiet, verbose))


glb.__doc__ = f"{glb.__doc__}\n{EXAMPLES}"
