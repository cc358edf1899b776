"""casa-assets library: libraries as a whole."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from casa_assets.cli.group import Verb, group_of
from casa_assets.cli.ingest_output import end, look, print_changes, print_events, print_summary, waiting
from casa_assets.cli.options import CLIP_HELP, Force, LibraryOut, Out, library_at, more, shared
from casa_assets.cli.output import Output, pluralize, terminal_safe

if TYPE_CHECKING:
    from collections.abc import Callable, Generator

    from casa_assets.runs.outcome import Event

app = group_of(
    "library", "Libraries as a whole: merge the parts that several machines made, index many, keep them on stores."
)


PARTIAL_HELP = "Go on where parts are missing."
Url = Annotated[str, typer.Argument(metavar="URL", help="Library on a store, such as s3://bucket/library.")]
Delete = Annotated[bool, typer.Option("--delete", help="Remove what the other side lacks; decisions of people too.")]


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

    def start(_: Callable[[str], None] | None) -> Generator[Event]:
        return run(shards, library, partial, clip_weights)

    events = print_events(start, output)
    if not events:
        output.line(f"no inputs in {', '.join(terminal_safe(str(shard)) for shard in shards)}")
        return
    if not output.as_json:
        print_summary(events, library, output)
    look(events, output)
    end(events, [event.path for event in events])


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
        told = print_changes(changes, "pushing", output, library)
    output.line(f"Store: {terminal_safe(remote.url)}: {told}")


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
        told = print_changes(changes, "pulling", output, library)
    output.line(f"Library: {terminal_safe(str(library))}: {told}")


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
