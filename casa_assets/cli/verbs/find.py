"""casa-assets find: assets of a library by words."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from casa_assets.cli.options import CLIP_HELP, AsJson, Library, Most, Quiet, Verbose, library_at, more
from casa_assets.cli.output import Output, measures_at
from casa_assets.cli.tables import TextTable
from casa_assets.cli.text import terminal_safe
from casa_assets.errors import CasaError

NO_WEIGHTS = (
    "pictures are compared with words by CLIP, which needs --clip-weights (a file, a folder or a name of open_clip's); "
    "--words compares categories, titles and colours alone"
)


def find(
    query: Annotated[str, typer.Argument(help='What you look for, such as "red mug".')],
    library: Library = Path("out/library"),
    clip_weights: Annotated[str, typer.Option(help=more(CLIP_HELP, "the words are compared with pictures."))] = "",
    words: Annotated[
        bool, typer.Option("--words", help="Compare with category, title and colours, without pictures.")
    ] = False,
    most: Most = 10,
    json_: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Search a library by words.

    Exit 0 where something fits, 1 where nothing does, 2 on misuse.

    Examples:

      casa-assets find "red mug" --clip-weights ~/ViT-B-32-laion2b.pt

      casa-assets find "red mug" --words
    """
    from casa_assets.pipeline.clip import load_clip
    from casa_assets.pipeline.dedup.search import search_by_picture, search_by_words

    if not query.strip():
        raise typer.BadParameter("there are no words to look for", param_hint="QUERY")
    place = library_at(library)
    if words:
        hits = search_by_words(query, place, most)
    elif clip_weights:
        hits = search_by_picture(query, place, load_clip(clip_weights), most)
    else:
        raise CasaError(NO_WEIGHTS)
    output = Output(json_, quiet, verbose)
    table = TextTable(("folder", "score", "why"), sentences=("why",), right=("score",))
    for hit in hits:
        row = {"id": hit.id, "category": hit.category, "folder": str(hit.folder), "score": hit.score}
        output.row({**row, **(measures_at(hit.folder) if json_ else {}), "verdict": "found", "reason": hit.reason})
        folder = hit.folder.relative_to(library).as_posix()
        table.add(terminal_safe(folder), f"{hit.score:.3f}", terminal_safe(hit.reason))
    if not hits:
        output.error("nothing fits")
        raise typer.Exit(1)
    if not json_:
        table.print(output.console)
        output.line(f"Folders are those under {terminal_safe(str(library))}/")
