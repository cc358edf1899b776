"""casa-assets families: list, show and build parametric fixtures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from casa_assets.cli import completion
from casa_assets.cli.build_output import end, follow_members, print_member, print_members
from casa_assets.cli.group import Verb, group_of
from casa_assets.cli.options import (
    All,
    AsJson,
    In3d,
    Jobs,
    LibraryOut,
    Out,
    Pictures,
    Samples,
    Seed,
    WidthPx,
    Workers,
    shared,
)
from casa_assets.cli.output import Output, TextTable, from_column, pluralize, working_on

if TYPE_CHECKING:
    from casa_assets.families.build import FamilyResult

app = group_of("families", "Parametric cabinets, counters, appliances and small things: list, show, build, catalogue.")
HELP = "Families."


@app.command("list", cls=Verb)
def list_families(json_: AsJson = False) -> None:
    """List every family with its presets.

    Exit 0.

    Example:  casa-assets families list
    """
    from casa_assets.registry.families import family_groups
    from casa_assets.registry.plugins.families import plugin_families
    from casa_assets.registry.read import origin_of_row

    output = Output(json_)
    table = TextTable(("family", "group", "what", "presets", *from_column()), sentences=("what", "presets"))
    for group, members in family_groups().items():
        for member in members:
            presets = list(member.presets)
            added = plugin_families().get(member.name)
            source = f"plug-in {added[0].plugin.name}" if added else origin_of_row(f"families/{member.name}.yaml")
            output.row({"id": member.name, "group": group, "title": member.title, "presets": presets, "from": source})
            table.add_from(member.name, group, member.title, ", ".join(presets), source)
    if not json_:
        table.print(output.console)
        output.line(pluralize(len(table.rows), "family"))


@app.command(cls=Verb)
@shared
def show(
    output: Output,
    names: Annotated[list[str], typer.Argument(help=HELP, autocompletion=completion.families)],
    out: Out = Path("out/look"),
    preset: Annotated[
        list[str] | None,
        typer.Option(help="Presets; all where none is named.", autocompletion=completion.presets),
    ] = None,
    samples: Samples = 0,
    seed: Seed = 0,
    width_px: WidthPx = 384,
    check: Annotated[bool, typer.Option("--check/--no-check", help="Run every check on each.")] = True,
) -> None:
    """Print the parameters of families, build members into a folder and draw them closed, open and as collision shapes.

    Without --samples, presets are shown. Exit 0 when all pass, 1 when some do not, 2 on misuse.

    Example:  casa-assets families show microwave --preset steel --out /tmp/look
    """
    from casa_assets.families.build import FamilyRequest, build_one, params_of, requests_for
    from casa_assets.families.object_sheets import pictures
    from casa_assets.registry.families import family, parameters_of
    from casa_assets.runs.outcome import writing

    requests = requests_for(names, samples, seed, presets=not samples)
    if preset:
        requests = [FamilyRequest(name, preset=p) for name in names for p in preset]
        for request in requests:
            params_of(request)  # raises UnknownId before anything is made
    for name in names if not output.as_json else ():
        table = TextTable(
            ("parameter", "type", "default", "bounds", "description"), ("type", "description"), title=name
        )
        for row in parameters_of(family(name).params):
            table.add(row.name, row.kind, row.default, row.bounds, row.description)
        table.print(output.console)
    results: list[FamilyResult] = []
    with writing(out), working_on(output.console, "building", [request.title for request in requests]) as done:
        for request in requests:
            result = build_one(request, out, checked=check, drawn=False)
            results.append(result)
            done(request.title)
            print_member(result, output, always=True)
            stem = request.title.replace("/", "_").replace("#", "n")
            for path in pictures(Path(result.folder), out, stem, width_px) if result.folder else ():
                output.line(f"  {path}")
    end(results, output)


@app.command(cls=Verb)
@shared
def build(
    output: Output,
    names: Annotated[list[str] | None, typer.Argument(help=HELP, autocompletion=completion.families)] = None,
    all_: All = False,
    samples: Samples = 0,
    presets: Annotated[
        bool,
        typer.Option(
            "--presets/--no-presets", help="Build every preset too; without --samples only presets are built."
        ),
    ] = False,
    seed: Seed = 0,
    library: LibraryOut = Path("out/families"),
    workers: Workers = 0,
    pictures: Pictures = True,
) -> None:
    """Build members, write them as MJCF and USD, and run every check.

    With --no-pictures only a thumbnail is drawn. Exit 0 when all pass, 1 when some do not, 2 on misuse.

    Example:  casa-assets families build --all --samples 20
    """
    from casa_assets.families.build import build_all, requests_for

    if not names and not all_:
        raise typer.BadParameter("name families, or give --all")
    requests = requests_for([] if all_ else names or [], samples, seed, presets or not samples)
    results = follow_members(build_all(requests, library, workers, pictures), requests, output)
    print_members(results, output)
    end(results, output)


@app.command(cls=Verb)
@shared
def catalogue(
    output: Output,
    names: Annotated[
        list[str] | None,
        typer.Argument(
            help="Families, and categories of objects; all where none is named.", autocompletion=completion.families
        ),
    ] = None,
    out: Out = Path("out/catalogue"),
    jobs: Jobs = 0,
    swatches: Annotated[bool, typer.Option("--swatches/--no-swatches", help="Also a swatch of every texture.")] = True,
    in_3d: In3d = True,
) -> None:
    """Draw every preset, closed and open, the first objects of every category, and every texture, on one HTML page.

    All of it takes many minutes; name families or categories of objects and give --no-swatches for less. Exit 0 when
    the page is written, 2 on misuse.

    Example:  casa-assets families catalogue microwave toaster apple --no-swatches
    """
    from casa_assets.runs.outcome import writing
    from casa_assets.show.reports.catalogue import make, title_of, wanted

    titles = [title_of(request) for request in wanted(names or [])]
    also = " and every texture" if swatches else ""
    output.line(f"drawing {pluralize(len(titles), 'row')}{also}; this may take many minutes")
    last = ""
    with writing(out), working_on(output.console, "drawing", titles) as done:
        for last in make(out, jobs, names or [], swatches, in_3d):
            done(last)
            output.detail(last)
    output.made("catalogue", out, page=last, count=len(titles))
    output.line(f"Catalogue: {last}")
    output.look_at_file(Path(last))
