"""casa-assets objects: list, show and build loose objects of a kitchen, which can be moved."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from casa_assets.cli import completion
from casa_assets.cli.build_output import end, follow_members, print_members, print_together
from casa_assets.cli.group import Verb, group_of
from casa_assets.cli.options import (
    ALL_HELP,
    COUNT_HELP,
    WIDTH_HELP,
    AsJson,
    LibraryOut,
    Out,
    Seed,
    Workers,
    more,
    shared,
)
from casa_assets.cli.output import Output, TextTable, from_column, pluralize, working_on

app = group_of("objects", "Loose objects, generated: food, tableware, packages; list, show, build.")
Names = Annotated[list[str], typer.Argument(help="Categories.", autocompletion=completion.objects)]


@app.command("list", cls=Verb)
def list_objects(json_: AsJson = False) -> None:
    """List every category of which objects can be generated.

    Exit 0.

    Example:  casa-assets objects list
    """
    from casa_assets.registry.families import object_family, object_files
    from casa_assets.registry.read import origin_of_row

    output = Output(json_)
    table = TextTable(("category", "group", "form", "about", *from_column()), sentences=("about",))
    for group, names in object_files().items():
        for name in names:
            member = object_family(name)
            about = member.description
            source = origin_of_row(f"objects/{group}.yaml", name)
            facts = {"group": group, "form": member.form, "about": about, "from": source}
            output.row({"id": name, "category": name, **facts})
            table.add_from(name, group, member.form or "", about, source)
    if not json_:
        table.print(output.console)
        output.line(pluralize(len(table.rows), "category"))


@app.command(cls=Verb)
@shared
def show(
    output: Output,
    names: Names,
    out: Out = Path("out/objects/sheets"),
    count: Annotated[int, typer.Option(min=1, max=400, help=COUNT_HELP)] = 16,
    seed: Seed = 0,
    width_px: Annotated[int, typer.Option(min=64, max=1024, help=WIDTH_HELP)] = 224,
) -> None:
    """Draw the first members of categories, on one sheet for each; nothing is checked.

    Exit 0 when all were drawn, 2 on misuse.

    Example:  casa-assets objects show apple banana --out /tmp/look
    """
    from casa_assets.families.object_sheets import write_sheet
    from casa_assets.registry.families import object_family
    from casa_assets.runs.outcome import writing

    for name in names:
        object_family(name)  # raises UnknownId before anything is made
    with writing(out), working_on(output.console, "drawing", names) as done:
        out.mkdir(parents=True, exist_ok=True)
        for name in names:
            path = write_sheet(name, out, count, seed, width_px)
            done(name)
            output.made(name, out, picture=str(path), count=count)
            output.line(str(path))
    output.look(names[0])


@app.command(cls=Verb)
@shared
def build(
    output: Output,
    names: Annotated[list[str] | None, typer.Argument(help="Categories.", autocompletion=completion.objects)] = None,
    all_: Annotated[bool, typer.Option("--all", help=more(ALL_HELP, "every category."))] = False,
    count: Annotated[int, typer.Option(min=1, max=4000, help=COUNT_HELP)] = 17,
    seed: Seed = 0,
    library: LibraryOut = Path("out/objects"),
    workers: Workers = 0,
) -> None:
    """Build members into a library, as MJCF and USD, and run every check.

    What the library has already stays as it is; killed and run again, it does what is missing. Exit 0 when all pass, 1
    when some do not, 2 on misuse.

    Example:  casa-assets objects build --all --count 17 --library out/objects
    """
    from casa_assets.checks.objects import ROWS
    from casa_assets.families.build import build_all, object_requests
    from casa_assets.library.library_report import read_library_report

    if not names and not all_:
        raise typer.BadParameter("name categories, or give --all")
    requests = object_requests([] if all_ else names or [], count, seed)
    results = follow_members(build_all(requests, library, workers, drawn=False), requests, output)
    print_members(results, output)
    whole = read_library_report(library)
    if whole is not None:
        print_together(whole.report, {row.code: row.title for row in ROWS}, output)
    output.next_command("report", "--library", library)
    end(results, output)
