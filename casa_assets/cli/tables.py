"""Tables for terminals of any width and for pipes: no name is cut, and no column breaks letter by letter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from rich.box import SIMPLE_HEAD, Box
from rich.cells import cell_len
from rich.console import Console
from rich.table import Table
from rich.text import Text

from casa_assets.projects import project_folder

FROM = "from"  # heading of the column of where things come from
GAP = 2  # columns of the terminal between two cells
ASCII_HEAD = Box("    \n    \n -- \n    \n    \n    \n    \n    \n", ascii=True)  # `SIMPLE_HEAD` where there is no UTF
HEAD_LINES = 2  # of a table: the headings and the rule below them


@dataclass
class TextTable:
    """A table that rich draws without ever cutting a cell.

    Where the output is no terminal, each row is one line, as long as it has to be. In a terminal sentences are wrapped
    between words. Where a word, such as a path, is too long for that, the last column stands on a line of its own below
    the others.

    Attributes:
        columns: their headings.
        sentences: headings of those that may be wrapped between words.
        right: headings of those that are aligned to the right.
        title: a line above; empty: none.
    """

    columns: Sequence[str]
    sentences: Sequence[str] = ()
    right: Sequence[str] = ()
    title: str = ""
    rows: list[tuple[Text, ...]] = field(default_factory=list)

    def add(self, *cells: str | Text) -> None:
        """Add a row, a cell for each column. A string may hold what a user typed: it is not read as markup."""
        self.rows.append(tuple(cell if isinstance(cell, Text) else Text(cell.replace("\n", " ")) for cell in cells))

    def add_from(self, *cells: str | Text) -> None:
        """Add a row whose last cell says where it comes from, which is told where a project is in use."""
        self.add(*cells[: len(self.columns)])

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
        """Widths where sentences share the room that the others leave, the shortest first.

        Without the last where a word would be broken.
        """
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
            justify = "right" if name in self.right else "left"
            table.add_column(Text(name), justify=justify, width=width, no_wrap=name not in self.sentences)
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
