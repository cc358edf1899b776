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
    from casa_assets.pipeline.tables.row import RowNumbers

# Layer of scene.json whose parts are walls, floor and ceiling; their mass says nothing of what stands in a kitchen.
ROOM_LAYER = "room"


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

    def made(
        self,
        name: str,
        folder: str | Path,
        measured: Mapping[str, Any] | None = None,
        verdict: str = "made",
        **more: Any,
    ) -> None:
        """Print a thing that was made as a line of JSON, if JSON is asked for.

        Args:
            name: id of the thing, or what a page or picture shows. folder: that it is in.
            measured: `mass` and `size`, see `measures`; null where there are none.
            more: what the verb has to say besides.
        """
        self.row({"id": name, "folder": str(folder), "verdict": verdict, **(measured or measures(None)), **more})

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

    def next_command(self, *words: object) -> None:
        """Print a command that goes on from here, with its words quoted as a shell wants them."""
        self.line(f"Next:    casa-assets {shlex.join(terminal_safe(str(word)) for word in words)}")

    def look_at_file(self, path: Path) -> None:
        """Print where a page or picture opens: the last line of a verb, as `look` prints it.

        Args:
            path: of the file; it is printed as an address that terminals and browsers open.
        """
        if not self.as_json and not self.quiet:
            self.error(f"Look at it: {path.resolve().as_uri()}")

    def error(self, text: str) -> None:
        """Print a line of plain text on standard error: why there is no result."""
        self.errors.print(text, markup=False, highlight=False, soft_wrap=True)


def measures(summary: Summary | RowNumbers | None) -> dict[str, Any]:
    """Mass in kg and size in metres, x, y and z, of an item of `--json`; null where there is no asset."""
    if summary is None:
        return {"mass": None, "size": None}
    return {"mass": summary.mass, "size": list(summary.extents)}


def measures_at(folder: str | Path | None) -> dict[str, Any]:
    """The same of the asset or kitchen in a folder; null where none is named, or no library has taken the asset.

    The mass of a kitchen is that of all that stands in the room, its size that of the room.
    """
    from casa_assets.pipeline.kitchens.scene_files import SCENE_JSON
    from casa_assets.pipeline.library.library import find_summary

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
