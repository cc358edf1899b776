"""casa-assets ingest, fetch: sources into a library, and objects of Objaverse to be such sources."""

from __future__ import annotations

import os
import re
from collections import Counter
from contextlib import closing
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from casa_assets.cli.input_report import MOST_LISTED, print_codes, print_no_mesh_found, print_others, print_outcomes
from casa_assets.cli.options import (
    CLIP_HELP,
    Address,
    AsJson,
    Category,
    DryRun,
    Engine,
    EngineName,
    Jobs,
    LibraryOut,
    Most,
    Out,
    Quiet,
    Verbose,
    more,
    workers,
)
from casa_assets.cli.output import Output, measures
from casa_assets.cli.progress import bar
from casa_assets.cli.supervise import StopRequested
from casa_assets.cli.tables import TextTable
from casa_assets.cli.text import duration, pluralize, terminal_safe
from casa_assets.errors import BatchFault

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Sequence

    from casa_assets.pipeline.ingest.estimate import Interval
    from casa_assets.pipeline.ingest.job import Event
    from casa_assets.pipeline.ingest.run import Options
    from casa_assets.pipeline.reports.entry import Entry

# Rows of a table that are printed where the user did not ask for more words.
MAX_ROWS = 40
USUAL_CORES = (64, 1024)  # for which --estimate prints the time besides those of this machine
EXAMPLES = """
Examples:

  casa-assets ingest ~/meshes                      every mesh of a folder

  casa-assets ingest mug.glb --category mug        one file of a known kind

  casa-assets ingest objaverse/ t3d/manifest.jsonl --out lib --jobs 8

  casa-assets ingest table_set.glb --split         one asset of each thing in a file

  casa-assets ingest ~/meshes --dry-run            verdicts and reasons, nothing is written

  casa-assets ingest ~/meshes --only FLT005        retry what was rejected with this code, nothing else

  casa-assets ingest ~/meshes --again things       retry what is in review for this, and take what is new

  casa-assets ingest ~/meshes --estimate 40        core-hours, memory, disk, and hours on so many cores

  casa-assets ingest ~/incoming --watch            work on files as they come, until Ctrl-C

  casa-assets ingest ~/meshes --json > run.jsonl   one JSON object per input
"""


# An option that bounds an input; 0 stands for the default, which its help names.
_limit = partial(typer.Option, min=0, show_default=False)
Watch = Annotated[bool, typer.Option("--watch", help="Wait for new and changed files until Ctrl-C, and work on them.")]
Explain = Annotated[
    bool, typer.Option("--explain", help="Print every guess, with its confidence and reason; not with --dry-run.")
]
Sample = Annotated[
    int, typer.Option("--estimate", help="Work on so many inputs, keep nothing; print what all would take.", min=0)
]
Cores = Annotated[
    list[int] | None, typer.Option("--cores", help="Number of cores to print the time for, with --estimate.", min=1)
]


def ingest(
    sources: Annotated[
        list[Path], typer.Argument(help="Files, folders, Objaverse packages, manifests.", exists=True, readable=True)
    ],
    library: LibraryOut = Path("out/library"),
    category: Category = "",
    jobs: Jobs = 0,
    engine: Engine = EngineName.LOCAL,
    address: Address = "",
    timeout: Annotated[float, _limit(help="Processor seconds per input; 300 by default.")] = 0.0,
    memory: Annotated[float, _limit(help="Gigabytes per input; 8 by default.")] = 0.0,
    max_size: Annotated[float, _limit(help="Megabytes of an input; 512 by default.")] = 0.0,
    max_faces: Annotated[int, _limit(help="Faces of an input; 2500000 by default.")] = 0,
    max_texture: Annotated[int, _limit(help="Pixels of a side; 16384 by default.")] = 0,
    max_pixels: Annotated[float, _limit(help="Million pixels; 67.2 by default.")] = 0.0,
    clip_weights: Annotated[str, typer.Option(help=more(CLIP_HELP, "compares pictures."))] = "",
    keep_duplicates: Annotated[
        bool, typer.Option("--keep-duplicates", help="Keep meshes that duplicate one that is already in the library.")
    ] = False,
    split: Annotated[
        bool, typer.Option("--split", help="Make one asset of each thing in a file that holds several.")
    ] = False,
    again: Annotated[
        list[str] | None,
        typer.Option(help="Also retry inputs that were rejected with this code, or are in review for this subject."),
    ] = None,
    only: Annotated[list[str] | None, typer.Option(help="Retry only such inputs, and leave all others out.")] = None,
    dry_run: DryRun = False,
    watch: Watch = False,
    explain: Explain = False,
    estimate: Sample = 0,
    cores: Cores = None,
    json_: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Turn meshes into simulation-ready assets.

    Exit 0 when all were accepted, 1 when some were rejected, 4 when none was rejected but a person has to decide about
    some (review.csv in the library), 2 on misuse.
    """
    from casa_assets.pipeline.ingest.run import Options

    if explain and dry_run:
        raise typer.BadParameter("--dry-run keeps no guesses; name another --library and leave --dry-run out")
    where = workers(engine, address, jobs)
    memory_bytes, guards = int(memory * 1e9), _guards(max_size, max_faces, max_texture, max_pixels)
    codes = _codes(again), _codes(only)
    options = Options(
        library, category, where, timeout, memory_bytes, guards, clip_weights, keep_duplicates, split, *codes, dry_run
    )
    output = Output(json_, quiet, verbose)
    if estimate:
        if watch or explain or dry_run:
            raise typer.BadParameter("goes with none of --watch, --explain and --dry-run", param_hint="--estimate")
        _estimate(sources, options, estimate, cores or (), output)
    elif watch:
        _watch(sources, options, output)
    else:
        _ingest(sources, options, output, explain)


ingest.__doc__ = f"{ingest.__doc__}\n{EXAMPLES}"


def _ingest(sources: list[Path], options: Options, output: Output, explain: bool) -> None:
    """Run once, tell what became of the inputs, and end with the exit code for it."""
    from casa_assets.pipeline.ingest.run import CRASH_CODE
    from casa_assets.pipeline.ingest.run import ingest as run

    others: Counter[str] = Counter()

    def start(show_work: Callable[[str], None] | None) -> Generator[Event]:
        return run(sources, options, others=others, show_work=show_work)

    events = _print_events(start, output, options.dry_run)
    print_others(+others, output)
    if not events and options.only:
        output.line(f"nothing is rejected with, or in review for, {', '.join(sorted(options.only))}")
        return
    if not events:
        print_no_mesh_found(sources, output)
        raise typer.Exit(2)
    if options.dry_run and not output.as_json:
        print_codes(_codes_of(events), output)
        _print_counts(events, output)
    elif not output.as_json or explain:
        _print_summary(events, options.library, output, explain)
    if not options.dry_run:
        output.look(*[event.folder for event in events if event.folder and not event.was_rejected][:1])
    _end(events, CRASH_CODE)


def _estimate(sources: list[Path], options: Options, sample: int, cores: Sequence[int], output: Output) -> None:
    """Print what a run would take."""
    from casa_assets.pipeline.ingest.estimate import count_inputs, estimate, sample_run

    counts = cores or (len(os.sched_getaffinity(0)), *USUAL_CORES)
    # Of single inputs only those are told that are rejected.
    events = _print_events(partial(sample_run, sources, options, sample), Output(quiet=True))
    if not events:
        print_no_mesh_found(sources, output)
        raise typer.Exit(2)
    found = estimate(events, count_inputs(sources, options.library), counts)
    if output.as_json:
        output.row({"id": "estimate", "folder": "", **asdict(found)})
        return
    table = TextTable(("", "estimate", "9 of 10 resamples"), right=("estimate", "9 of 10 resamples"))
    table.title = f"{found.inputs:,} inputs, by {found.sampled} of them"
    rows: list[tuple[str, Interval, Callable[[float], str]]] = [
        ("core-hours", found.core_hours, lambda hours: f"{hours:,.3g}"),
        ("disk, GB", found.disk_bytes, lambda count: f"{count / 1e9:,.3g}"),
        *((f"{n:,} cores", found.hours[n], lambda hours: duration(3600 * hours)) for n in counts),
    ]
    for name, interval, written in rows:
        low, middle, high = map(written, (interval.low, interval.middle, interval.high))
        table.add(name, middle, f"{low} to {high}")
    table.print(output.console)
    output.line(f"Memory: {found.peak_bytes / 1e9:.2g} GB at most, of one input of the sample, with what workers share")
    if found.kept:
        output.line(f"{found.kept} of the sample are in the library already and cost nothing")


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


def _watch(sources: list[Path], options: Options, output: Output) -> None:
    """Run whenever files have changed and settled, until a signal asks to stop; told is only what is new."""
    from casa_assets.pipeline.ingest.run import ingest as run
    from casa_assets.pipeline.ingest.watch import settled_changes

    if options.dry_run or options.redone:
        raise typer.BadParameter("--watch goes with none of --dry-run, --again and --only")
    try:
        output.line(f"watching {pluralize(len(sources), 'place')}; Ctrl-C ends")
        for time_ns in settled_changes(sources, options.library):
            settled = replace(options, not_after_ns=time_ns)
            events = _print_events(partial(_new_events, run, sources, settled), output)
            if events and not output.as_json:
                _print_summary(events, options.library, output, explain=False)
    except StopRequested:
        output.line("stopped; the same command goes on from here")


def _new_events(
    run: Callable[..., Generator[Event]],
    sources: list[Path],
    options: Options,
    show_work: Callable[[str], None] | None,
) -> Generator[Event]:
    """The events of a run that are not about what was there already."""
    with closing(run(sources, options, show_work=show_work)) as running:
        yield from (event for event in running if event.kind != "kept")


def _guards(megabytes: float, faces: int, pixels: int, million_pixels: float) -> dict[str, float]:
    """Limits of the registry that this run changes; what is 0 stays as it is."""
    limits = {
        "input_bytes": megabytes * 1e6,
        "input_faces": faces,
        "input_texture_px": pixels,
        "input_texture_pixels": million_pixels * 1e6,
    }
    return {name: value for name, value in limits.items() if value}


def _print_events(
    start: Callable[[Callable[[str], None] | None], Generator[Event]], output: Output, dry_run: bool = False
) -> list[Event]:
    """Run, print a line for each input as it is done, and return all of them.

    Args:
        start: begins the run; it takes what is called with the path of each input that is begun.
    """
    events: list[Event] = []
    done = bad = unsure = 0
    begun: dict[str, None] = {}
    with bar(output.console) as progress:
        task = progress.add_task("looking", total=None)

        def show() -> None:
            counts = f"[green]{done - bad - unsure} ok[/], [yellow]{unsure} in review[/], [red]{bad} rejected[/]"
            name = f"; {_safe(Path(next(iter(begun))).name)}" if begun else ""
            progress.update(task, completed=done, description=f"{counts}{name}")

        def show_work(path: str) -> None:
            begun[path] = None
            show()

        with closing(start(show_work)) as running:
            for event in running:
                events.append(event)
                begun.pop(event.path, None)
                done += event.count
                bad += event.count * event.was_rejected
                unsure += event.is_in_review
                progress.update(task, total=event.total)
                show()
                if event.kind != "kept" or event.total <= MOST_LISTED or output.verbose or output.as_json:
                    _print_event(event, output, dry_run)
    return events


def _print_event(event: Event, output: Output, dry_run: bool) -> None:
    if output.as_json:
        output.row(_json_row(event, dry_run))
    elif event.kind == "rejected" or (output.verbose and event.was_rejected):
        output.failures.print(
            f"[red]rejected[/] {_safe(event.path)}: [bold]{event.code}[/] {_lines(event.message)}",
            highlight=False,
            soft_wrap=True,
        )
    elif dry_run or output.verbose:
        color = "yellow" if event.is_in_review else "green"
        kept = " (there already)" if event.kind == "kept" else ""
        seconds = f" in {sum(event.seconds.values()):.1f} s" if event.seconds else ""
        output.console.print(
            f"[{color}]{event.decision.value}[/]{kept} {_safe(event.path)}: {event.asset_id}{seconds}",
            highlight=False,
            soft_wrap=True,
        )
        for warning in event.warnings if event.is_in_review else ():
            output.line(f"  {terminal_safe(warning.pointer)}: {terminal_safe(warning.message)}")


def _json_row(event: Event, dry_run: bool) -> dict[str, object]:
    """What `--json` tells of an input."""
    return {
        "status": event.decision.value,
        "verdict": event.decision.value,
        "folder": "" if event.folder is None else str(event.folder),
        **measures(event.summary),
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


def _print_summary(events: list[Event], library: Path, output: Output, explain: bool) -> None:
    from casa_assets.model.issue import Decision
    from casa_assets.pipeline.library.entry_table import EntryTable
    from casa_assets.pipeline.library.library import Library

    touched = {e.asset_id for e in events}
    if len(touched) > MOST_LISTED:
        touched = {e.asset_id for e in events if e.kind != "kept"}
    rows = {e.id: e for e in EntryTable(Library(library)).entries if e.id in touched} if touched else {}
    most = len(rows) if output.verbose else MAX_ROWS
    _accepted_table([e for e in rows.values() if e.decision is Decision.ACCEPTED], most).print(output.console)
    _review_table([e for e in rows.values() if e.decision is Decision.REVIEW], most).print(output.console)
    print_codes(_codes_of(events), output)
    if explain:
        for entry in rows.values():
            _print_guesses(entry, output)
    _print_library_checks(library, output)
    unsure = _print_counts(events, output)
    place = terminal_safe(str(library))
    output.line(f"Library: {place}/")
    output.line(f"Index:   {place}/index.sqlite")
    if unsure:
        output.line(f"Review:  {place}/review.csv; accept or correct there, then run again")
    output.line(f"Next:    casa-assets report --library {place}")


def _codes_of(events: list[Event]) -> Counter[str]:
    """Inputs by the code that they were rejected with."""
    codes: Counter[str] = Counter()
    for event in events:
        codes[event.code] += event.count * bool(event.code)
    return +codes


def _print_counts(events: list[Event], output: Output) -> int:
    """How fast the stages were, and how many inputs were accepted, in review and rejected; returns those in review."""
    from casa_assets.model.issue import Decision
    from casa_assets.pipeline.ingest.run import tally
    from casa_assets.pipeline.ingest.stage_times import throughput

    heads = ("stage", "inputs", "seconds", "inputs per second")
    table = TextTable(heads, right=heads[1:], title="Throughput of one worker")
    for one in throughput(event.seconds for event in events):
        table.add(one.stage, f"{one.inputs:,}", f"{one.seconds:.1f}", f"{one.per_second:,.3g}")
    table.print(output.console)
    counts = tally(events)
    accepted, unsure, rejected = (counts[decision.value] for decision in Decision)
    print_outcomes(accepted, unsure, rejected, counts["kept"], output)
    return unsure


def _print_library_checks(library: Path, output: Output, max_lines: int = 6) -> None:
    """Lines about the checks of all assets of the library together."""
    from casa_assets.model.issue import Status
    from casa_assets.pipeline.dedup.library_report import read_library_report

    library_report = read_library_report(library)
    issues = library_report.report.issues if library_report else ()
    shown = issues if output.verbose else issues[:max_lines]
    for issue in shown:
        place = f"{issue.pointer} " if issue.pointer else ""
        output.console.print(f"[yellow]{issue.code}[/] {place}{_safe(issue.message)}", highlight=False, soft_wrap=True)
    for result in library_report.report.results if library_report else ():
        if result.status is Status.NOT_RUN:
            message = f"[yellow]{result.code}[/] not run: {_safe(result.reason)}"
            output.console.print(message, highlight=False, soft_wrap=True)
    if len(issues) > len(shown):
        output.line(f"... and {len(issues) - len(shown)} more about the library as a whole, see the report")


def _accepted_table(accepted: list[Entry], most: int = MAX_ROWS) -> TextTable:
    heads = "asset", "size (cm)", "mass", "shapes", "checks", "warn", "source"
    table = TextTable(heads, right=heads[2:-1], title="Accepted")
    for entry in accepted[:most]:
        table.add(*_cells(entry))
    if len(accepted) > most:
        table.add(f"... and {len(accepted) - most} more", *[""] * (len(heads) - 1))
    return table


def _review_table(in_review: list[Entry], most: int = MAX_ROWS) -> TextTable:
    heads = "asset", "size (cm)", "mass", "for you to decide", "source"
    table = TextTable(heads, right=("mass",), title="In review")
    for entry in in_review[:most]:
        name, size, mass, *_, source = _cells(entry)
        table.add(name, size, mass, ", ".join(entry.to_decide), source)
    if len(in_review) > most:
        table.add(f"... and {len(in_review) - most} more", *[""] * (len(heads) - 1))
    return table


def _cells(entry: Entry) -> tuple[str, ...]:
    """Id, size, mass, collision shapes, checks passed of those that apply, warnings and source of an accepted asset."""
    assert entry.summary is not None
    size = " x ".join(f"{100 * v:.3g}" for v in entry.summary.extents)
    mass = f"{entry.summary.mass:.3g} kg" if entry.summary.mass >= 1 else f"{1000 * entry.summary.mass:.3g} g"
    checks = entry.checks
    shapes, warned = str(entry.summary.colliders), str(len(entry.warnings))
    return entry.id, size, mass, shapes, f"{checks.passed}/{checks.applying}", warned, terminal_safe(entry.source_path)


def _print_guesses(entry: Entry, output: Output) -> None:
    output.console.print(f"\n[bold]{entry.id}[/] {_safe(entry.source_path)}", soft_wrap=True)
    lines = [f"  {g.subject}: {_safe(g.value)} ({g.confidence:.0%}): {_safe(g.reason)}" for g in entry.guesses]
    lines += [f"  [yellow]{i.code}[/] {_safe(i.pointer)}: {_safe(i.message)}" for i in entry.warnings]
    lines += [] if entry.accepted else [f"  [red]{entry.code}[/] {_safe(entry.message)}"]
    for line in lines:
        output.console.print(line, highlight=False, soft_wrap=True)


def _safe(words: str) -> str:
    """Words of strangers, fit for a line with markup."""
    return escape(terminal_safe(words))


def _lines(words: str) -> str:
    return "\n".join(_safe(line) for line in words.split("\n"))


def fetch(
    uids: Annotated[list[str] | None, typer.Argument(help="Objaverse uids.")] = None,
    lvis: Annotated[str, typer.Option(help="LVIS category of Objaverse to take objects of, such as Mug.")] = "",
    most: Most = 20,
    out: Out = Path("out/objaverse"),
    json_: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Download objects of Objaverse with the `objaverse` package, which needs a network.

    Exit 0 when they are there, 2 on misuse or without a network.

    Examples:

      casa-assets fetch --lvis Mug --most 10

      casa-assets ingest out/objaverse/hf-objaverse-v1
    """
    from casa_assets.ingest.sources.objaverse import download

    if not uids and not lvis:
        raise typer.BadParameter("name uids, or an --lvis category")
    output = Output(json_, quiet, verbose)
    folder = download(uids or [], lvis, most, out)
    output.made(lvis or "objaverse", folder)
    output.line(f"Objects: {folder}   Next: casa-assets ingest {folder}")
