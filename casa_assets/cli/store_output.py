"""Print what is copied between a library on this disk and one on a store, and run with a library on a store."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rich.markup import escape

from casa_assets.cli.output import Output
from casa_assets.cli.progress import bar
from casa_assets.cli.text import terminal_safe

if TYPE_CHECKING:
    from casa_assets.pipeline.ingest.job import Event
    from casa_assets.pipeline.library.remote import Change

WORDS = ("copied", "kept", "removed", "failed")


def print_changes(changes: Iterator[Change], word: str, output: Output, rows_in: Path | None = None) -> str:
    """Show a bar while entries are copied; returns how many were copied, kept and removed, in words.

    Args:
        word: what is done, such as `pushing`. rows_in: library whose entries are told as rows of --json; None: none.
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
                description=f"{word} {escape(name)}",
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
    """What tells the user, once, what is waited for."""
    told: set[str] = set()

    def tell(text: str) -> None:
        if text not in told:
            told.add(text)
            output.line(terminal_safe(text))

    return tell


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
    from casa_assets.pipeline.library.library import Library
    from casa_assets.pipeline.library.remote import RemoteLibrary, StoredRun
    from casa_assets.pipeline.library.remote_folder import hold

    remote = RemoteLibrary.open(url)
    with hold(remote.folder, waiting(output)) as lock:
        run = StoredRun(Library(library), remote, lock)
        fetched = print_changes(run.fetch(), "fetching", output)
        output.detail(f"fetched of {remote.url}: {fetched}")
        yield run.sending
        sent = print_changes(run.finish(), "sending", output)
        output.line(f"Store:   {terminal_safe(remote.url)}: {sent} at the end")
