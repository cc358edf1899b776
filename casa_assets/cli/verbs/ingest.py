"""casa-assets ingest, fetch: sources into a library, and objects of Objaverse to be such sources."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterable
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from casa_assets.cli.input_report import MOST_LISTED, print_codes, print_no_mesh_found, print_others, print_outcomes
from casa_assets.cli.progress import bar
from casa_assets.cli.supervise import StopRequested
from casa_assets.cli.text import pluralize, terminal_safe
from casa_assets.errors import BatchFault

if TYPE_CHECKING:
    from casa_assets.pipeline.ingest.job import Event
    from casa_assets.pipeline.ingest.run import Options
    from casa_assets.pipeline.reports.entry import Entry

EXAMPLES = """
Examples:

  casa-assets ingest ~/meshes                      every mesh of a folder

  casa-assets ingest mug.glb --category mug        one file of a known kind

  casa-assets ingest objaverse/ t3d/manifest.jsonl --library lib --jobs 8

  casa-assets ingest table_set.glb --split         one asset of each thing in a file

  casa-assets ingest ~/meshes --dry-run            verdicts and reasons, nothing is written

  casa-assets ingest ~/meshes --only FLT005        again what was rejected with this code

  casa-assets ingest ~/meshes --again things       again what is in review for this, and what is new

  casa-assets ingest ~/incoming --watch            work on files as they come, until Ctrl-C

  casa-assets ingest ~/meshes --json > run.jsonl   one JSON object per input
"""


def ingest(
    sources: Annotated[
        list[Path], typer.Argument(help="Files, folders, Objaverse packages, manifests.", exists=True, readable=True)
    ],
    library: Annotated[
        Path, typer.Option("--out", "--library", help="Output folder, made where it is missing.")
    ] = Path("out/library"),
    category: Annotated[str, typer.Option(help="Category of every input; else the sources and names decide.")] = "",
    jobs: Annotated[int, typer.Option(min=0, help="Inputs worked on at once.", show_default="one per core")] = 0,
    timeout: Annotated[
        float, typer.Option(min=0, help="Seconds of processor time for one input.", show_default="300")
    ] = 0.0,
    memory: Annotated[float, typer.Option(min=0, help="Gigabytes of memory for one input.", show_default="8")] = 0.0,
    max_size: Annotated[
        float, typer.Option(min=0, help="Megabytes of one input with its files.", show_default="512")
    ] = 0.0,
    max_faces: Annotated[int, typer.Option(min=0, help="Faces of one input.", show_default="2500000")] = 0,
    max_texture: Annotated[int, typer.Option(min=0, help="Pixels of a side of a picture.", show_default="16384")] = 0,
    max_pixels: Annotated[float, typer.Option(min=0, help="Million pixels of a picture.", show_default="67.2")] = 0.0,
    clip_weights: Annotated[
        str, typer.Option(help="Weights of CLIP that look at the pictures: a file, a folder or a name of open_clip's.")
    ] = "",
    keep_duplicates: Annotated[
        bool, typer.Option("--keep-duplicates", help="Keep what has form, size and colours of another.")
    ] = False,
    split: Annotated[
        bool, typer.Option("--split", help="Make one asset of each thing in a file that holds several.")
    ] = False,
    again: Annotated[
        list[str] | None,
        typer.Option(help="Work again on what was rejected with this code, or is in review for this subject."),
    ] = None,
    only: Annotated[list[str] | None, typer.Option(help="The same, and leave all other inputs out.")] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Say what would become of each input and why; write nothing.")
    ] = False,
    watch: Annotated[
        bool, typer.Option("--watch", help="Wait for new and changed files until Ctrl-C, and work on them.")
    ] = False,
    json_: Annotated[bool, typer.Option("--json", help="One JSON object per input on standard output.")] = False,
    explain: Annotated[
        bool, typer.Option("--explain", help="Print every guess, with its confidence and reason.")
    ] = False,
) -> None:
    """Turn meshes into simulation-ready assets.

    Exit 0 when all were accepted, 1 when some were rejected, 4 when none was but a person has to decide something about
    some (review.csv in the library), 2 on misuse.
    """
    from casa_assets.pipeline.ingest.run import Options

    memory_bytes, guards = int(memory * 1e9), _guards(max_size, max_faces, max_texture, max_pixels)
    codes = _codes(again), _codes(only)
    options = Options(
        library, category, jobs, timeout, memory_bytes, guards, clip_weights, keep_duplicates, split, *codes, dry_run
    )
    if watch:
        _watch(sources, options, json_)
    else:
        _ingest(sources, options, json_, explain)


ingest.__doc__ = f"{ingest.__doc__}\n{EXAMPLES}"


def _ingest(sources: list[Path], options: Options, json_: bool, explain: bool) -> None:
    """Run once, tell what became of the inputs, and end with the exit code for it."""
    from casa_assets.pipeline.ingest.run import CRASH_CODE
    from casa_assets.pipeline.ingest.run import ingest as run

    console = Console(stderr=json_)
    others: Counter[str] = Counter()
    with closing(run(sources, options, others=others)) as running:
        events = _print_events(running, console, json_, options.dry_run)
    print_others(+others, console, json_)
    if not events and options.only:
        console.print(f"nothing is rejected with, or in review for, {', '.join(sorted(options.only))}", highlight=False)
        return
    if not events:
        print_no_mesh_found(sources)
        raise typer.Exit(2)
    if options.dry_run and not json_:
        print_codes(_codes_of(events), console)
        _print_counts(events, console)
    elif not json_ or explain:
        _print_summary(events, options.library, console, explain)
    _end(events, CRASH_CODE)


def _end(events: list[Event], crash_code: str) -> None:
    """End with the exit code of a run; 0 is to return."""
    if faults := [event.path for event in events if event.code == crash_code]:
        raise BatchFault(map(terminal_safe, faults))
    if any(event.was_rejected for event in events):
        raise typer.Exit(1)
    if any(event.is_in_review for event in events):
        raise typer.Exit(4)


def _codes(words: list[str] | None) -> frozenset[str]:
    """Codes of rejections and subjects of review that a user named."""
    from casa_assets.pipeline.library.review import SUBJECTS

    for word in words or ():
        if word not in SUBJECTS and not re.fullmatch(r"[A-Z]{3}[0-9]{3}", word):
            raise typer.BadParameter(f"{word!r} is no code such as FLT005, and none of {', '.join(SUBJECTS)}")
    return frozenset(words or ())


def _watch(sources: list[Path], options: Options, json_: bool) -> None:
    """Run whenever files have changed and settled, until a signal asks to stop; told is only what is new."""
    from casa_assets.pipeline.ingest.run import ingest as run
    from casa_assets.pipeline.ingest.watch import settled_changes

    if options.dry_run or options.redone:
        raise typer.BadParameter("--watch goes with none of --dry-run, --again and --only")
    console = Console(stderr=json_)
    try:
        console.print(f"watching {pluralize(len(sources), 'place')}; Ctrl-C ends", highlight=False)
        for time_ns in settled_changes(sources, options.library):
            with closing(run(sources, replace(options, not_after_ns=time_ns))) as running:
                events = _print_events((event for event in running if event.kind != "kept"), console, json_)
            if events and not json_:
                _print_summary(events, options.library, console, explain=False)
    except StopRequested:
        console.print("stopped; the same command goes on from here", highlight=False)


def _guards(megabytes: float, faces: int, pixels: int, million_pixels: float) -> dict[str, float]:
    """Limits of the registry that this run changes; what is 0 stays as it is."""
    limits = {
        "input_bytes": megabytes * 1e6,
        "input_faces": faces,
        "input_texture_px": pixels,
        "input_texture_pixels": million_pixels * 1e6,
    }
    return {name: value for name, value in limits.items() if value}


def _print_events(running: Iterable[Event], console: Console, as_json: bool, dry_run: bool = False) -> list[Event]:
    """Print a line for each input as it is done; returns all of them."""
    events: list[Event] = []
    done = bad = unsure = 0
    with bar(console) as progress:
        task = progress.add_task("looking", total=None)
        for event in running:
            events.append(event)
            done += event.count
            bad += event.count * event.was_rejected
            unsure += event.is_in_review
            words = f"[green]{done - bad - unsure} accepted[/], [yellow]{unsure} in review[/], [red]{bad} rejected[/]"
            progress.update(task, total=event.total, completed=done, description=words)
            if as_json or event.kind != "kept" or event.total <= MOST_LISTED:
                _print_event(event, progress.console, as_json, dry_run)
    return events


def _print_event(event: Event, console: Console, as_json: bool, dry_run: bool) -> None:
    if as_json:
        row = {
            "status": event.decision.value,
            "to_decide": event.to_decide,
            "kept": event.kind == "kept",
            "path": event.path,
            "id": event.asset_id,
            "code": event.code,
            "message": event.message,
            "count": event.count,
            "dry_run": dry_run,
            "seconds": {name: round(value, 3) for name, value in event.seconds.items()},
            "warnings": [{"code": w.code, "pointer": w.pointer, "message": w.message} for w in event.warnings],
        }
        typer.echo(json.dumps(row, sort_keys=True))
    elif event.kind == "rejected":
        console.print(
            f"[red]rejected[/] {_safe(event.path)}: [bold]{event.code}[/] {_lines(event.message)}",
            highlight=False,
            soft_wrap=True,
        )
    elif dry_run:
        color = "yellow" if event.is_in_review else "green"
        console.print(
            f"[{color}]{event.decision.value}[/] {_safe(event.path)}: {event.asset_id}", highlight=False, soft_wrap=True
        )
        for warning in event.warnings if event.is_in_review else ():
            console.print(f"  {_safe(warning.pointer)}: {_safe(warning.message)}", highlight=False, soft_wrap=True)


def _print_summary(events: list[Event], library: Path, console: Console, explain: bool) -> None:
    from casa_assets.model.issue import Decision
    from casa_assets.pipeline.library.entry_table import EntryTable
    from casa_assets.pipeline.library.library import Library

    touched = {e.asset_id for e in events}
    if len(touched) > MOST_LISTED:
        touched = {e.asset_id for e in events if e.kind != "kept"}
    rows = {e.id: e for e in EntryTable(Library(library)).entries if e.id in touched} if touched else {}
    if accepted := [e for e in rows.values() if e.decision is Decision.ACCEPTED]:
        console.print(_accepted_table(accepted))
    if in_review := [e for e in rows.values() if e.decision is Decision.REVIEW]:
        console.print(_review_table(in_review))
    print_codes(_codes_of(events), console)
    if explain:
        for entry in rows.values():
            _print_guesses(entry, console)
    _print_library_checks(library, console)
    unsure = _print_counts(events, console)
    place = _safe(str(library))
    lines = [f"Library: {place}/", f"Index:   {place}/index.sqlite"]
    lines += [f"Review:  {place}/review.csv; accept or correct there, then run again"] if unsure else []
    lines += [f"Next:    casa-assets report --library {place}"]
    console.print("\n".join(lines), highlight=False, soft_wrap=True)


def _codes_of(events: list[Event]) -> Counter[str]:
    """Inputs by the code that they were rejected with."""
    codes: Counter[str] = Counter()
    for event in events:
        codes[event.code] += event.count * bool(event.code)
    return +codes


def _print_counts(events: list[Event], console: Console) -> int:
    """How fast the stages were, and how many inputs were accepted, in review and rejected; returns those in review."""
    from casa_assets.model.issue import Decision
    from casa_assets.pipeline.ingest.run import tally
    from casa_assets.pipeline.ingest.stage_times import throughput

    if stages := throughput(event.seconds for event in events):
        table = Table(title="Throughput of one worker", title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
        for name in ("stage", "inputs", "seconds", "inputs per second"):
            table.add_column(name, no_wrap=True, justify="left" if name == "stage" else "right")
        for one in stages:
            table.add_row(one.stage, f"{one.inputs:,}", f"{one.seconds:.1f}", f"{one.per_second:,.3g}")
        console.print(table)
    counts = tally(events)
    accepted, unsure, rejected = (counts[decision.value] for decision in Decision)
    print_outcomes(accepted, unsure, rejected, counts["kept"], console)
    return unsure


def _print_library_checks(library: Path, console: Console, max_lines: int = 6) -> None:
    """Lines about the checks of all assets of the library together."""
    from casa_assets.model.issue import Status
    from casa_assets.pipeline.dedup.library_report import read_library_report

    library_report = read_library_report(library)
    issues = library_report.report.issues if library_report else ()
    for issue in issues[:max_lines]:
        place = f"{issue.pointer} " if issue.pointer else ""
        console.print(f"[yellow]{issue.code}[/] {place}{_safe(issue.message)}", highlight=False)
    for result in library_report.report.results if library_report else ():
        if result.status is Status.NOT_RUN:
            console.print(f"[yellow]{result.code}[/] not run: {_safe(result.reason)}", highlight=False)
    if len(issues) > max_lines:
        console.print(
            f"... and {len(issues) - max_lines} more about the library as a whole, see the report", soft_wrap=True
        )


def _accepted_table(accepted: list[Entry], max_rows: int = 40) -> Table:
    table = Table(title="Accepted", title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    rows = [_cells(entry) for entry in accepted[:max_rows]]
    names = "asset", "size (cm)", "mass", "shapes", "checks", "warn"
    for i, name in enumerate(names):
        width = max((len(row[i]) for row in rows), default=0)
        # A column that may shrink is cut before the last one folds.
        justify: Literal["left", "right"] = "left" if i < 2 else "right"
        table.add_column(name, no_wrap=True, min_width=max(width, len(name)), justify=justify)
    table.add_column("source", overflow="fold")
    for row in rows:
        table.add_row(*row)
    if len(accepted) > max_rows:
        table.add_row(f"... and {len(accepted) - max_rows} more", "", "", "", "", "", "")
    return table


def _review_table(in_review: list[Entry], max_rows: int = 40) -> Table:
    table = Table(title="In review", title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for name in ("asset", "size (cm)", "mass", "for you to decide", "source"):
        table.add_column(name, no_wrap=name in ("asset", "mass"), overflow="fold")
    for entry in in_review[:max_rows]:
        name, size, mass, *_, source = _cells(entry)
        table.add_row(name, size, mass, ", ".join(entry.to_decide), source)
    if len(in_review) > max_rows:
        table.add_row(f"... and {len(in_review) - max_rows} more", "", "", "", "")
    return table


def _cells(entry: Entry) -> tuple[str, ...]:
    """Id, size, mass, collision shapes, checks passed of those that apply, warnings and source of an accepted asset."""
    assert entry.summary is not None
    size = " x ".join(f"{100 * v:.3g}" for v in entry.summary.extents)
    mass = f"{entry.summary.mass:.3g} kg" if entry.summary.mass >= 1 else f"{1000 * entry.summary.mass:.3g} g"
    checks = entry.checks
    shapes, warned = str(entry.summary.colliders), str(len(entry.warnings))
    return entry.id, size, mass, shapes, f"{checks.passed}/{checks.applying}", warned, _safe(entry.source_path)


def _print_guesses(entry: Entry, console: Console) -> None:
    console.print(f"\n[bold]{entry.id}[/] {_safe(entry.source_path)}")
    for guess in entry.guesses:
        console.print(
            f"  {guess.subject}: {_safe(guess.value)} ({guess.confidence:.0%}): {_safe(guess.reason)}",
            highlight=False,
        )
    for issue in entry.warnings:
        console.print(f"  [yellow]{issue.code}[/] {_safe(issue.pointer)}: {_safe(issue.message)}", highlight=False)
    if not entry.accepted:
        console.print(f"  [red]{entry.code}[/] {_safe(entry.message)}", highlight=False)


def _safe(words: str) -> str:
    """Words of strangers, fit for a line with markup."""
    return escape(terminal_safe(words))


def _lines(words: str) -> str:
    return "\n".join(_safe(line) for line in words.split("\n"))


def fetch(
    uids: Annotated[list[str] | None, typer.Argument(help="Objaverse uids.")] = None,
    category: Annotated[str, typer.Option(help="LVIS category to take objects of, such as Mug.")] = "",
    most: Annotated[int, typer.Option(min=1, help="How many objects at most.")] = 20,
    into: Annotated[Path, typer.Option("--out", "--into", help="Folder for the download.")] = Path("out/objaverse"),
) -> None:
    """Download objects of Objaverse with the `objaverse` package, which needs a network.

    Examples:

      casa-assets fetch --category Mug --most 10

      casa-assets ingest out/objaverse/hf-objaverse-v1
    """
    from casa_assets.ingest.sources.objaverse import download

    if not uids and not category:
        raise typer.BadParameter("name uids, or a --category")
    folder = download(uids or [], category, most, into)
    Console().print(f"Objects: {folder}   Next: casa-assets ingest {folder}", highlight=False, soft_wrap=True)
