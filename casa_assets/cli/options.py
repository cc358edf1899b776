"""Options that several verbs share, old spellings that they still take, and the library that a verb is to read."""

from __future__ import annotations

from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from casa_assets.errors import OutputError

if TYPE_CHECKING:
    from casa_assets.pipeline.library.library import Library

Force = Annotated[bool, typer.Option("--force", help="Also those that nothing has changed for.")]
# Spellings of version 0.1, to go with the next one.
OldForce = Annotated[bool, typer.Option("--anew", hidden=True)]
OldSizeM = Annotated[float, typer.Option("--size", min=0, hidden=True)]


def library_at(folder: Path) -> Library:
    """The library in a folder. Raises OutputError where nothing was ever made there, so that nothing is written."""
    from casa_assets.pipeline.library.library import Library

    place = Library(folder)
    if not place.private.is_dir() and next(chain(place.accepted(), place.refused()), None) is None:
        raise OutputError(str(folder), "is no library; give the folder that `casa-assets ingest` wrote")
    return place
