"""How commands print: results, rows of JSON, tables, progress bars; texts out of files are made safe for a terminal."""

from __future__ import annotations

import json
import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

import typer
from rich.box import SIMPLE_HEAD, Box
from rich.cells import cell_len
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.progress import TimeRemainingColumn as TimeLeftColumn
from rich.table import Column, Table
from rich.text import Text

from casa_assets.projects import project_folder

if TYPE_CHECKING:
    from casa_assets.library.entry_files import Summary
    from casa_assets.model.issue import Issue

# Layer of scene.json whose parts are walls, floor and ceiling; their mass says nothing of the things in a kitchen.
ROOM_LAYER = "room"
FROM = "from"  # heading of the column of where things come from
GAP = 2  # columns of the terminal between two cells
ASCII_HEAD = Box("    \n    \n -- \n    \n    \n    \n    \n    \n", ascii=True)  # `SIMPLE_HEAD` where there is no UTF
HEAD_LINES = 2  # of a table: the headings and the rule below them


def terminal_safe(text: str) -> str:
    """The text on one line, without what a terminal would act on: such characters become backslash escapes."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def safe(words: str) -> str:
    """Words of strangers on one line, fit for a line with markup."""
    return escape(terminal_safe(words))


def safe_message(message: str, path: str) -> str:
    """A message about a file, line by line fit for markup, without the name of the file at its beginning."""
    short = message.removeprefix(f"{path}: ").removeprefix(f"{PurePath(path).name}: ")
    return "\n".join(safe(line) for line in short.split("\n"))


def issue_rows(issues: Iterable[Issue]) -> list[dict[str, str]]:
    """Issues as rows of `--json` have them."""
    return [{"code": i.code, "pointer": i.pointer, "message": i.message} for i in issues]


def pluralize(number: int, thing: str) -> str:
    """`1 input`, `2 inputs`, `3 categories`, `0 boxes`."""
    if number == 1:
        return f"1 {thing}"
    if thing.endswith("y"):
        return f"{number} {thing[:-1]}ies"
    return f"{number} {thing}{'es' if thing.endswith(('s', 'x', 'ch', 'sh')) else 's'}"


class Output:
    """Prints the output of a verb.

    Attributes:
        as_json: one JSON object per item goes to standard output, and all other words to standard error.
        quiet: nothing but errors, what failed, and JSON is printed. verbose: what went well too, item by item.
        console: for messages; prints nothing if the verb is to be quiet.
        failures: for what is wrong with items that failed; standard error if the verb is to be quiet.
    """

    def __init__(self, as_json: bool = False, quiet: bool = False, verbose: bool = False) -> None:
        self.as_json, self.quiet, self.verbose = as_json, quiet, verbose
        self.console = Console(stderr=as_json, quiet=quiet)
        self._errors = Console(stderr=True)
        self.failures = self._errors if quiet else self.console

    def row(self, values: Mapping[str, Any]) -> None:
        """Print an item as a line of JSON, if JSON is asked for."""
        if self.as_json:
            typer.echo(json.dumps(values, sort_keys=True))

    def made(
        self,
        name: str,
        folder: str | Path,
        measured: Mapping[str, Any] | None = None,
        verdict: str = "made",
        **more: Any,
    ) -> None:
        """Print what was made as a line of JSON, if asked for; `measured`: its `mass` and `size`, else null."""
        self.row({"id": name, "folder": str(folder), "verdict": verdict, **(measured or measures(None)), **more})

    def line(self, text: str) -> None:
        """Print a line of plain text, such as a path, without markup or wrapping."""
        self.console.print(text, markup=False, highlight=False, soft_wrap=True)

    def styled(self, text: str, is_wrong: bool = False) -> None:
        """Print a line with markup; `is_wrong`: it is about what failed."""
        (self.failures if is_wrong else self.console).print(text, highlight=False, soft_wrap=True)

    def detail(self, text: str) -> None:
        """Print a line of plain text where the user asked for more words."""
        if self.verbose:
            self.line(text)

    def wrong(self, text: str) -> None:
        """Print a line of plain text about what failed."""
        self.failures.print(text, markup=False, highlight=False, soft_wrap=True)

    def look(self, *words: str | Path) -> None:
        """Print the `casa-assets view` that shows what was made, the last line, on standard error for people alone."""
        if words and not self.as_json and not self.quiet:
            self.error(f"Look at it: casa-assets view {shlex.join(terminal_safe(str(word)) for word in words)}")

    def next_command(self, *words: object) -> None:
        """Print a command that goes on from here, with its words quoted as a shell wants them."""
        self.line(f"Next:    casa-assets {shlex.join(terminal_safe(str(word)) for word in words)}")

    def look_at_file(self, path: Path) -> None:
        """Print the address of a page or picture, which terminals and browsers open, as `look` prints its line."""
        if not self.as_json and not self.quiet:
            self.error(f"Look at it: {path.resolve().as_uri()}")

    def error(self, text: str) -> None:
        """Print a line of plain text on standard error: why there is no result."""
        self._errors.print(text, markup=False, highlight=False, soft_wrap=True)


def measures(summary: Summary | None) -> dict[str, Any]:
    """Mass in kg and size in metres, x, y and z, of an item of `--json`; null if there is no asset."""
    if summary is None:
        return {"mass": None, "size": None}
    return {"mass": summary.mass, "size": list(summary.extents)}


def measures_at(folder: str | Path | None) -> dict[str, Any]:
    """The same of an asset of a library, or of all in a kitchen and its room; null without one."""
    from casa_assets.library.entry_files import find_summary
    from casa_assets.model.kitchen.files import SCENE_JSON

    if not folder:
        return measures(None)
    path = Path(folder) / SCENE_JSON
    return _measures_of_scene(path) if path.is_file() else measures(find_summary(Path(folder)))


def _measures_of_scene(path: Path) -> dict[str, Any]:
    facts = json.loads(path.read_text(encoding="utf-8"))
    things = [*facts["fixtures"], *facts.get("objects", [])]
    low, high = facts["room"]["bounds"]
    return {
        "mass": round(sum(thing["mass_kg"] for thing in things if thing.get("layer") != ROOM_LAYER), 3),
        "size": [round(b - a, 4) for a, b in zip(low, high, strict=True)],
    }


@dataclass
class TextTable:
    """A table that rich draws without ever cutting a cell.

    If the output is not a terminal, each row is one line, as long as it has to be. In a terminal, sentences are wrapped
    between words. If a word, such as a path, is too long for that, the last column goes on a separate line below.

    Attributes:
        columns: headings. sentences: of those that may be wrapped. right: of those that are aligned to the right.
    """

    columns: Sequence[str]
    sentences: Sequence[str] = ()
    right: Sequence[str] = ()
    title: str = ""
    rows: list[tuple[Text, ...]] = field(default_factory=list)

    def add(self, *cells: str | Text) -> None:
        """Add a row; cells beyond the columns, as for `from_column`, are left out, and strings are no markup."""
        texts = (cell if isinstance(cell, Text) else Text(cell.replace("\n", " ")) for cell in cells)
        self.rows.append(tuple(texts)[: len(self.columns)])

    def print(self, console: Console) -> None:
        """Print the table; nothing where it has no rows."""
        if not self.rows:
            return
        if self.title:
            console.print(Text(self.title, style="italic"), soft_wrap=True)
        widths = [self._width(i, whole=True) for i in range(len(self.columns))]
        if console.is_terminal and _sum(widths) > console.width:
            widths = self._narrowed(widths, console.width)
        if console.is_terminal and _sum(widths) > console.width:
            self._print_cells(console)
            return
        for number, line in enumerate(self._lines(console, widths), -HEAD_LINES):
            line.rstrip()
            console.print(line, soft_wrap=True, highlight=False)
            if len(widths) < len(self.columns) and number != -1:  # nothing is wrapped then: each row has one line
                last = self.rows[number][-1] if number >= 0 else Text(self.columns[-1], style="bold")
                console.print(Text.assemble("  ", last), soft_wrap=True, highlight=False)

    def _print_cells(self, console: Console) -> None:
        for row in self.rows:
            console.print(row[0], soft_wrap=True, highlight=False)
            for name, cell in zip(self.columns[1:], row[1:], strict=True):
                if cell.plain:
                    console.print(Text.assemble(f"  {name}: ", cell), soft_wrap=True, highlight=False)

    def _width(self, i: int, whole: bool) -> int:
        """Width of the longest cell of a column; of its longest word where it may be wrapped, unless it is `whole`."""
        texts = [self.columns[i], *(row[i].plain for row in self.rows)]
        if self.columns[i] in self.sentences and not whole:
            texts = [word for text in texts for word in text.split()]
        return max(map(cell_len, texts), default=0)

    def _narrowed(self, widths: list[int], room: int) -> list[int]:
        """Widths where sentences share the room that others leave; without the last where a word would be broken."""
        shares = [self._width(i, whole=False) for i in range(len(self.columns))]
        free = room - _sum(shares)
        if free < 0:
            return widths[:-1]
        wrapped = sorted((i for i in range(len(widths)) if widths[i] > shares[i]), key=lambda i: widths[i])
        for number, i in enumerate(wrapped):
            more = min(widths[i] - shares[i], free // (len(wrapped) - number))
            shares[i] += more
            free -= more
        return shares

    def _lines(self, console: Console, widths: Sequence[int]) -> list[Text]:
        """The lines of the first columns, which have these widths, without spaces at their ends."""
        box = SIMPLE_HEAD if console.encoding.startswith("utf") else ASCII_HEAD
        table = Table(box=box, show_edge=False, pad_edge=False, padding=(0, GAP - 1, 0, 0), header_style="bold")
        for name, width in zip(self.columns, widths, strict=False):
            table.add_column(
                Text(name),
                justify="right" if name in self.right else "left",
                width=width,
                no_wrap=name not in self.sentences,
            )
        for row in self.rows:
            table.add_row(*row[: len(widths)])
        options = console.options.update(width=_sum(widths))
        return [
            Text.assemble(*((segment.text, segment.style or "") for segment in line))
            for line in console.render_lines(table, options, pad=False)
        ]


def from_column() -> tuple[str, ...]:
    """Heading of the last column of a list where a project is in use, so that not all comes from this package."""
    return () if project_folder() is None else (FROM,)


def _sum(widths: Sequence[int]) -> int:
    return sum(widths) + GAP * (len(widths) - 1)


def bar(console: Console) -> Progress:
    """A progress bar with a text, count, time and time left, removed at the end; without a terminal it is not shown."""
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
    """Show a bar while things are worked on; yields what is called with the name of each that is done.

    Another name is shown and not counted. `word`: what is done with them, such as `building`.
    """
    open_names = dict.fromkeys(names)
    with bar(console) as progress:
        task = progress.add_task(f"{word} {safe(next(iter(names), ''))}".rstrip(), total=len(names))

        def done(name: str) -> None:
            is_one = name in open_names
            open_names.pop(name, None)
            shown = safe(next(iter(open_names), name))
            progress.update(task, advance=float(is_one), description=f"{word} {shown}".rstrip())

        yield done
