"""What verbs that work through many inputs say at their end: what was no mesh, and how many were rejected and why."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import typer
from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from casa_assets.cli.text import pluralize, terminal_safe

KINDS = (
    ".glb, .gltf, .obj, .ply, .stl, .dae, .fbx, .usd, .usdz, .x3d, .wrl, .3ds, .blend, an archive of them, "
    "a manifest .jsonl or an Objaverse folder"
)
# Where a run has more inputs than this, what was in the library already is counted and not listed.
MOST_LISTED = 200


def print_no_mesh_found(sources: Sequence[Path]) -> None:
    """Say on standard error that the sources hold no mesh, and what would be one."""
    places = ", ".join(escape(terminal_safe(str(source))) for source in sources)
    Console(stderr=True).print(f"[red]no mesh found[/] in {places}; name {KINDS}", highlight=False, soft_wrap=True)


def print_others(others: Counter[str], console: Console, as_json: bool = False) -> None:
    """Say how many files were no meshes, by what they are; nothing where all were."""
    if not others:
        return
    counts = dict(sorted(others.items()))
    words = ", ".join(f"{count} {kind}" for kind, count in counts.items())
    if as_json:
        blank = {"to_decide": [], "kept": False, "path": "", "id": "", "code": "", "warnings": []}
        row = {**blank, "status": "no_mesh", "message": words, "count": others.total(), "kinds": counts}
        typer.echo(json.dumps(row, sort_keys=True))
    else:
        console.print(f"No meshes: {pluralize(others.total(), 'file')} ({words})", highlight=False, soft_wrap=True)


def print_codes(codes: Counter[str], console: Console) -> None:
    """Print how many inputs were rejected for each reason, and what to do about it."""
    from casa_assets import registry

    if not codes:
        return
    records = registry.load()
    table = Table(title="Rejected by reason", title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for name in ("code", "reason", "inputs", "what to do"):
        table.add_column(name, no_wrap=name == "code")
    why: dict[str, str] = {}
    if not codes.keys() <= records.rejections.keys():
        from casa_assets.checks.table.table import explained

        why = explained(records.limits)
    for code, count in codes.most_common():
        row = records.rejections.get(code)
        meaning, advice = (row.meaning, row.remedy) if row else (why.get(code, ""), "as the line of each input says")
        table.add_row(code, meaning, str(count), advice)
    console.print(table)


def print_outcomes(accepted: int, in_review: int, rejected: int, kept: int, console: Console) -> None:
    """Print how many inputs were accepted, in review and rejected, and how many of them earlier runs had done."""
    was = "was" if kept == 1 else "were"
    there = f" ({kept} {was} there already)" if kept else ""
    counts = f"[green]{accepted} accepted[/], [yellow]{in_review} in review[/], [red]{rejected} rejected[/]{there}"
    console.print(f"{pluralize(accepted + in_review + rejected, 'input')}: {counts}", highlight=False)
