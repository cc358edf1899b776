"""casa-assets families, objects: list, show and build parametric fixtures and loose objects; the catalogue."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from casa_assets.cli.batch_output import built_row, end_builds, print_problems
from casa_assets.cli.group import Verb, group_of
from casa_assets.cli.options import (
    ALL_HELP,
    COUNT_HELP,
    WIDTH_HELP,
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
    complete_families,
    complete_objects,
    complete_presets,
    more,
    shared,
)
from casa_assets.cli.output import Output, TextTable, from_column, measures_at, pluralize, working_on

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from casa_assets.families.build import FamilyRequest, FamilyResult
    from casa_assets.model.issue import Report

families = group_of(
    "families", "Parametric cabinets, counters, appliances and small things: list, show, build, catalogue."
)
HELP = "Families."
MAX_TOLD = 12  # problems of one check of all members that are printed; the library keeps all of them
objects = group_of("objects", "Loose objects, generated: food, tableware, packages; list, show, build.")
Names = Annotated[list[str], typer.Argument(help="Categories.", autocompletion=complete_objects)]


@families.command("list", cls=Verb)
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
            table.add(member.name, group, member.title, ", ".join(presets), source)
    if not json_:
        table.print(output.console)
        output.line(pluralize(len(table.rows), "family"))


@families.command(cls=Verb)
@shared
def show(
    output: Output,
    names: Annotated[list[str], typer.Argument(help=HELP, autocompletion=complete_families)],
    out: Out = Path("out/look"),
    preset: Annotated[
        list[str] | None, typer.Option(help="Presets; all where none is named.", autocompletion=complete_presets)
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
    end_builds(results, output)


@families.command(cls=Verb)
@shared
def build(
    output: Output,
    names: Annotated[list[str] | None, typer.Argument(help=HELP, autocompletion=complete_families)] = None,
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
    end_builds(_follow(build_all(requests, library, workers, pictures), requests, output), output)


@families.command(cls=Verb)
@shared
def catalogue(
    output: Output,
    names: Annotated[
        list[str] | None,
        typer.Argument(
            help="Families, and categories of objects; all where none is named.", autocompletion=complete_families
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


@objects.command("list", cls=Verb)
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
            table.add(name, group, member.form or "", about, source)
    if not json_:
        table.print(output.console)
        output.line(pluralize(len(table.rows), "category"))


@objects.command("show", cls=Verb)
@shared
def show_objects(
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


@objects.command("build", cls=Verb)
@shared
def build_objects(
    output: Output,
    names: Annotated[list[str] | None, typer.Argument(help="Categories.", autocompletion=complete_objects)] = None,
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
    results = _follow(build_all(requests, library, workers, drawn=False), requests, output)
    if (whole := read_library_report(library)) is not None:
        _print_together(whole.report, {row.code: row.title for row in ROWS}, output)
    output.next_command("report", "--library", library)
    end_builds(results, output)


def _follow(running: Iterable[FamilyResult], requests: Sequence[FamilyRequest], output: Output) -> list[FamilyResult]:
    """Print each member that failed, and as JSON or in many words each, as it is done; then medians; returns all."""
    from casa_assets.families.build import summary

    results: list[FamilyResult] = []
    with working_on(output.console, "building", [request.title for request in requests]) as done:
        for result in running:
            results.append(result)
            done(result.request.title)
            print_member(result, output)
    names = ("family", "passed", "of", "build s", "write s", "draw s", "check s", "CPU s", "MB")
    table = TextTable(names, right=names[1:], title="median per member")
    for row in summary(results):
        table.add(*row)
    table.print(output.console)
    if kept := sum(result.is_kept for result in results):
        output.line(f"{kept} of {len(results)} were there already and stay as they are")
    return results


def print_member(result: FamilyResult, output: Output, always: bool = False) -> None:
    """Print a member's verdict, times and issues; one that passed only if the user wants more words, or `always`."""
    row = built_row(result, result.asset_id, "passed" if result.passed else "failed", digits=4)
    row |= {"member": result.request.title, "kept": result.is_kept, "bytes": result.size_bytes}
    measured = measures_at(result.folder if result.passed else None)
    output.row({**row, **measured, "cpu_s": round(result.cpu_s, 4)})
    if result.passed and not (always or output.verbose):
        return
    mark = "[green]passed[/]" if result.passed else "[red]failed[/]"
    seconds = f"build {result.build_s:.2f} s, write {result.write_s:.2f} s, check {result.check_s:.2f} s"
    where = f" {result.asset_id} ({seconds}, {result.size_bytes / 1e6:.2f} MB)" if result.asset_id else ""
    output.styled(f"{mark} [bold]{result.request.title}[/]{where}", is_wrong=not result.passed)
    print_problems(result, output)


def _print_together(report: Report, titles: Mapping[str, str], output: Output) -> None:
    """Print what the checks with these titles found of all members together, the first few problems of each."""
    for result in (one for one in report.results if one.code in titles):
        number = result.reason if result.number is None else f"{result.number:.3g} (limit {result.limit:g})"
        output.line(f"{result.code} {titles[result.code]}: {result.status.value}, {number}")
        found = [issue for issue in report.issues if issue.code == result.code]
        for issue in found if output.verbose else found[:MAX_TOLD]:
            output.line(f"  {issue.pointer}: {issue.message}")
        if len(found) > MAX_TOLD and not output.verbose:
            output.line(f"  and {len(found) - MAX_TOLD} more, in library.json")
