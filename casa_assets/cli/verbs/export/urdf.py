"""casa-assets export urdf: assets or whole kitchens as URDF."""

from __future__ import annotations

from casa_assets.cli.options import AsJson, Jobs, Kitchens, Quiet, Verbose, WithReview
from casa_assets.cli.output import Output
from casa_assets.cli.verbs.export.rows import ExportOut, Source, export_as

EXAMPLES = """
Examples:

  casa-assets export urdf out/library --out out/urdf     # a whole library
  casa-assets export urdf --scenes 'l_small__*' --out kitchens
  casa-assets export urdf lib --out urdf --json > rows.jsonl
"""


def urdf(
    out: ExportOut,
    source: Source = None,
    scenes: Kitchens = None,
    jobs: Jobs = 0,
    with_review: WithReview = False,
    json_: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Write assets or kitchens as URDF and compare what is read back.

    Exit 0 when all were written, 1 where one was refused, 2 on misuse.
    """
    from casa_assets.pipeline.export.urdf import URDF

    export_as(URDF, "URDF", source, scenes or [], out, jobs, with_review, Output(json_, quiet, verbose))


urdf.__doc__ = f"{urdf.__doc__}\n{EXAMPLES}"
