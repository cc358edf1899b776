"""casa-assets families: list, show and build parametric fixtures."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from casa_assets.cli.member_output import check_faults, json_row, print_result, print_summary
from casa_assets.cli.options import In3d
from casa_assets.cli.progress import bar
from casa_assets.cli.text import pluralize

if TYPE_CHECKING:
    from casa_assets.pipeline.families.run import FamilyResult

app = typer.Typer(
    name="families",
    help="Parametric cabinets, counters, appliances and what stands about: list, show, build.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)


@app.command("list")
def list_families(
    json_: Annotated[bool, typer.Option("--json", help="One JSON object on standard output.")] = False,
) -> None:
    """Name every family with its presets.

    Example:  casa-assets families list
    """
    from casa_assets.registry.families import family_groups

    groups = family_groups()
    if json_:
        rows = {
            f.name: {"group": g, "title": f.title, "presets": list(f.presets)} for g, fs in groups.items() for f in fs
        }
        typer.echo(json.dumps(rows, indent=1))
        return
    table = Table("family", "group", "what", "presets")
    for group, members in groups.items():
        for member in members:
            table.add_row(member.name, group, member.title, ", ".join(member.presets))
    console = Console()
    console.print(table)
    console.print(pluralize(sum(map(len, groups.values())), "family"), highlight=False)


@app.command()
def show(
    names: Annotated[list[str], typer.Argument(help="Families.")],
    out: Annotated[Path, typer.Option(help="Folder for packages and pictures.")],
    preset: Annotated[list[str] | None, typer.Option(help="Presets to show; all where none is named.")] = None,
    samples: Annotated[int, typer.Option(min=0, help="Random members instead of presets.")] = 0,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random members.")] = 0,
    size: Annotated[int, typer.Option(min=64, max=2048, help="Pixels of a picture.")] = 384,
    check: Annotated[bool, typer.Option(help="Run every check on each.")] = True,
) -> None:
    """Build members into a folder and draw them closed, open and as they are touched.

    Example:  casa-assets families show microwave --preset steel --out /tmp/look
    """
    from casa_assets.pipeline.families.run import FamilyRequest, build_one, params_of, requests_for
    from casa_assets.pipeline.families.showcase import pictures
    from casa_assets.pipeline.ingest.job import writing

    console = Console()
    requests = requests_for(names, samples, seed, presets=not samples)
    if preset:
        requests = [FamilyRequest(name, preset=p) for name in names for p in preset]
        for request in requests:
            params_of(request)  # raises UnknownId before anything is made
    results: list[FamilyResult] = []
    with writing(out):
        for request in requests:
            result = build_one(request, out, checked=check, drawn=False)
            results.append(result)
            print_result(result, console)
            if result.folder:
                for path in pictures(Path(result.folder), out, request.title.replace("/", "_").replace("#", "n"), size):
                    console.print(f"  {path}", highlight=False, soft_wrap=True)
    check_faults(results)
    if not all(r.passed for r in results):
        raise typer.Exit(1)


@app.command()
def build(
    names: Annotated[list[str] | None, typer.Argument(help="Families.")] = None,
    all_: Annotated[bool, typer.Option("--all", help="Every family.")] = False,
    samples: Annotated[int, typer.Option(min=0, help="Random members of each.")] = 0,
    presets: Annotated[bool, typer.Option(help="Also every preset.")] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random members.")] = 0,
    library: Annotated[
        Path, typer.Option("--out", "--library", help="Output folder, made where it is missing.")
    ] = Path("out/families"),
    jobs: Annotated[int, typer.Option(min=0, help="Processes; 0: one per core.")] = 0,
    pictures: Annotated[bool, typer.Option(help="Draw each at full size; else at the size of a thumbnail.")] = True,
    json_: Annotated[bool, typer.Option("--json", help="One JSON object per member on standard output.")] = False,
) -> None:
    """Build members, write them as MJCF and USD, and run every check; exit 0 when all pass, 1 when some do not.

    Example:  casa-assets families build --all --samples 20
    """
    from casa_assets.pipeline.families.run import build_all, requests_for

    if not names and not all_:
        raise typer.BadParameter("name families, or give --all")
    console = Console(stderr=json_)
    requests = requests_for([] if all_ else names or [], samples, seed, presets or not samples)
    results: list[FamilyResult] = []
    with bar(console) as progress:
        task = progress.add_task("building", total=len(requests))
        for result in build_all(requests, library, jobs, pictures):
            results.append(result)
            progress.update(task, completed=len(results))
            if json_:
                typer.echo(json.dumps(json_row(result), sort_keys=True))
            elif not result.passed:
                print_result(result, progress.console)
    print_summary(results, console)
    check_faults(results)
    if not all(r.passed for r in results):
        raise typer.Exit(1)


@app.command()
def catalogue(
    names: Annotated[list[str] | None, typer.Argument(help="Families; all where none is named.")] = None,
    out: Annotated[Path, typer.Option(help="Output folder, made where it is missing.")] = Path("out/catalogue"),
    jobs: Annotated[int, typer.Option(min=0, help="Processes; 0: one per core.")] = 0,
    textures: Annotated[bool, typer.Option(help="Also a swatch of every texture.")] = True,
    in_3d: In3d = True,
) -> None:
    """Draw every preset, closed and open, and every texture, on one HTML page.

    Example:  casa-assets families catalogue --out out/catalogue
    """
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.reports.catalogue import make

    console = Console()
    done = ""
    columns = SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn()
    with Progress(*columns, console=console, disable=not console.is_interactive) as progress:
        task = progress.add_task("drawing", total=None)
        with writing(out):
            for done in make(out, jobs, names or [], textures, in_3d):
                progress.update(task, description=escape(done))
    console.print(f"Catalogue: {done}", highlight=False, soft_wrap=True)
