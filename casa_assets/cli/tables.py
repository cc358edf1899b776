"""Tables for terminals of any width and for pipes: no name is cut, and no column breaks letter by letter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

from casa_assets.projects import project_folder

FROM = "from"  # heading of the column of where things come from
GAP = 2  # columns of the terminal between two cells


@dataclass
class TextTable:
    """A table of plain text that takes the form for which there is room.

    Where the output is no terminal, each row is one line, as long as it has to be. In a terminal sentences are wrapped
    between words. Where a word, such as a path, is too long for that, the last column stands on a line of its own below
    the others; and where these do not fit either, each cell has its own line.

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
        self.rows.append(tuple(cell if isinstance(cell, Text) else Text(cell) for cell in cells))

    def add_from(self, *cells: str | Text) -> None:
        """Add a row whose last cell says where it comes from, which is told where a project is in use."""
        self.add(*cells[: len(self.columns)])

    def print(self, console: Console) -> None:
        """Print the table in the form for which there is room; nothing where it has no rows."""
        if not self.rows:
            return
        widths = [max(cell_len(name), *(cell_len(row[i].plain) for row in self.rows)) for i, name in self._numbered()]
        if self.title:
            console.print(Text(self.title, style="italic"), soft_wrap=True)
        if not console.is_terminal or _sum(widths) <= console.width:
            self._print_lines(console, widths, len(self.columns))
        elif _sum(self._least(widths)) <= console.width:
            self._print_wrapped(console, self._shared(widths, console.width))
        elif _sum(widths[:-1]) <= console.width:
            self._print_lines(console, widths, len(self.columns) - 1)
        else:
            self._print_cells(console)

    def _numbered(self) -> list[tuple[int, str]]:
        return list(enumerate(self.columns))

    def _least(self, widths: Sequence[int]) -> list[int]:
        """Width of each column below which it would be cut, or a word of it broken."""
        return [self._longest_word(i) if name in self.sentences else widths[i] for i, name in self._numbered()]

    def _longest_word(self, i: int) -> int:
        texts = [self.columns[i], *(row[i].plain for row in self.rows)]
        return max(cell_len(word) for text in texts for word in text.split() or [""])

    def _shared(self, widths: Sequence[int], width: int) -> list[int]:
        """Widths of the columns where those of sentences share the room that the others leave, the shortest first."""
        shares = self._least(widths)
        free = width - _sum(shares)
        wrapped = sorted((i for i, name in self._numbered() if name in self.sentences), key=lambda i: widths[i])
        for number, i in enumerate(wrapped):
            more = min(widths[i] - shares[i], free // (len(wrapped) - number))
            shares[i] += more
            free -= more
        return shares

    def _print_wrapped(self, console: Console, widths: Sequence[int]) -> None:
        """Print each row on as many lines as its sentences need."""
        for row in (self._heads(), None, *self.rows):
            if row is None:
                self._print_rule(console, _sum(widths))
                continue
            cells = [list(cell.wrap(console, width)) for cell, width in zip(row, widths, strict=True)]
            for number in range(max(map(len, cells))):
                line = [lines[number] if number < len(lines) else Text() for lines in cells]
                console.print(self._line(line, widths), soft_wrap=True, highlight=False)

    def _heads(self) -> tuple[Text, ...]:
        return tuple(Text(name, style="bold") for name in self.columns)

    def _print_rule(self, console: Console, width: int) -> None:
        console.print(Text(("\u2500" if console.encoding.startswith("utf") else "-") * width), soft_wrap=True)

    def _print_lines(self, console: Console, widths: Sequence[int], together: int) -> None:
        """Print each row on one line, and what is behind its first `together` cells on another."""
        for row in (self._heads(), None, *self.rows):
            if row is None:
                self._print_rule(console, _sum(widths[:together]))
                continue
            console.print(self._line(row[:together], widths), soft_wrap=True, highlight=False)
            for cell in row[together:]:
                console.print(Text.assemble("  ", cell), soft_wrap=True, highlight=False)

    def _line(self, cells: Sequence[Text], widths: Sequence[int]) -> Text:
        padded = []
        for i, cell in enumerate(cells):
            cell.rstrip()
            space = " " * (widths[i] - cell_len(cell.plain))
            padded.append(Text.assemble(space, cell) if self.columns[i] in self.right else Text.assemble(cell, space))
        line = Text(" " * GAP).join(padded)
        line.rstrip()
        return line

    def _print_cells(self, console: Console) -> None:
        for row in self.rows:
            console.print(row[0], soft_wrap=True, highlight=False)
            for name, cell in zip(self.columns[1:], row[1:], strict=True):
                if cell.plain:
                    console.print(Text.assemble(f"  {name}: ", cell), soft_wrap=True, highlight=False)


def from_column() -> tuple[str, ...]:
    """Heading of the last column of a list where a project is in use, so that not all comes from this package."""
    return () if project_folder() is None else (FROM,)


def _sum(widths: Sequence[int]) -> int:
    return sum(widths) + GAP * (len(widths) - 1)
