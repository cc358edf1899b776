"""The bar that verbs show while they work through many things: what is worked on, how many are done, time left."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.progress import TimeRemainingColumn as TimeLeftColumn
from rich.table import Column

from casa_assets.cli.text import terminal_safe


def bar(console: Console) -> Progress:
    """A progress bar with count, time and time left, removed at the end; nothing where the output is no terminal.

    Its text, which says what is worked on, is cut where the line is too short.
    """
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}", table_column=Column(no_wrap=True, overflow="ellipsis", ratio=1)),
        BarColumn(bar_width=12),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("ETA"),
        TimeLeftColumn(compact=True),
    )
    disabled = not console.is_interactive or console.quiet
    return Progress(*columns, console=console, transient=True, expand=True, disable=disabled)


@contextmanager
def working_on(console: Console, word: str, names: Sequence[str]) -> Iterator[Callable[[str], None]]:
    """Show a bar while things are worked on in their order; yields what is called with the name of each that is done.

    Another name is shown and not counted.

    Args:
        word: what is done with them, such as `building`. names: of the things, each once.
    """
    open_names = dict.fromkeys(names)
    with bar(console) as progress:
        task = progress.add_task(_text(word, open_names), total=len(names))

        def done(name: str) -> None:
            is_one = name in open_names
            open_names.pop(name, None)
            progress.update(task, advance=float(is_one), description=_text(word, open_names or {name: None}))

        yield done


def _text(word: str, open_names: dict[str, None]) -> str:
    """The word and the first name that is not done yet."""
    return f"{word} {escape(terminal_safe(next(iter(open_names), '')))}".rstrip()
