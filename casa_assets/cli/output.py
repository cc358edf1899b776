"""Where the words of a verb go: results to standard output, and JSON alone there if it is asked for."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.console import Console

from casa_assets.cli.text import terminal_safe

if TYPE_CHECKING:
    from casa_assets.pipeline.library.library import Summary


class Output:
    """What a verb prints through.

    Attributes:
        as_json: one JSON object per item goes to standard output, and all other words to standard error.
        quiet: nothing but errors, what failed, and JSON is printed.
        verbose: also what went well is printed, item by item.
        console: for what is told on the way and at the end; prints nothing where the verb is to be quiet.
        failures: for items that failed and what is wrong with them; standard error where the verb is to be quiet.
        errors: for why there is no result at all; always standard error.
    """

    def __init__(self, as_json: bool = False, quiet: bool = False, verbose: bool = False) -> None:
        self.as_json, self.quiet, self.verbose = as_json, quiet, verbose
        self.console = Console(stderr=as_json, quiet=quiet)
        self.errors = Console(stderr=True)
        self.failures = self.errors if quiet else self.console

    def row(self, values: Mapping[str, Any]) -> None:
        """Print an item as a line of JSON, if JSON is asked for."""
        if self.as_json:
            typer.echo(json.dumps(values, sort_keys=True))

    def line(self, text: str) -> None:
        """Print a line of plain text, such as a path, without markup or wrapping."""
        self.console.print(text, markup=False, highlight=False, soft_wrap=True)

    def detail(self, text: str) -> None:
        """Print a line of plain text where the user asked for more words."""
        if self.verbose:
            self.line(text)

    def wrong(self, text: str) -> None:
        """Print a line of plain text about what failed."""
        self.failures.print(text, markup=False, highlight=False, soft_wrap=True)

    def look(self, *words: str | Path) -> None:
        """Print the command that shows what was made, the last line of a verb, on standard error for people alone.

        Args:
            words: what `casa-assets view` takes; nothing is printed where there are none, or JSON is asked for.
        """
        if words and not self.as_json and not self.quiet:
            self.error(f"Look at it: casa-assets view {shlex.join(terminal_safe(str(word)) for word in words)}")

    def error(self, text: str) -> None:
        """Print a line of plain text on standard error: why there is no result."""
        self.errors.print(text, markup=False, highlight=False, soft_wrap=True)


def measures(summary: Summary | None) -> dict[str, Any]:
    """Mass in kg and size in metres, x, y and z, of an item of `--json`; null where there is no asset."""
    if summary is None:
        return {"mass": None, "size": None}
    return {"mass": summary.mass, "size": list(summary.extents)}


def measures_at(folder: str | Path | None) -> dict[str, Any]:
    """The same of the asset in a folder of a library; null where none is named."""
    from casa_assets.pipeline.library.library import read_certificate

    return measures(read_certificate(Path(folder)).summary if folder else None)
