"""casa-assets library: libraries as a whole."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from casa_assets.cli.ingest_output import end, print_events, print_summary
from casa_assets.cli.options import CLIP_HELP, AsJson, LibraryOut, Quiet, Verbose, more
from casa_assets.cli.output import Output
from casa_assets.cli.text import terminal_safe
from casa_assets.cli.verb import Verb

if TYPE_CHECKING:
    from collections.abc import Callable, Generator

    from casa_assets.pipeline.ingest.job import Event

app = typer.Typer(
    name="library",
    help="Libraries as a whole: merge the parts that several machines made.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)


@app.callback()
def common() -> None:
    """Libraries as a whole: merge the parts that several machines made."""


@app.command(cls=Verb)
def merge(
    shards: Annotated[
        list[Path],
        typer.Argument(help="Folders that `ingest --shard` wrote.", exists=True, file_okay=False, readable=True),
    ],
    library: LibraryOut = Path("out/library"),
    partial: Annotated[bool, typer.Option("--partial", help="Merge also where some shards are missing.")] = False,
    clip_weights: Annotated[str, typer.Option(help=more(CLIP_HELP, "compares pictures."))] = "",
    json_: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Merge the shards of `ingest --shard` into the library that one run over all inputs would have made.

    No input is read and nothing is built anew. Exit 0 when all inputs were accepted, 1 when some were rejected, 4 when
    none was rejected but a person has to decide about some, 2 on misuse, and where shards are missing or do not belong
    together.

    Example:

      casa-assets library merge shards/* --library out/library
    """
    from casa_assets.pipeline.ingest.shards.merge import merge as run

    output = Output(json_, quiet, verbose)

    def start(_: Callable[[str], None] | None) -> Generator[Event]:
        return run(shards, library, partial, clip_weights)

    events = print_events(start, output)
    if not events:
        output.line(f"no inputs in {', '.join(terminal_safe(str(shard)) for shard in shards)}")
        return
    if not json_:
        print_summary(events, library, output)
    output.look(*[event.folder for event in events if event.folder and not event.was_rejected][:1])
    end(events)
