"""casa-assets textures: list, make, show, check and take in pictures of walls, floors, counters and cabinets."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from casa_assets.cli.group import Verb, group_of
from casa_assets.cli.options import WIDTH_HELP, AsJson, Jobs, LibraryOut, Out, complete_textures, more, shared
from casa_assets.cli.output import Output, TextTable, from_column, pluralize, working_on
from casa_assets.model.kitchen.choices import Surface

if TYPE_CHECKING:
    from casa_assets.model.issue import Report
    from casa_assets.model.registry.rows import TextureRecipe
    from casa_assets.textures.pack_entry import Pack

app = group_of("textures", "Pictures of walls, floors, counters and cabinets: list, make, sheet, check, ingest.")

Names = Annotated[
    list[str] | None,
    typer.Argument(help="Ids of recipes; whole sets where none is given.", autocompletion=complete_textures),
]
Sets = Annotated[
    list[Surface] | None,
    typer.Option("--set", help="Surfaces: wall, floor, counter, cabinet; all if neither an id nor a surface is given."),
]
OUT = Path("out/textures")


@app.command("list", cls=Verb)
def list_textures(surfaces: Sets = None, json_: AsJson = False) -> None:
    """List every recipe with its kind, size and substance.

    Exit 0.

    Example:  casa-assets textures list --set floor
    """
    from casa_assets.textures.run.check import select_recipes
    from casa_assets.textures.run.recipes import origin_of

    output = Output(json_)
    table = TextTable(("set", "id", "kind", "size [m]", "substance", *from_column()))
    for recipe in select_recipes([], surfaces or []):
        row = {**recipe.model_dump(mode="json"), "params": json.loads(recipe.params)}
        source = origin_of(recipe)
        output.row({**row, "size": list(recipe.tile_m), "from": source})
        size = f"{recipe.tile_m[0]:g} x {recipe.tile_m[1]:g}"
        table.add(_group(recipe), recipe.id, recipe.kind, size, recipe.substance, source)
    if not json_:
        table.print(output.console)
        output.line(pluralize(len(table.rows), "recipe"))


@app.command(cls=Verb)
@shared
def make(
    output: Output,
    names: Names = None,
    surfaces: Sets = None,
    out: Out = OUT,
    width_px: Annotated[int, typer.Option(min=64, max=4096, help=more(WIDTH_HELP, "that of the longer side."))] = 1024,
) -> None:
    """Write colour, metallic-roughness and normal pictures as PNG; finishes made before come from the cache.

    Exit 0 when all were made, 2 on misuse.

    Examples:

      casa-assets textures make subway_white_running oak_natural_plank
      casa-assets textures make --set wall --out walls
    """
    from casa_assets.core.system import cache_for
    from casa_assets.runs.outcome import writing
    from casa_assets.textures.run.check import select_recipes, write_finish

    recipes = select_recipes(names or [], surfaces or [])
    paths: list[str] = []
    with working_on(output.console, "painting", [recipe.id for recipe in recipes]) as done, writing(out):
        for recipe in recipes:
            folder = out / _group(recipe)
            paths = [str(path) for path in write_finish(recipe, folder, cache_for(out), width_px)]
            done(recipe.id)
            output.made(recipe.id, folder, _size(recipe.tile_m), files=paths)
            for path in paths:
                output.detail(path)
    output.line(f"{pluralize(len(recipes), 'recipe')} under {out}")
    output.look_at_file(Path(paths[0]))


@app.command(cls=Verb)
@shared
def sheet(
    output: Output,
    names: Names = None,
    surfaces: Sets = None,
    out: Out = OUT,
    side: Annotated[float, typer.Option(min=0.05, max=4, help="Metres of surface that a swatch shows.")] = 1.0,
    width_px: Annotated[int, typer.Option(min=64, max=512, help=more(WIDTH_HELP, "that of a swatch."))] = 192,
) -> None:
    """Contact sheets of ten by ten swatches, each a cut of true size, lit from the upper left.

    Exit 0 when the sheets are written, 2 on misuse.

    Example:  casa-assets textures sheet --set floor --side 2
    """
    from casa_assets.core.system import cache_for
    from casa_assets.runs.outcome import writing
    from casa_assets.textures.run.check import pages, select_recipes, shots

    recipes = select_recipes(names or [], surfaces or [])
    first: Path | None = None
    groups = (
        {s.value: [r for r in recipes if r.surface is s] for s in Surface} if not names else {"chosen": list(recipes)}
    )
    with working_on(output.console, "painting", [recipe.id for recipe in recipes]) as done, writing(out):
        out.mkdir(parents=True, exist_ok=True)
        for title, rows in groups.items():
            cells = []
            for cell in shots(rows, cache_for(out), side, width_px):
                cells.append(cell)
                done(cell.title)
            if not cells:
                continue
            whole = f"{title}: {len(rows)} textures, {side:g} m a swatch"
            for number, png in enumerate(pages(cells, whole, width_px), 1):
                path = out / (f"sheet_{title}.png" if number == 1 else f"sheet_{title}_{number}.png")
                path.write_bytes(png)
                output.made(title, out, picture=str(path), count=len(rows))
                output.line(str(path))
                first = first or path
    if first is not None:
        output.look_at_file(first)


@app.command(cls=Verb)
@shared
def check(output: Output, names: Names = None, surfaces: Sets = None, out: Out = OUT, jobs: Jobs = 0) -> None:
    """Check seams, brightness, normals, gloss, resolution, repeats, and that no two of a set are alike.

    Exit 0 when all pass, 1 when some do not, 2 on misuse.

    Example:  casa-assets textures check --set wall
    """
    from casa_assets.core.system import cache_for
    from casa_assets.runs.outcome import writing
    from casa_assets.textures.run.check import CheckedTexture, check_recipes, check_sets, select_recipes

    recipes = select_recipes(names or [], surfaces or [])
    checked: list[CheckedTexture] = []
    with working_on(output.console, "checking", [recipe.id for recipe in recipes]) as done, writing(out):
        for result in check_recipes(recipes, cache_for(out), jobs):
            checked.append(result)
            done(result.report.subject)
    reports = [c.report for c in checked] + list(check_sets(checked))
    for report in reports:
        output.row({"id": report.subject, "verdict": _verdict(report), **report.model_dump(mode="json")})
        output.detail(f"{_verdict(report)} {report.subject}: {report.tally}")
    table = TextTable(("subject", "code", "what"), sentences=("what",))
    for report in reports:
        for issue in report.issues:
            table.add(report.subject, issue.code, f"{issue.pointer} {issue.message}".strip())
    table.print(output.failures)
    bad = sum(not r.passed for r in reports)
    sets = pluralize(len(reports) - len(checked), "set")
    output.line(f"{pluralize(len(checked), 'texture')} and {sets} checked, {bad} with faults")
    if bad:
        raise typer.Exit(1)


@app.command(cls=Verb)
@shared
def ingest(
    output: Output,
    ctx: typer.Context,
    source: Annotated[Path, typer.Argument(help="Folder of pictures, with a pack.yaml if there is one.", exists=True)],
    library: LibraryOut = Path("out/library"),
    pack: Annotated[str | None, typer.Option(help="Name of the pack; else that of the folder.")] = None,
    surface: Annotated[Surface | None, typer.Option(help="What the pictures are for.")] = None,
    tile: Annotated[tuple[float, float] | None, typer.Option(help="Width and height of a picture, metres.")] = None,
    licence: Annotated[str | None, typer.Option(help="SPDX id, or the text of the licence.")] = None,
    generator: Annotated[str | None, typer.Option(help="Program or model that made the pictures.")] = None,
    substance: Annotated[str | None, typer.Option(help="Id in registry/substances.yaml.")] = None,
) -> None:
    """Make a pack of pictures: repair borders, derive normals and roughness, refuse what cannot be used.

    Files called brick_color, brick_normal (y up), brick_roughness, brick_metalness and brick_height are maps of one
    material, and are kept. In a project the pack is written to its textures/, unless --library is given: kitchens can
    use its pictures by their ids. pack.yaml in the folder overrides the options, picture by picture. Exit 0 when all
    were taken, 1 when some were left out, 2 on misuse.

    Example:  casa-assets textures ingest tiles --surface wall --tile 1.2 1.2
    """
    from pydantic import ValidationError

    from casa_assets.projects import project_folder
    from casa_assets.runs.outcome import writing
    from casa_assets.textures.pack_entry import PictureDescription
    from casa_assets.textures.run.packs import PackOptions, ingest_pack

    try:
        description = PictureDescription(
            surface=surface, tile_m=tile, licence=licence, generator=generator, substance=substance
        )
    except ValidationError as error:
        first = error.errors()[0]
        option = "--" + str(first["loc"][0]).removesuffix("_m")
        raise typer.BadParameter(first["msg"].removeprefix("Input "), param_hint=option) from None
    given = ctx.get_parameter_source("library")
    if (project := project_folder()) is not None and (given is None or given.name == "DEFAULT"):
        library = project
    with writing(library):
        report = ingest_pack(source, PackOptions(library=library, pack=pack, flags=description))
    _print_pack(report.pack, report.folder, output)
    state = "written" if report.changed else "unchanged"
    taken = f"{pluralize(len(report.pack.pictures), 'picture')} taken, {len(report.pack.refused)} left out"
    output.line(f"{taken}; {report.folder} {state}")
    if report.pack.pictures:
        output.look_at_file(report.folder / report.pack.pictures[0].files[0])
    if report.pack.refused:
        raise typer.Exit(1)


def _print_pack(pack: Pack, folder: Path, output: Output) -> None:
    """Print what was left out and why; as JSON, or in many words, what was taken too."""
    for picture in pack.pictures:
        facts = picture.model_dump(mode="json", exclude={"id"})
        output.made(picture.id, folder, _size(picture.tile_m), "accepted", **facts)
        output.detail(f"taken {picture.source}: {picture.id}")
    faults = TextTable(("taken, with faults", "fault"), sentences=("fault",))
    for picture in pack.pictures:
        for fault in picture.faults:
            faults.add(picture.id, fault)
    faults.print(output.failures)
    table = TextTable(("left out", "code", "why", "what to do"), sentences=("why", "what to do"))
    for refused in pack.refused:
        output.made("", "", None, "rejected", **refused.model_dump(mode="json"))
        table.add(refused.source, refused.code, refused.message, refused.fix)
    table.print(output.failures)


def _size(tile_m: tuple[float, float]) -> dict[str, Any]:
    """The `mass` and `size` of a texture in `--json`: no mass; width and height, metres."""
    return {"mass": None, "size": list(tile_m)}


def _verdict(report: Report) -> str:
    return "passed" if report.passed else "failed"


def _group(recipe: TextureRecipe) -> str:
    return "objects" if recipe.surface is None else recipe.surface.value
