"""casa-assets ingest: sources into a library."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from casa_assets import registry
from casa_assets.pipeline.entry import Entry, entries
from casa_assets.pipeline.ingest import Event, Options, tally
from casa_assets.pipeline.ingest import ingest as run
from casa_assets.pipeline.library import Library

EXAMPLES = """
Examples:

  casa-assets ingest ~/meshes                         every mesh under a folder, into out/library

  casa-assets ingest mug.glb --category mug           one file of a known kind

  casa-assets ingest objaverse/ t3d/manifest.jsonl --library lib --jobs 8

  casa-assets ingest ~/meshes --json > run.jsonl      one JSON object per input
"""


def ingest(
    sources: Annotated[
        list[Path],
        typer.Argument(
            help="Files, folders, Objaverse package folders, manifests (.jsonl).", exists=True, readable=True
        ),
    ],
    library: Annotated[Path, typer.Option(help="Output folder, made where it is missing.")] = Path("out/library"),
    category: Annotated[str, typer.Option(help="Category of every input; else the sources and names decide.")] = "",
    jobs: Annotated[int, typer.Option(min=0, help="Inputs worked on at once; 0: one per core.")] = 0,
    timeout: Annotated[float, typer.Option(min=1, help="Wall seconds for one input.")] = 300.0,
    json_: Annotated[bool, typer.Option("--json", help="One JSON object per input on standard output.")] = False,
    explain: Annotated[bool, typer.Option(help="Print every guess, with its confidence and reason.")] = False,
) -> None:
    """Turn meshes into simulation-ready assets; exit 0 when all were accepted, 1 when some were not, 2 on misuse."""
    options = Options(library=library, category=category, jobs=jobs, seconds=timeout)
    console = Console(stderr=json_)
    events: list[Event] = []
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("looking", total=None)
        for event in run(sources, options):
            events.append(event)
            counts = tally(events)
            good = len(events) - counts["refused"]
            words = f"[green]{good} accepted[/], [red]{counts['refused']} rejected[/]"
            progress.update(task, total=event.total, completed=len(events), description=words)
            _tell(event, progress.console, json_)
    if not json_:
        _conclude(events, library, console, explain)
    if tally(events)["refused"]:
        raise typer.Exit(1)
    if not events:
        console.print("[red]no mesh found[/] (.glb .gltf .obj .ply .stl .dae, manifest.jsonl, Objaverse folders)")
        raise typer.Exit(2)


ingest.__doc__ = f"{ingest.__doc__}\n{EXAMPLES}"


def _tell(event: Event, console: Console, as_json: bool) -> None:
    if as_json:
        row = {
            "status": "rejected" if event.kind == "rejected" or event.was_rejected else "accepted",
            "kept": event.kind == "kept",
            "path": event.path,
            "id": event.asset_id,
            "code": event.code,
            "says": event.says,
            "warnings": [{"code": w.code, "pointer": w.pointer, "says": w.says} for w in event.warnings],
        }
        typer.echo(json.dumps(row, sort_keys=True))
    elif event.kind == "rejected":
        console.print(
            f"[red]rejected[/] {escape(event.path)}: [bold]{event.code}[/] {escape(event.says)}", highlight=False
        )


def _conclude(events: list[Event], library: Path, console: Console, explain: bool) -> None:
    counts = tally(events)
    known = registry.load().rejections
    touched = {e.asset_id for e in events}
    rows = {e.id: e for e in entries(Library(library)) if e.id in touched}
    console.print(_accepted_table([e for e in rows.values() if e.accepted]))
    codes = Counter(e.code for e in events if e.code)
    if codes:
        table = Table("code", "reason", "inputs", "what to do", title="Rejected by reason", title_justify="left")
        for code, count in codes.most_common():
            row = known.get(code)
            table.add_row(
                code, row.meaning if row else "a check failed; see docs/checks.md", str(count), row.mend if row else ""
            )
        console.print(table)
    if explain:
        for entry in rows.values():
            _explain(entry, console)
    good = len(events) - counts["refused"]
    kept = f" ({counts['kept']} were there already)" if counts["kept"] else ""
    console.print(f"{len(events)} inputs: [green]{good} accepted[/], [red]{counts['refused']} rejected[/]{kept}")
    console.print(f"Library: {library}/   Index: {library}/index.sqlite   Next: casa-assets report --library {library}")


def _accepted_table(accepted: list[Entry], most: int = 40) -> Table:
    table = Table(
        "asset", "size (cm)", "mass", "shapes", "faces", "warnings", "source", title="Accepted", title_justify="left"
    )
    for entry in accepted[:most]:
        assert entry.summary is not None
        size = " x ".join(f"{100 * v:.3g}" for v in entry.summary.extents)
        mass = f"{entry.summary.mass:.3g} kg" if entry.summary.mass >= 1 else f"{1000 * entry.summary.mass:.3g} g"
        table.add_row(
            entry.id,
            size,
            mass,
            str(entry.summary.colliders),
            str(entry.summary.faces),
            str(len(entry.warnings)),
            escape(entry.source_path),
        )
    if len(accepted) > most:
        table.add_row(f"... and {len(accepted) - most} more", "", "", "", "", "", "")
    return table


def _explain(entry: Entry, console: Console) -> None:
    console.print(f"\n[bold]{entry.id}[/] {escape(entry.source_path)}")
    for guess in entry.guesses:
        console.print(
            f"  {guess.subject}: {escape(guess.value)} ({guess.confidence:.0%}): {escape(guess.because)}",
            highlight=False,
        )
    for issue in entry.warnings:
        console.print(f"  [yellow]{issue.code}[/] {escape(issue.pointer)}: {escape(issue.says)}", highlight=False)
    if not entry.accepted:
        console.print(f"  [red]{entry.code}[/] {escape(entry.says)}", highlight=False)
