"""casa-assets find: assets of a library by words and conditions."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from casa_assets.cli.options import CLIP_HELP, Library, Most, library_at, more, shared
from casa_assets.cli.output import Output, TextTable, measures, measures_at, pluralize, terminal_safe

if TYPE_CHECKING:
    from casa_assets.library.search import Found, SearchHit


@shared
def find(
    output: Output,
    query: Annotated[
        str, typer.Argument(help='What you look for, such as "red mug"; may be left out beside --where.')
    ] = "",
    library: Library = Path("out/library"),
    where: Annotated[
        list[str] | None,
        typer.Option(help="What must hold, such as category=mug, 'size<=0.3' or reason=FLT005; may be repeated."),
    ] = None,
    clip_weights: Annotated[str, typer.Option(help=more(CLIP_HELP, "the words are compared with pictures."))] = "",
    most: Most = 10,
) -> None:
    """Search a library by words, by conditions or by both.

    Words are looked for in categories, titles and colours; with --clip-weights they are compared with the pictures.

    A condition is a field, an operator and a value. Words: category, verdict, reason, decide, source, licence, author,
    split, producer, id, with = or !=; values after commas are alternatives. Numbers: size (longest side, m), mass (kg),
    faces, colliders, warnings, with =, !=, <, <=, > or >=. Rejected inputs are searched where a condition names a
    verdict, a reason or an id. Without words rows come in the order of their ids.

    Exit 0 where something fits, 1 where nothing does, 2 on misuse.

    Examples:

      casa-assets find "red mug"
      casa-assets find "red mug" --clip-weights ~/ViT-B-32-laion2b.pt
      casa-assets find --where category=mug,cup --where 'size<=0.12' --json
      casa-assets find --where reason=FLT005 --most 100
    """
    from casa_assets.library.search import entries_that, parse_condition, search_entries, with_default

    conditions = [parse_condition(text) for text in where or ()]
    has_words = bool(query.strip())
    if not has_words and (clip_weights or not conditions):
        raise typer.BadParameter("there are no words to look for", param_hint="QUERY")
    if clip_weights and conditions:
        raise typer.BadParameter("searches without pictures; leave --clip-weights out", param_hint="--where")
    if clip_weights:
        found = _by_picture(query, library, clip_weights, most)
    else:
        fitting = entries_that(library_at(library), with_default(conditions))
        found = search_entries(fitting, library, query, most)
    if not found.hits:
        output.error(f"no match{_unnamed(library) if has_words else ''}")
        raise typer.Exit(1)
    _tell(found, library, has_words, output)


def _unnamed(library: Path) -> str:
    """How many assets words cannot find because nobody knows their category; empty for none."""
    from casa_assets.library.search import entries_that, parse_condition

    count = sum(1 for _ in entries_that(library_at(library), [parse_condition("decide=category")]))
    return f"; {pluralize(count, 'asset')} in review without a category: casa-assets review {library}" if count else ""


def _by_picture(query: str, library: Path, clip_weights: str, most: int) -> Found:
    from casa_assets.library.clip import load_clip
    from casa_assets.library.search import Found, search_by_picture

    hits = search_by_picture(query, library_at(library), load_clip(clip_weights), most)
    return Found(hits, len(hits))


def _tell(found: Found, root: Path, has_words: bool, output: Output) -> None:
    """Print what was found; how well it fits where words were looked for, and else its category."""
    heads = ("folder", "score", "why") if has_words else ("folder", "category")
    table = TextTable(heads, sentences=("why",), right=("score",))
    for hit in found.hits:
        row = {"id": hit.id, "category": hit.category, "folder": str(hit.folder), "score": hit.score}
        output.row({**row, **(_facts(hit) if output.as_json else {}), "verdict": "found", "reason": hit.reason})
        folder = hit.folder.relative_to(root).as_posix()
        facts = (f"{hit.score:.3f}", hit.reason) if has_words else (hit.category,)
        table.add(terminal_safe(folder), *map(terminal_safe, facts))
    if not output.as_json:
        table.print(output.console)
        output.line(f"Folders are those under {terminal_safe(str(root))}/")
        if found.count > len(found.hits):
            output.line(f"{pluralize(found.count, 'entry')} fit; --most shows more of them")


def _facts(hit: SearchHit) -> dict[str, Any]:
    """Mass and size of what was found and, where its entry was read, what became of it."""
    if (entry := hit.entry) is None:
        return measures_at(hit.folder)
    told = {"status": entry.decision.value, "code": entry.code, "title": entry.title}
    return {**measures(entry.summary), **told, "source": entry.source, "source_path": entry.source_path}
