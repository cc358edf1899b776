"""casa-assets textures: list, make, show, check and take in pictures of walls, floors, counters and cabinets."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from casa_assets.cli.progress import bar
from casa_assets.cli.text import pluralize
from casa_assets.model.kitchen.surface import Surface

if TYPE_CHECKING:
    from casa_assets.model.registry.texture_recipe import TextureRecipe

app = typer.Typer(
    name="textures",
    help="Pictures of walls, floors, counters and cabinets: list, make, sheet, check, ingest.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)

Names = Annotated[list[str] | None, typer.Argument(help="Ids of recipes; whole sets where none is given.")]
Sets = Annotated[list[Surface] | None, typer.Option("--set", help="Sets; all where neither id nor set is given.")]
Out = Annotated[Path, typer.Option("--out", "-o", help="Output folder, made where it is missing.")]
AsJson = Annotated[bool, typer.Option("--json", help="JSON on standard output.")]
OUT = Path("out/textures")


@app.command("list")
def list_textures(surfaces: Sets = None, json_: AsJson = False) -> None:
    """Name every recipe with its kind, size and substance.

    Example:  casa-assets textures list --set floor
    """
    from casa_assets.pipeline.textures.check import select_recipes

    found = select_recipes([], surfaces or [])
    if json_:
        typer.echo(json.dumps([{**r.model_dump(mode="json"), "params": json.loads(r.params)} for r in found], indent=1))
        return
    table = Table("set", "id", "kind", "size [m]", "substance")
    for r in found:
        table.add_row(_group(r), r.id, r.kind, f"{r.tile_m[0]:g} x {r.tile_m[1]:g}", r.substance)
    console = Console()
    console.print(table)
    console.print(pluralize(len(found), "recipe"), highlight=False)


@app.command()
def make(
    names: Names = None,
    surfaces: Sets = None,
    out: Out = OUT,
    size: Annotated[int, typer.Option(min=64, max=4096, help="Pixels of the longer side.")] = 1024,
    json_: AsJson = False,
) -> None:
    """Write colour, metallic-roughness and normal pictures as PNG; finishes made before come from the cache.

    Examples:

      casa-assets textures make subway_white_running oak_natural_plank

      casa-assets textures make --set wall -o walls
    """
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.textures.check import select_recipes
    from casa_assets.pipeline.textures.sheet import write_finish

    recipes = select_recipes(names or [], surfaces or [])
    console = Console(stderr=json_)
    with bar(console) as progress, writing(out):
        task = progress.add_task("painting", total=len(recipes))
        for recipe in recipes:
            paths = write_finish(recipe, out / _group(recipe), _cache(out), size)
            progress.advance(task)
            if json_:
                typer.echo(json.dumps({"id": recipe.id, "files": [str(p) for p in paths]}))
    console.print(f"{pluralize(len(recipes), 'recipe')} under {escape(str(out))}", highlight=False, soft_wrap=True)


@app.command()
def sheet(
    names: Names = None,
    surfaces: Sets = None,
    out: Out = OUT,
    side: Annotated[float, typer.Option(min=0.05, max=4, help="Metres of surface that a swatch shows.")] = 1.0,
    size: Annotated[int, typer.Option(min=64, max=512, help="Pixels of a swatch.")] = 192,
) -> None:
    """Contact sheets of ten by ten swatches, each a cut of true size, lit from the upper left.

    Example:  casa-assets textures sheet --set floor --side 2
    """
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.textures.check import select_recipes
    from casa_assets.pipeline.textures.sheet import pages, shots

    console = Console()
    recipes = select_recipes(names or [], surfaces or [])
    groups = (
        {s.value: [r for r in recipes if r.surface is s] for s in Surface} if not names else {"chosen": list(recipes)}
    )
    with bar(console) as progress, writing(out):
        out.mkdir(parents=True, exist_ok=True)
        task = progress.add_task("painting", total=len(recipes))
        for title, rows in groups.items():
            cells = []
            for cell in shots(rows, _cache(out), side, size):
                cells.append(cell)
                progress.advance(task)
            if not cells:
                continue
            for number, png in enumerate(pages(cells, f"{title}: {len(rows)} textures, {side:g} m a swatch", size), 1):
                path = out / (f"sheet_{title}.png" if number == 1 else f"sheet_{title}_{number}.png")
                path.write_bytes(png)
                console.print(str(path), highlight=False, soft_wrap=True)


@app.command()
def check(
    names: Names = None,
    surfaces: Sets = None,
    out: Out = OUT,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    json_: AsJson = False,
) -> None:
    """Check seams, brightness, normals, gloss, resolution, repeats, and that no two of a set are alike.

    Exit 0 when all pass, 1 when some do not.

    Example:  casa-assets textures check --set wall
    """
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.textures.check import CheckedTexture, check_recipes, check_sets, select_recipes

    recipes = select_recipes(names or [], surfaces or [])
    console = Console(stderr=json_)
    checked: list[CheckedTexture] = []
    with bar(console) as progress, writing(out):
        task = progress.add_task("checking", total=len(recipes))
        for result in check_recipes(recipes, _cache(out), jobs):
            checked.append(result)
            progress.advance(task)
    reports = [c.report for c in checked] + list(check_sets(checked))
    if json_:
        typer.echo(json.dumps([r.model_dump(mode="json") for r in reports], indent=1))
    table = Table("subject", "code", "what")
    for report in reports:
        for issue in report.issues:
            table.add_row(report.subject, issue.code, escape(f"{issue.pointer} {issue.message}".strip()))
    if table.row_count:
        console.print(table)
    bad = sum(not r.passed for r in reports)
    sets = pluralize(len(reports) - len(checked), "set")
    console.print(f"{pluralize(len(checked), 'texture')} and {sets} checked, {bad} with faults", highlight=False)
    if bad:
        raise typer.Exit(1)


@app.command()
def ingest(
    folder: Annotated[
        Path, typer.Argument(help="Folder of pictures, with a pack.yaml if there is one.", exists=True, file_okay=False)
    ],
    library: Annotated[
        Path, typer.Option("--out", "--library", help="Output folder, made where it is missing.")
    ] = Path("out/library"),
    pack: Annotated[str | None, typer.Option(help="Name of the pack; else that of the folder.")] = None,
    surface: Annotated[Surface | None, typer.Option(help="What the pictures are for.")] = None,
    tile: Annotated[tuple[float, float] | None, typer.Option(help="Width and height of a picture, metres.")] = None,
    licence: Annotated[str | None, typer.Option(help="SPDX id, or the words of whoever gives it.")] = None,
    generator: Annotated[str | None, typer.Option(help="Program or model that made the pictures.")] = None,
    substance: Annotated[str | None, typer.Option(help="Id in registry/substances.yaml.")] = None,
    json_: AsJson = False,
) -> None:
    """Take in a folder of pictures: repair their borders, derive normals and roughness, refuse what cannot be used.

    What pack.yaml says of a picture goes before the options. Exit 0 when all were taken, 1 when some were left out.

    Example:  casa-assets textures ingest painted_tiles --surface wall --tile 1.2 1.2 --licence CC0-1.0
    """
    from pydantic import ValidationError

    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.textures.packs import PackOptions, ingest_pack
    from casa_assets.textures.packs.entry import PictureDescription

    try:
        description = PictureDescription(
            surface=surface, tile_m=tile, licence=licence, generator=generator, substance=substance
        )
    except ValidationError as error:
        first = error.errors()[0]
        option = "--" + str(first["loc"][0]).removesuffix("_m")
        raise typer.BadParameter(first["msg"].removeprefix("Input "), param_hint=option) from None
    with writing(library):
        report = ingest_pack(folder, PackOptions(library=library, pack=pack, flags=description))
    console = Console(stderr=json_)
    if json_:
        typer.echo(json.dumps(report.pack.model_dump(mode="json"), indent=1))
    table = Table("left out", "code", "why", "what to do")
    for refused in report.pack.refused:
        table.add_row(escape(refused.source), refused.code, escape(refused.message), escape(refused.fix))
    if table.row_count:
        console.print(table)
    taken, state = len(report.pack.pictures), "written" if report.changed else "unchanged"
    message = f"{pluralize(taken, 'picture')} taken, {len(report.pack.refused)} left out"
    console.print(f"{message}; {escape(str(report.folder))} {state}", highlight=False, soft_wrap=True)
    if report.pack.refused:
        raise typer.Exit(1)


def _cache(out: Path) -> Path:
    from casa_assets.pipeline.library.library import Library

    return Library(out).cache


def _group(recipe: TextureRecipe) -> str:
    """The surface of a recipe, or `objects`."""
    return "objects" if recipe.surface is None else recipe.surface.value
