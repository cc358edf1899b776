"""casa-assets find: assets of a library by words."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from casa_assets.cli.options import library_at
from casa_assets.cli.text import terminal_safe
from casa_assets.errors import CasaError

if TYPE_CHECKING:
    from casa_assets.pipeline.dedup.search import SearchHit

NO_WEIGHTS = (
    "pictures are compared with words by CLIP, which needs --clip-weights (a file, a folder or a name of open_clip's); "
    "--words compares categories, titles and colours alone"
)


def find(
    query: Annotated[str, typer.Argument(help='Words for what is looked for, such as "red mug".')],
    library: Annotated[Path, typer.Option(help="The library.", exists=True, file_okay=False)] = Path("out/library"),
    clip_weights: Annotated[
        str, typer.Option(help="Weights of CLIP: a file, a folder, or a name such as ViT-B-32/laion2b_s34b_b79k.")
    ] = "",
    words: Annotated[bool, typer.Option("--words", help="Without pictures: by category, title and colours.")] = False,
    most: Annotated[int, typer.Option(min=1, help="How many at most.")] = 10,
    json_: Annotated[bool, typer.Option("--json", help="One JSON object per asset on standard output.")] = False,
) -> None:
    """Search a library by words; exit 0 where something fits, 1 where nothing does, 2 on misuse.

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
    if json_:
        for hit in hits:
            row = {"id": hit.id, "category": hit.category, "folder": str(hit.folder), "score": hit.score}
            typer.echo(json.dumps({**row, "reason": hit.reason}, sort_keys=True))
    elif hits:
        console = Console()
        console.print(_table(hits, library))
        console.print(
            f"Folders are those under {escape(terminal_safe(str(library)))}/", highlight=False, soft_wrap=True
        )
    else:
        Console().print("nothing fits")
    if not hits:
        raise typer.Exit(1)


def _table(hits: list[SearchHit], library: Path) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    folders = [hit.folder.relative_to(library).as_posix() for hit in hits]
    table.add_column("folder", overflow="fold", min_width=min(60, max(map(len, folders))))
    table.add_column("score", no_wrap=True, justify="right")
    table.add_column("why", overflow="fold")
    for hit, folder in zip(hits, folders, strict=True):
        table.add_row(escape(terminal_safe(folder)), f"{hit.score:.3f}", escape(terminal_safe(hit.reason)))
    return table
