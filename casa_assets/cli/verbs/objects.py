"""casa-assets objects: list, show and build things that stand about in a kitchen and can be moved."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.table import Table

from casa_assets.cli.member_output import check_faults, json_row, print_result, print_summary, print_together
from casa_assets.cli.options import In3d
from casa_assets.cli.progress import bar
from casa_assets.cli.text import pluralize

if TYPE_CHECKING:
    from casa_assets.pipeline.families.run import FamilyResult

app = typer.Typer(
    name="objects",
    help="Food, tableware and packages out of numbers, one kind for each category: list, show, build.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)


@app.command("list")
def list_objects(
    json_: Annotated[bool, typer.Option("--json", help="One JSON object on standard output.")] = False,
) -> None:
    """Name every category of which there are objects.

    Example:  casa-assets objects list
    """
    from casa_assets.registry.objects import object_family, object_files

    files = object_files()
    if json_:
        rows = {
            name: {"group": group, "form": object_family(name).form, "about": object_family(name).description}
            for group, names in files.items()
            for name in names
        }
        typer.echo(json.dumps(rows, indent=1))
        return
    table = Table("category", "group", "form", "about")
    for group, names in files.items():
        for name in names:
            member = object_family(name)
            table.add_row(name, group, member.form, member.description)
    console = Console()
    console.print(table)
    console.print(pluralize(sum(map(len, files.values())), "category"), highlight=False)


@app.command()
def show(
    names: Annotated[list[str], typer.Argument(help="Categories.")],
    out: Annotated[Path, typer.Option(help="Folder for the sheets.")] = Path("out/objects/sheets"),
    count: Annotated[int, typer.Option(min=1, max=400, help="Members of each.")] = 16,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the draws.")] = 0,
    size: Annotated[int, typer.Option(min=64, max=1024, help="Pixels of a picture.")] = 224,
) -> None:
    """Draw the first members of categories, on one sheet for each; nothing is checked.

    Example:  casa-assets objects show apple banana --out /tmp/look
    """
    from casa_assets.pipeline.families.object_sheets import write_sheet
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.registry.objects import object_family

    console = Console()
    for name in names:
        object_family(name)  # raises UnknownId before anything is made
    with writing(out), bar(console) as progress:
        out.mkdir(parents=True, exist_ok=True)
        task = progress.add_task("drawing", total=len(names))
        for done, name in enumerate(names, 1):
            path = write_sheet(name, out, count, seed, size)
            progress.update(task, completed=done)
            progress.console.print(str(path), highlight=False, soft_wrap=True)


@app.command()
def build(
    names: Annotated[list[str] | None, typer.Argument(help="Categories.")] = None,
    all_: Annotated[bool, typer.Option("--all", help="Every category.")] = False,
    count: Annotated[int, typer.Option(min=1, max=4000, help="Members of each.")] = 17,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the draws.")] = 0,
    library: Annotated[
        Path, typer.Option("--library", "--out", help="Library, made where it is missing; what it has is kept.")
    ] = Path("out/objects"),
    jobs: Annotated[int, typer.Option(min=0, help="Processes; 0: one per core.")] = 0,
    json_: Annotated[bool, typer.Option("--json", help="One JSON object per member on standard output.")] = False,
) -> None:
    """Build members into a library, as MJCF and USD, and run every check; exit 0 when all pass, 1 when some do not.

    What the library has already stays as it is; killed and run again, it does what is missing.

    Example:  casa-assets objects build --all --count 17 --library out/objects
    """
    from casa_assets.checks.table.objects import ROWS
    from casa_assets.pipeline.dedup.library_report import read_library_report
    from casa_assets.pipeline.families.run import build_all, object_requests

    if not names and not all_:
        raise typer.BadParameter("name categories, or give --all")
    console = Console(stderr=json_)
    requests = object_requests([] if all_ else names or [], count, seed)
    results: list[FamilyResult] = []
    with bar(console) as progress:
        task = progress.add_task("building", total=len(requests))
        for result in build_all(requests, library, jobs, drawn=False):
            results.append(result)
            progress.update(task, completed=len(results))
            if json_:
                typer.echo(json.dumps(json_row(result), sort_keys=True))
            elif not result.passed:
                print_result(result, progress.console)
    print_summary(results, console)
    whole = read_library_report(library)
    if whole is not None:
        print_together(whole.report, {row.code: row.title for row in ROWS}, console)
    console.print(f"Next:    casa-assets report --library {library}", highlight=False, soft_wrap=True)
    check_faults(results)
    if not all(r.passed for r in results):
        raise typer.Exit(1)


@app.command()
def catalogue(
    names: Annotated[list[str] | None, typer.Argument(help="Categories; all where none is named.")] = None,
    out: Annotated[Path, typer.Option(help="Output folder, made where it is missing.")] = Path("out/catalogue"),
    count: Annotated[int, typer.Option(min=1, max=16, help="Members of each.")] = 6,
    jobs: Annotated[int, typer.Option(min=0, help="Processes; 0: one per core.")] = 0,
    in_3d: In3d = True,
) -> None:
    """Draw the first members of every category on one HTML page, with sizes and masses beside the usual ones.

    Example:  casa-assets objects catalogue --out out/catalogue
    """
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.reports.object_catalogue import make

    console = Console()
    done = ""
    with writing(out), bar(console) as progress:
        task = progress.add_task("drawing", total=None)
        for done in make(out, count, jobs, names or [], in_3d):
            progress.update(task, description=done)
    console.print(f"Catalogue: {done}", highlight=False, soft_wrap=True)
