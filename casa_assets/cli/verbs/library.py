"""casa-assets library, find, report: libraries as a whole, what is in them, and pages about them."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape

from casa_assets.cli.batch_output import end_inputs, look, print_events, print_summary
from casa_assets.cli.group import Verb, group_of
from casa_assets.cli.options import (
    CLIP_HELP,
    IN_3D_HELP,
    OUT_HELP,
    Force,
    Library,
    LibraryOut,
    Most,
    Out,
    library_at,
    more,
    shared,
)
from casa_assets.cli.output import Output, TextTable, bar, measures, measures_at, pluralize, safe, terminal_safe

if TYPE_CHECKING:
    from casa_assets.library.library import Library as LibraryFolder
    from casa_assets.library.search import Found, SearchHit
    from casa_assets.runs.outcome import Event
    from casa_assets.runs.remote import Change
    from casa_assets.show.reports.gate import Condition
    from casa_assets.show.reports.library_page import WrittenReport

app = group_of(
    "library", "Libraries as a whole: merge the parts that several machines made, index many, keep them on stores."
)

WORDS = ("copied", "kept", "removed", "failed")  # what becomes of entries that are copied
PARTIAL_HELP = "Go on where parts are missing."
Url = Annotated[str, typer.Argument(metavar="URL", help="Library on a store, such as s3://bucket/library.")]
Sending = Callable[["Generator[Event]"], "Generator[Event]"]
Delete = Annotated[bool, typer.Option("--delete", help="Remove what the other side lacks; decisions of people too.")]
Junit = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Write JUnit XML too: a test case for each input and condition.")
]
Page = Annotated[Path | None, typer.Option(help=more(OUT_HELP, "report.html in the library by default."))]
Baseline = Annotated[
    Path | None, typer.Option(help="Earlier report.json or library; lists what is better, worse, new or gone.")
]
Sarif = Annotated[Path | None, typer.Option(metavar="FILE", help="Write SARIF 2.1.0 too, which code scanning shows.")]


@app.command(cls=Verb)
@shared
def merge(
    output: Output,
    shards: Annotated[
        list[Path],
        typer.Argument(help="Folders that `ingest --shard` wrote.", exists=True, file_okay=False, readable=True),
    ],
    library: LibraryOut = Path("out/library"),
    partial: Annotated[
        bool, typer.Option("--partial", help=more(PARTIAL_HELP, "merge the shards that there are."))
    ] = False,
    clip_weights: Annotated[str, typer.Option(help=more(CLIP_HELP, "compares pictures."))] = "",
) -> None:
    """Merge the shards of `ingest --shard` into the library that one run over all inputs would have made.

    No input is read and nothing is built again. Exit 0 when all inputs were accepted, 1 when some were rejected, 4 when
    none was rejected but a person has to decide about some, 2 on misuse, and where shards are missing or do not belong
    together.

    Example:

      casa-assets library merge shards/* --library out/library
    """
    from casa_assets.ingest.run.merge import merge as run

    events = print_events(lambda _: run(shards, library, partial, clip_weights), output)
    if not events:
        output.line(f"no inputs in {', '.join(terminal_safe(str(shard)) for shard in shards)}")
        return
    if not output.as_json:
        print_summary(events, library, output)
    look(events, output)
    end_inputs(events, [event.path for event in events])


@app.command(cls=Verb)
@shared
def push(
    output: Output,
    library: Annotated[Path, typer.Argument(help="Folder of the library.", exists=True, file_okay=False)],
    url: Url,
    delete: Delete = False,
) -> None:
    """Copy a library to an object store, entry by entry, so that it is the same there.

    Entries that are there already are left as they are. Stopped at any moment and run again, it goes on. Exit 0 when
    all of it is there, 2 on misuse, where the store cannot be used, and where it has what the library lacks.

    Example:

      casa-assets library push out/library s3://bucket/library
    """
    from casa_assets.library.remote_folder import hold
    from casa_assets.runs.remote import Extra, RemoteLibrary
    from casa_assets.runs.remote import push as run

    place = library_at(library)
    remote = RemoteLibrary.open(url)
    with place.locked(), hold(remote, waiting(output)) as lock:
        changes = run(place, remote, lock, Extra.REMOVE if delete else Extra.REFUSE)
        counts = print_changes(changes, "pushing", output, library)
    output.line(f"Store: {terminal_safe(remote.url)}: {counts}")


@app.command(cls=Verb)
@shared
def pull(
    output: Output,
    url: Url,
    library: Annotated[Path, typer.Argument(help="Folder of the library.", file_okay=False)],
    delete: Delete = False,
    partial: Annotated[
        bool, typer.Option("--partial", help=more(PARTIAL_HELP, "take what a run that has not ended has written."))
    ] = False,
) -> None:
    """Copy a library from an object store to this disk, so that it is the same here.

    Entries that are here already are left as they are. Stopped at any moment and run again, it goes on. Exit 0 when
    all of it is here, 2 on misuse, where the store cannot be used, and where the library has what the store lacks.

    Example:

      casa-assets library pull s3://bucket/library out/library
    """
    from casa_assets.library.library import Library
    from casa_assets.runs.remote import Extra, RemoteLibrary
    from casa_assets.runs.remote import pull as run

    place = Library(library)
    remote = RemoteLibrary.open(url)
    with place.locked():
        place.sweep()
        changes = run(remote, place, Extra.REMOVE if delete else Extra.REFUSE, partial)
        counts = print_changes(changes, "pulling", output, library)
    output.line(f"Library: {terminal_safe(str(library))}: {counts}")


def print_changes(changes: Iterator[Change], word: str, output: Output, rows_in: Path | None = None) -> str:
    """Show a bar while entries are copied; returns how many were copied, kept and removed, in words.

    `rows_in`: library whose entries are printed as rows of --json.
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
    words = [f"{counts[kind]} {kind}" for kind in WORDS if counts[kind]] or ["no entries"]
    return f"{', '.join(words)}; {sent / 1e6:,.1f} MB"


def waiting(output: Output) -> Callable[[str], None]:
    """A function that prints, once, what is being waited for."""
    printed: set[str] = set()

    def show(text: str) -> None:
        if text not in printed:
            printed.add(text)
            output.line(terminal_safe(text))

    return show


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


@app.command(cls=Verb)
@shared
def index(
    output: Output,
    libraries: Annotated[
        list[Path],
        typer.Argument(help="Folders of libraries, also of shards.", exists=True, file_okay=False, readable=True),
    ],
    out: Out = Path("out/tables"),
    force: Force = False,
) -> None:
    """Write one table of the entries of any number of libraries, as Parquet parts, for programs that read Parquet.

    The parts of a library in which no entry came, went or was replaced are kept; --force writes all again. Name all
    libraries each time: parts of others go. Exit 0 when all is written, 2 on misuse.

    Example:

      casa-assets library index shards/* --out out/tables
    """
    from casa_assets.library.parquet import require_parquet, write_index

    require_parquet()
    written = write_index([library_at(library) for library in libraries], out, force)
    for one in written.index.libraries:
        kept = one.library in written.kept
        output.made(one.library, out, verdict="kept" if kept else "made", rows=one.rows, parts=len(one.parts))
        output.detail(f"{terminal_safe(one.library)}: {pluralize(one.rows, 'row')}, {'kept' if kept else 'written'}")
    count = pluralize(len(written.index.libraries), "library")
    output.line(f"{pluralize(written.index.rows, 'row')} of {count} in {out}")


@shared
def find(
    output: Output,
    query: Annotated[
        str, typer.Argument(help='What you look for, such as "red mug"; may be left out beside --where.')
    ] = "",
    library: Library = Path("out/library"),
    where: Annotated[
        list[str] | None,
        typer.Option(help="What must hold, such as category=mug, 'size<=0.3' or reason=FLT005; may be repeated."),
    ] = None,
    clip_weights: Annotated[str, typer.Option(help=more(CLIP_HELP, "the words are compared with pictures."))] = "",
    most: Most = 10,
) -> None:
    """Search a library by words, by conditions or by both.

    Words are looked for in categories, titles and colours; with --clip-weights they are compared with the pictures.

    A condition is a field, an operator and a value. Words: category, verdict, reason, decide, source, licence, author,
    split, producer, id, with = or !=; values after commas are alternatives. Numbers: size (longest side, m), mass (kg),
    faces, colliders, warnings, with =, !=, <, <=, > or >=. Rejected inputs are searched where a condition names a
    verdict, a reason or an id. Without words rows come in the order of their ids.

    Exit 0 where something fits, 1 where nothing does, 2 on misuse.

    Examples:

      casa-assets find "red mug"
      casa-assets find "red mug" --clip-weights ~/ViT-B-32-laion2b.pt
      casa-assets find --where category=mug,cup --where 'size<=0.12' --json
      casa-assets find --where reason=FLT005 --most 100
    """
    from casa_assets.library import search

    conditions = [search.parse_condition(text) for text in where or ()]
    has_words = bool(query.strip())
    if not has_words and (clip_weights or not conditions):
        raise typer.BadParameter("there are no words to look for", param_hint="QUERY")
    if clip_weights and conditions:
        raise typer.BadParameter("searches without pictures; leave --clip-weights out", param_hint="--where")
    if clip_weights:
        from casa_assets.library.clip import load_clip

        hits = search.search_by_picture(query, library_at(library), load_clip(clip_weights), most)
        found = search.Found(hits, len(hits))
    else:
        fitting = search.entries_that(library_at(library), search.with_default(conditions))
        found = search.search_entries(fitting, library, query, most)
    if not found.hits:
        output.error(f"no match{_unnamed(library) if has_words else ''}")
        raise typer.Exit(1)
    _print_found(found, library, has_words, output)


def _unnamed(library: Path) -> str:
    """How many assets words cannot find because nobody knows their category; empty for none."""
    from casa_assets.library.search import entries_that, parse_condition

    count = sum(1 for _ in entries_that(library_at(library), [parse_condition("decide=category")]))
    return f"; {pluralize(count, 'asset')} in review without a category: casa-assets review {library}" if count else ""


def _print_found(found: Found, root: Path, has_words: bool, output: Output) -> None:
    """Print what was found; how well it fits where words were looked for, and else its category."""
    heads = ("folder", "score", "why") if has_words else ("folder", "category")
    table = TextTable(heads, sentences=("why",), right=("score",))
    for hit in found.hits:
        row = {"id": hit.id, "category": hit.category, "folder": str(hit.folder), "score": hit.score}
        output.row({**row, **(_facts(hit) if output.as_json else {}), "verdict": "found", "reason": hit.reason})
        folder = hit.folder.relative_to(root).as_posix()
        facts = (f"{hit.score:.3f}", hit.reason) if has_words else (hit.category,)
        table.add(terminal_safe(folder), *map(terminal_safe, facts))
    if not output.as_json:
        table.print(output.console)
        output.line(f"Folders are those under {terminal_safe(str(root))}/")
        if found.count > len(found.hits):
            output.line(f"{pluralize(found.count, 'entry')} fit; --most shows more of them")


def _facts(hit: SearchHit) -> dict[str, Any]:
    """Mass and size of what was found and, where its entry was read, what became of it."""
    if (entry := hit.entry) is None:
        return measures_at(hit.folder)
    known = {"status": entry.decision.value, "code": entry.code, "title": entry.title}
    return {**measures(entry.summary), **known, "source": entry.source, "source_path": entry.source_path}


@shared
def report(
    output: Output,
    library: Library = Path("out/library"),
    out: Page = None,
    baseline: Baseline = None,
    fail_on: Annotated[
        list[str] | None,
        typer.Option(help="Exit 1 if this holds: 'rejected-rate>5%', 'worse', 'FLT005', ...; may be repeated."),
    ] = None,
    junit: Junit = None,
    sarif: Sarif = None,
    clip_weights: Annotated[str, typer.Option(help=more(CLIP_HELP, "compares pictures first."))] = "",
    in_3d: Annotated[
        bool, typer.Option("--3d/--no-3d", help=more(IN_3D_HELP, "about 0.1 MB each, written once."))
    ] = False,
) -> None:
    """Write a page about a library, report.html, with every input in it, and report.json beside it.

    Counts by category, source and reason; sizes and masses against the usual ones. Up to 400 inputs the page holds
    pictures and all checks; of more it shows the pictures in the library and what did not pass, and it lists the 5,000
    that should be looked at first.

    --fail-on takes a count (entries, accepted, review, rejected, advice, not-run, size-outliers, mass-outliers, and
    with --baseline better, worse, appeared, gone), a share of it (rejected-rate), or the code of a check, alone or
    followed by >, >=, < or <= and a number. --json prints report.json, with a verdict. Exit 0 when the page is written,
    1 where a condition holds, 2 on misuse.

    Example:  casa-assets report --fail-on 'rejected-rate>5%' --fail-on 'review>0'
    """
    from casa_assets.runs.outcome import writing
    from casa_assets.show.reports.gate import parse
    from casa_assets.show.reports.library_page import write

    if out is not None and out.suffix.lower() != ".html":
        raise typer.BadParameter(f"{out} is no page: name a file that ends in .html", param_hint="--out")
    conditions: list[Condition] = []
    if fail_on:
        from casa_assets.show.reports.checks_page import every_code  # here, since it loads all checks

        known = every_code()
        conditions = [parse(text, known) for text in fail_on]
    if baseline is None and any(one.needs_baseline for one in conditions):
        raise typer.BadParameter("compares with an earlier run; give one with --baseline", param_hint="--fail-on")
    target = out or library / "report.html"
    _compare_all(library_at(library), clip_weights)
    with writing(target.parent):
        models = None
        if in_3d:
            from casa_assets.show.page.page_template import models_of, write_models

            with bar(output.console) as progress:
                task = progress.add_task("models", total=None)
                for done, total in write_models(library, target):
                    progress.update(task, total=total, completed=done)
            models = models_of(target)
        written = write(library, target, baseline, conditions, models, junit, sarif)
    _print_written(written, library, output)


def _print_written(written: WrittenReport, library: Path, output: Output) -> None:
    """Print what became of the conditions, and where the report is. Raises typer.Exit where a condition holds."""
    if output.as_json:
        content = json.loads(written.json.read_text(encoding="utf-8"))
        verdict = "failed" if any(outcome.holds for outcome in written.outcomes) else "passed"
        output.made(library.resolve().name, written.page.parent, verdict=verdict, page=str(written.page), **content)
    for outcome in written.outcomes:
        console = output.failures if outcome.holds else output.console
        mark = f"[{'red' if outcome.holds else 'green'}]{outcome.mark}[/]"
        console.print(f"{mark} {escape(str(outcome))}", highlight=False, soft_wrap=True)
    output.line(f"JSON:   {written.json}")
    output.line(f"Report: {written.page}")
    output.look_at_file(written.page)
    if any(outcome.holds for outcome in written.outcomes):
        raise typer.Exit(1)


def _compare_all(library: LibraryFolder, clip_weights: str) -> None:
    """Run the checks of all assets together, where they never ran, or where CLIP is to look at the pictures first."""
    from casa_assets.library import library_report
    from casa_assets.library.clip import load_clip
    from casa_assets.library.entry_table import EntryTable
    from casa_assets.runs.outcome import writing

    if clip_weights or library_report.read_library_report(library.root) is None:
        model = load_clip(clip_weights) if clip_weights else None
        with library.locked(), writing(library.root):
            library_report.compare_library(library, EntryTable(library), model)
