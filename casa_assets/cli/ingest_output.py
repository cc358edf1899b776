"""Output of commands that bring inputs into a library or copy one: each input, tables, counts and the exit code."""

from __future__ import annotations

import shlex
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from casa_assets.cli.output import (
    Output,
    TextTable,
    bar,
    issue_rows,
    measures,
    pluralize,
    safe,
    safe_message,
    terminal_safe,
)
from casa_assets.errors import BatchFault, CasaError

if TYPE_CHECKING:
    from collections.abc import Callable, Generator

    from casa_assets.articulate.run.steps import ArticulateOutcome
    from casa_assets.library.entry import Entry
    from casa_assets.model.issue import Decision
    from casa_assets.runs.outcome import Event
    from casa_assets.runs.remote import Change

    Done = Event | ArticulateOutcome

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


def counts_of(done: Sequence[Done]) -> tuple[int, int, int]:
    """Return how many inputs were accepted, are in review, and were rejected."""
    from casa_assets.model.issue import Decision

    accepted, in_review, rejected = (sum(one.count for one in done if one.decision is each) for each in Decision)
    return accepted, in_review, rejected


def counts_text(accepted: int, in_review: int, rejected: int, ok: str = "accepted") -> str:
    """Return how many were accepted, are in review and were rejected, with markup."""
    return f"[green]{accepted} {ok}[/], [yellow]{in_review} in review[/], [red]{rejected} rejected[/]"


def print_counts(done: Sequence[Done], kept: int, output: Output) -> int:
    """Print how many inputs were accepted, in review and rejected, of them `kept` by earlier runs; returns the second.

    Before that, how many were rejected for each reason.
    """
    codes: Counter[str] = Counter()
    for one in done:
        codes[one.code] += one.count * bool(one.code)
    print_codes(+codes, output)
    counts = counts_of(done)
    there = f" ({kept} {'was' if kept == 1 else 'were'} there already)" if kept else ""
    output.styled(f"{pluralize(sum(counts), 'input')}: {counts_text(*counts)}{there}")
    return counts[1]


def look(done: Sequence[Done], output: Output) -> None:
    """Print the command that shows the first asset that was made."""
    from casa_assets.model.issue import Decision

    output.look(*[one.folder for one in done if one.folder and one.decision is not Decision.REJECTED][:1])


def end(done: Sequence[Done], names: Sequence[str]) -> None:
    """End with exit 3 after a fault of the program, 1 after a rejection, 4 where a person has to decide.

    Args:
        names: of the inputs, in the same order.
    """
    from casa_assets.runs.outcome import CRASH_CODE

    if faults := [name for name, one in zip(names, done, strict=True) if one.code == CRASH_CODE]:
        raise BatchFault(map(terminal_safe, faults))
    _, in_review, rejected = counts_of(done)
    if rejected:
        raise typer.Exit(1)
    if in_review or any(one.reason_kept for one in done):
        raise typer.Exit(4)


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
        from casa_assets.show.page.page_template import explanations

        why = explanations()
    for code, count in codes.most_common():
        row = records.rejections.get(code)
        meaning, advice = (row.meaning, row.remedy) if row else (why.get(code, ""), "as the line of each input says")
        table.add(code, meaning, str(count), advice)
    table.print(output.console)


def print_review(count: int, asks_category: bool, library: Path, output: Output) -> None:
    """Print how to decide about the inputs in review; nothing if there are no such inputs.

    Args:
        asks_category: the category of some of them is unknown.
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


# Rows of a table that are printed where the user did not ask for more words.
MAX_ROWS = 40


def print_events(
    start: Callable[[Callable[[str], None] | None], Generator[Event]], output: Output, dry_run: bool = False
) -> list[Event]:
    """Run, print a line for each input as it is done, and return all of them.

    Args:
        start: begins the run; it takes what is called with the path of each input that is begun.
    """
    events: list[Event] = []
    done = bad = unsure = 0
    begun: dict[str, None] = {}
    last_begun = 0.0
    with bar(output.console) as progress:
        task = progress.add_task("looking", total=None)

        def show() -> None:
            name = f"; {safe(Path(next(iter(begun))).name)}" if begun else ""
            counts = counts_text(done - bad - unsure, unsure, bad, ok="ok")
            progress.update(task, completed=done, description=f"{counts}{name}")

        def show_work(path: str) -> None:
            nonlocal last_begun
            begun[path] = None
            last_begun = time.monotonic()
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
                is_news = event.kind != "kept" or bool(event.reason_kept)
                if is_news or event.total <= MOST_LISTED or output.verbose or output.as_json:
                    _print_event(event, output, dry_run)
    if last_begun and output.verbose:
        output.line(f"Tail:    the last input was begun {time.monotonic() - last_begun:.0f} s before the end")
    return events


def _print_event(event: Event, output: Output, dry_run: bool) -> None:
    if output.as_json:
        output.row(_json_row(event, dry_run))
    elif event.kind == "rejected" or (output.verbose and event.was_rejected):
        message = safe_message(event.message, event.path)
        output.styled(f"[red]rejected[/] {safe(event.path)}: [bold]{event.code}[/] {message}", is_wrong=True)
    elif event.reason_kept:
        output.styled(f"[yellow]kept[/] {safe(event.path)}: {safe(event.reason_kept)}")
    elif dry_run or output.verbose:
        color = "yellow" if event.is_in_review else "green"
        kept = " (there already)" if event.kind == "kept" else ""
        output.styled(f"[{color}]{event.decision.value}[/]{kept} {safe(event.path)}: {event.asset_id}")
        for warning in event.warnings if event.is_in_review else ():
            output.line(f"  {terminal_safe(warning.pointer)}: {terminal_safe(warning.message)}")


def _json_row(event: Event, dry_run: bool) -> dict[str, object]:
    """The row that `--json` prints for an input."""
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
        "warnings": issue_rows(event.warnings),
    }


def print_summary(events: list[Event], library: Path, output: Output, explain: bool = False) -> None:
    """Print what became of the inputs of a run, and where to find it.

    Args:
        explain: also every guess.
    """
    from casa_assets.library.entry_table import EntryTable
    from casa_assets.library.library import Library
    from casa_assets.model.issue import Decision

    touched = {e.asset_id for e in events}
    if len(touched) > MOST_LISTED:
        touched = {e.asset_id for e in events if e.kind != "kept"}
    rows = {e.id: e for e in EntryTable(Library(library)).entries if e.id in touched} if touched else {}
    most = len(rows) if output.verbose else MAX_ROWS
    for decision in (Decision.ACCEPTED, Decision.REVIEW):
        _table([entry for entry in rows.values() if entry.decision is decision], decision, most).print(output.console)
    if explain:
        for entry in rows.values():
            _print_guesses(entry, output)
    _print_library_checks(library, output)
    unsure = print_counts(events, sum(event.count for event in events if event.kind == "kept"), output)
    place = terminal_safe(str(library))
    output.line(f"Library: {place}/")
    print_review(unsure, any("category" in event.to_decide for event in events), library, output)
    output.next_command("report", "--library", library)


def _print_library_checks(library: Path, output: Output, max_lines: int = 6) -> None:
    """Lines about the checks of all assets of the library together."""
    from casa_assets.library.library_report import read_library_report
    from casa_assets.model.issue import Status

    library_report = read_library_report(library)
    issues = library_report.report.issues if library_report else ()
    shown = issues if output.verbose else issues[:max_lines]
    for issue in shown:
        place = f"{issue.pointer} " if issue.pointer else ""
        output.styled(f"[yellow]{issue.code}[/] {place}{safe(issue.message)}")
    for result in library_report.report.results if library_report else ():
        if result.status is Status.NOT_RUN and output.verbose:
            output.styled(f"[yellow]{result.code}[/] not run: {safe(result.reason)}")
    if len(issues) > len(shown):
        output.line(f"... and {len(issues) - len(shown)} more about the library as a whole, see the report")


def _table(found: list[Entry], decision: Decision, most: int) -> TextTable:
    """Numbers of accepted assets, or of those in review and what a person has to decide about them."""
    from casa_assets.model.issue import Decision

    is_accepted = decision is Decision.ACCEPTED
    about = ("shapes", "checks", "advice") if is_accepted else ("for you to decide",)
    heads = ("asset", "size (cm)", "mass", *about, "source")
    right = heads[2:-1] if is_accepted else ("mass",)
    table = TextTable(heads, right=right, title="Accepted" if is_accepted else "In review")
    for entry in found[:most]:
        assert entry.summary is not None
        size = " x ".join(f"{100 * v:.3g}" for v in entry.summary.extents)
        mass = f"{entry.summary.mass:.3g} kg" if entry.summary.mass >= 1 else f"{1000 * entry.summary.mass:.3g} g"
        checks = f"{entry.checks.passed}/{entry.checks.applying}"
        numbers = (str(entry.summary.colliders), checks, str(len(entry.warnings)))
        cells = numbers if is_accepted else (", ".join(entry.to_decide),)
        table.add(entry.id, size, mass, *cells, terminal_safe(entry.source_path))
    if len(found) > most:
        table.add(f"... and {len(found) - most} more", *[""] * (len(heads) - 1))
    return table


def _print_guesses(entry: Entry, output: Output) -> None:
    output.console.print(f"\n[bold]{entry.id}[/] {safe(entry.source_path)}", soft_wrap=True)
    lines = [f"  {g.subject}: {safe(g.value)} ({g.confidence:.0%}): {safe(g.reason)}" for g in entry.guesses]
    lines += [f"  [yellow]{i.code}[/] {safe(i.pointer)}: {safe(i.message)}" for i in entry.warnings]
    lines += [] if entry.accepted else [f"  [red]{entry.code}[/] {safe(entry.message)}"]
    for line in lines:
        output.styled(line)


WORDS = ("copied", "kept", "removed", "failed")


def print_changes(changes: Iterator[Change], word: str, output: Output, rows_in: Path | None = None) -> str:
    """Show a bar while entries are copied; returns how many were copied, kept and removed, in words.

    Args:
        word: what is done, such as `pushing`.
        rows_in: library whose entries are printed as rows of --json; None: no rows.
    """
    counts: Counter[str] = Counter()
    sent = 0
    with bar(output.console) as progress:
        task = progress.add_task(word, total=None)
        for change in changes:
            counts[change.kind] += 1
            sent += change.bytes_copied
            name = terminal_safe(change.path)
            progress.update(
                task,
                completed=counts.total() - counts["removed"],
                total=change.total,
                description=f"{word} {safe(change.path)}",
            )
            if rows_in is not None:
                folder = rows_in / change.path
                place = str(folder) if folder.is_dir() else ""
                id_ = change.path.rpartition("/")[2]
                size, message = change.bytes_copied, change.message
                output.made(id_, place, verdict=change.kind, bytes=size, path=change.path, message=message)
            if change.kind != "kept":
                output.detail(f"{change.kind} {name}")
    told = [f"{counts[kind]} {kind}" for kind in WORDS if counts[kind]] or ["no entries"]
    return f"{', '.join(told)}; {sent / 1e6:,.1f} MB"


def waiting(output: Output) -> Callable[[str], None]:
    """A function that prints, once, what is being waited for."""
    told: set[str] = set()

    def show(text: str) -> None:
        if text not in told:
            told.add(text)
            output.line(terminal_safe(text))

    return show


Sending = Callable[["Generator[Event]"], "Generator[Event]"]


@contextmanager
def on_store(url: str, library: Path, output: Output) -> Iterator[Sending]:
    """Keep the library of a run on a store: fetch it first, send entries as they are made, and all the rest at the end.

    Args:
        url: of the store; empty: the library stays on this disk. library: folder on this disk.
    Yields:
        what the events of the run are to be passed through.
    """
    if not url:
        yield lambda events: events
        return
    from casa_assets.library.library import Library
    from casa_assets.library.remote_folder import hold
    from casa_assets.runs.remote import RemoteLibrary, StoredRun

    remote = RemoteLibrary.open(url)
    with hold(remote, waiting(output)) as lock:
        run = StoredRun(Library(library), remote, lock)
        fetched = print_changes(run.fetch(), "fetching", output)
        output.detail(f"fetched of {remote.url}: {fetched}")
        yield run.sending
        sent = print_changes(run.finish(), "sending", output)
        output.line(f"Store:   {terminal_safe(remote.url)}: {sent} at the end")
