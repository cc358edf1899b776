"""What verbs that work through many inputs say at their end: what was no mesh, and how many were rejected and why."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from casa_assets.cli.output import Output, measures
from casa_assets.cli.tables import TextTable
from casa_assets.cli.text import pluralize, terminal_safe
from casa_assets.errors import CasaError

KINDS = (
    ".glb, .gltf, .obj, .ply, .stl, .dae, .fbx, .usd, .usdz, .x3d, .wrl, .3ds, .blend, an archive of them, "
    "a manifest .jsonl or an Objaverse folder"
)
# Where a run has more inputs than this, what was in the library already is counted and not listed.
MOST_LISTED = 200


def no_mesh_found(sources: Sequence[object]) -> CasaError:
    """The error that the sources hold no mesh, with what would be one."""
    return CasaError(f"no mesh found in {', '.join(map(str, sources))}; name {KINDS}")


def print_others(others: Counter[str], output: Output) -> None:
    """Say how many files were no meshes, by what they are; nothing where all were."""
    if not others:
        return
    counts = dict(sorted(others.items()))
    words = ", ".join(f"{count} {kind}" for kind, count in counts.items())
    blank = {"to_decide": [], "kept": False, "path": "", "id": "", "code": "", "warnings": [], "folder": ""}
    row = {**blank, **measures(None), "status": "no_mesh", "verdict": "no_mesh", "message": words}
    output.row({**row, "count": others.total(), "kinds": counts})
    if not output.as_json:
        output.line(f"No meshes: {pluralize(others.total(), 'file')} ({words})")


def print_codes(codes: Counter[str], output: Output) -> None:
    """Print how many inputs were rejected for each reason, and what to do about it."""
    from casa_assets import registry

    if not codes:
        return
    records = registry.load()
    heads = ("code", "reason", "inputs", "what to do")
    table = TextTable(heads, sentences=("reason", "what to do"), right=("inputs",), title="Rejected by reason")
    why: dict[str, str] = {}
    if not codes.keys() <= records.rejections.keys():
        from casa_assets.pipeline.reports.page_template import explanations

        why = explanations()
    for code, count in codes.most_common():
        row = records.rejections.get(code)
        meaning, advice = (row.meaning, row.remedy) if row else (why.get(code, ""), "as the line of each input says")
        table.add(code, meaning, str(count), advice)
    table.print(output.console)


def print_review(count: int, asks_category: bool, library: Path, output: Output) -> None:
    """Print how to decide about the inputs in review; nothing where there are none.

    Args:
        asks_category: of some nobody knows what they are.
    """
    if not count:
        return
    place = terminal_safe(shlex.quote(str(library)))
    wait, it = ("input waits", "it") if count == 1 else ("inputs wait", "them")
    output.line(f"Review:  {count} {wait} for your decision; exports include {it} only with --with-review")
    output.line(f"         decide on a page with `casa-assets review {place}`, or in {place}/review.csv, and run again")
    if asks_category:
        output.line("         no category was found for some: give --category if all are of one, or a manifest.jsonl")
        output.line('         with a line for each file, such as {"file": "a.glb", "category": "mug"}')


def print_outcomes(accepted: int, in_review: int, rejected: int, kept: int, output: Output) -> None:
    """Print how many inputs were accepted, in review and rejected, and how many of them earlier runs had done."""
    was = "was" if kept == 1 else "were"
    there = f" ({kept} {was} there already)" if kept else ""
    counts = f"[green]{accepted} accepted[/], [yellow]{in_review} in review[/], [red]{rejected} rejected[/]{there}"
    words = f"{pluralize(accepted + in_review + rejected, 'input')}: {counts}"
    output.console.print(words, highlight=False, soft_wrap=True)
