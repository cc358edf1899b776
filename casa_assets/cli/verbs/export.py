"""casa-assets export: libraries and kitchens in the form that another program reads."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Generator, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from casa_assets.cli.group import Verb, group_of
from casa_assets.cli.options import LIBRARY_HELP, OUT_HELP, Jobs, Kitchens, WithReview, complete_assets, more, shared
from casa_assets.cli.output import Output, TextTable, bar, measures, measures_at, pluralize, safe, terminal_safe

if TYPE_CHECKING:
    from casa_assets.addons.robocasa.run import ExportResult as ExportedObject
    from casa_assets.addons.robocasa.run import KitchenResult, TaskReport
    from casa_assets.export import ExportResult, Form

ExportOut = Annotated[
    Path, typer.Option("--out", help=more(OUT_HELP, "a folder: missing, empty, or an earlier export."))
]
_SOURCE = typer.Argument(
    help="Library, or the folder of one asset in it.",
    exists=True,
    file_okay=False,
    readable=True,
    autocompletion=complete_assets,
)
Source = Annotated[Path | None, _SOURCE]
SCENES = Path("out/scenes")  # where finishes are found that the id of a scene has as a digest alone
COUNT = 4  # members of each category that the command for missing objects makes
States = Annotated[
    Path | None,
    typer.Option(help="Folder of scenes whose start states (scenes states) are written too.", file_okay=False),
]
app = group_of("export", "Libraries and kitchens in the form that another program reads.")


def export_as(
    form: Form,
    word: str,
    source: Path | None,
    scenes: list[str],
    out: Path,
    jobs: int,
    with_review: bool,
    output: Output,
) -> None:
    """Write a library, an asset or kitchens in a form, called so in a sentence; exits with 1 where one was refused."""
    from casa_assets.export import export_assets, export_scenes

    if (source is None) == (not scenes):
        raise typer.BadParameter("give either a library or an asset's folder, or --scenes")
    if source is not None:
        rows = export_assets(form, source, out, with_review)
    else:
        rows = export_scenes(form, scenes, out, jobs)
    results = _ended(rows, output)
    known = folders_by_id(source) if output.as_json and source is not None else {}
    for result in results:
        measured = {name: result.facts[name] for name in measures(None) if name in result.facts}
        row = {"id": result.id, form.name: result.file, "message": result.message}
        row |= measured or measures_at(known.get(result.id))
        status = "exported" if result.file else "left_out" if result.is_left_out else "refused"
        output.row({"status": status, "verdict": status, "folder": str(out) if result.file else "", **row})
    if not output.as_json:
        _print_results(results, out, "asset" if source is not None else "kitchen", word, output)
        look([result.id for result in results if result.file], source, output)
    if not all(result.file or result.is_left_out for result in results):
        raise typer.Exit(1)


def _ended(running: Generator[Any, None, None], output: Output) -> list[Any]:
    """Let an export run to its end under a bar, which counts results of each kind; all of them."""
    results: list[Any] = []
    counts: Counter[type] = Counter()
    with bar(output.console) as progress, closing(running):
        task = progress.add_task("reading", total=None)
        for result in running:
            results.append(result)
            counts[type(result)] += 1
            progress.update(task, total=result.total, completed=counts[type(result)], description=safe(result.id))
    return results


def look(ids: Sequence[str], source: Path | None, output: Output) -> None:
    """Print the command that shows the first exported asset of a library or a folder, or kitchen without a source."""
    from casa_assets.library.entry_files import CERTIFICATE

    if not ids:
        return
    if source is None:
        output.look(ids[0])
    elif (source / CERTIFICATE).is_file():
        output.look(source)
    else:
        output.look(ids[0], "--library", source)


def folders_by_id(source: Path) -> dict[str, Path]:
    """Folders of the accepted assets of a library, or the folder of one asset, by id."""
    from casa_assets.library.entry_files import CERTIFICATE
    from casa_assets.library.library import Library

    if (source / CERTIFICATE).is_file():
        return {source.name: source}
    return {folder.name: folder for folder in Library(source).accepted()}


def _print_results(results: Sequence[ExportResult], out: Path, what: str, word: str, output: Output) -> None:
    for result in results:
        if result.file:
            output.detail(f"exported {terminal_safe(result.id)}: {result.file}")
        elif result.is_left_out:
            output.line(f"left out {terminal_safe(result.id)}: {terminal_safe(result.message)}")
        else:
            output.wrong(f"refused {terminal_safe(result.id)}: {terminal_safe(result.message)}")
    written = [result for result in results if result.file]
    if not written:
        output.error("nothing was written")
        return
    place = terminal_safe(str(out))
    output.line(f"{pluralize(len(written), what)} as {word}; read {place}/README.md for how to load them")


@shared
def glb(
    output: Output,
    out: ExportOut,
    source: Source = None,
    scenes: Kitchens = None,
    jobs: Jobs = 0,
    with_review: WithReview = False,
    layers: Annotated[
        bool, typer.Option("--layers", help="Put collision shapes and regions into the files, too.")
    ] = False,
) -> None:
    """Write assets or kitchens as GLB, which browsers and Blender show.

    Exit 0 when all were written, 1 where one was refused, 2 on misuse.

    Examples:

      casa-assets export glb out/library --out out/glb       # a whole library
      casa-assets export glb out/library/mug/mug_0a1b2c3d4e --out one
      casa-assets export glb --scenes l_small__coastal --out kitchens
      casa-assets export glb lib --out all --layers          # collision shapes
    """
    from casa_assets.export import glb_form

    export_as(glb_form(layers), "GLB", source, scenes or [], out, jobs, with_review, output)


@shared
def urdf(
    output: Output,
    out: ExportOut,
    source: Source = None,
    scenes: Kitchens = None,
    jobs: Jobs = 0,
    with_review: WithReview = False,
) -> None:
    """Write assets or kitchens as URDF and compare what is read back.

    Exit 0 when all were written, 1 where one was refused, 2 on misuse.

    Examples:

      casa-assets export urdf out/library --out out/urdf     # a whole library
      casa-assets export urdf --scenes 'l_small__*' --out kitchens
      casa-assets export urdf lib --out urdf --json > rows.jsonl
    """
    from casa_assets.export import URDF

    export_as(URDF, "URDF", source, scenes or [], out, jobs, with_review, output)


@shared
def plugin(
    output: Output,
    name: Annotated[str, typer.Argument(help="Name of the exporter.")],
    source: Annotated[Path, _SOURCE],
    out: ExportOut,
    with_review: WithReview = False,
) -> None:
    """Write assets in a form that a plug-in adds.

    Exit 0 when all were written, 1 where one was refused or the plug-in failed on it, 2 on misuse.

    Example:  casa-assets export plugin blocks out/library --out out/blocks --plugins
    """
    from casa_assets.export import form_of

    export_as(form_of(name), name, source, [], out, 1, with_review, output)


@shared
def robocasa(
    output: Output,
    source: Annotated[
        Path | None,
        typer.Argument(
            metavar="LIBRARY", help=LIBRARY_HELP, exists=True, file_okay=False, readable=True, show_default=False
        ),
    ] = None,
    out: ExportOut = ...,  # type: ignore[assignment]
    scenes: Kitchens = None,
    registry: Annotated[str, typer.Option(help="Name of the object registry, and of the folder below objects/.")] = (
        "casa"
    ),
    jobs: Jobs = 0,
    with_review: WithReview = False,
    states: States = None,
) -> None:
    """Write loose objects of a library, and kitchens, as RoboCasa reads them.

    Objects are for v0.2 and v1.0, kitchens for v1.0. A kitchen that cannot be built is reported, and the others are
    written. With a library it also says which of the 65 atomic tasks of v1.0 can be reset with its objects, and which
    command makes what the others lack. Exit 0 when all were written, 1 where one was refused, 2 on misuse; after 2, or
    3 for a fault of the program, OUT is as it was.

    Examples:

      casa-assets export robocasa out/library --out out/robocasa
      casa-assets export robocasa lib --out ours --registry acme
      casa-assets export robocasa lib --out ours --json > rows.jsonl
      casa-assets export robocasa lib --scenes 'l_small__*' --out ours
    """
    from casa_assets.addons.robocasa.run import KitchenResult, export, report_tasks
    from casa_assets.layouts.run.recipe import recipes_named

    if source is None and not scenes:
        raise typer.BadParameter("give a library, --scenes, or both")
    recipes = recipes_named(scenes or [], states or SCENES)
    done = _ended(export(source, out, registry, recipes, jobs, with_review, states), output)
    kitchens = [result for result in done if isinstance(result, KitchenResult)]
    results = [result for result in done if not isinstance(result, KitchenResult)]
    _print_json(results, kitchens, out, folders_by_id(source) if output.as_json and source else {}, output)
    if not output.as_json:
        _print_objects(results, out, output)
        _print_kitchens(kitchens, out, output)
    if source is not None:
        _print_tasks(report_tasks(results), source, output)
    if built := [kitchen.id for kitchen in kitchens if not kitchen.message]:
        output.look(built[0])
    else:
        look([result.id for result in results if result.model], source, output)
    if any(kitchen.message for kitchen in kitchens):
        raise typer.Exit(1)


def _print_json(
    results: list[ExportedObject], kitchens: list[KitchenResult], out: Path, known: dict[str, Path], output: Output
) -> None:
    for result in results:
        row = {**vars(result), **measures_at(known.get(result.id))}
        del row["total"]
        status = "exported" if result.model else "left_out"
        output.row({"status": status, "verdict": status, "folder": str(out) if result.model else "", **row})
    for kitchen in kitchens:
        if kitchen.message:
            refused = {"status": "refused_kitchen", "verdict": "refused", "folder": ""}
            output.row({**refused, **measures(None), "id": kitchen.id, "message": kitchen.message})
        else:
            written = {"status": "exported_kitchen", "verdict": "exported", "folder": str(out)}
            facts = {name: getattr(kitchen, name) for name in ("id", "number", "fixtures", "tasks")}
            output.row({**written, **kitchen.measured, **facts})


def _print_kitchens(kitchens: list[KitchenResult], out: Path, output: Output) -> None:
    for kitchen in kitchens:
        count = sum(kitchen.fixtures.values())
        if kitchen.message:
            output.wrong(f"refused {kitchen.id}: {terminal_safe(kitchen.message)}")
        else:
            tasks = pluralize(len(kitchen.tasks), "atomic task")
            output.line(f"kitchen {kitchen.id}: {count} fixtures, enough for {tasks}; number {kitchen.number}")
    if written := [kitchen for kitchen in kitchens if not kitchen.message]:
        place = terminal_safe(str(out))
        output.line(f"{pluralize(len(written), 'kitchen')}; read {place}/README.md for how to open them")


def _print_tasks(report: TaskReport, library: Path, output: Output) -> None:
    """Which tasks can be reset with the objects; for the others what is missing, and the command that makes it."""
    command = ""
    if report.build:
        words = ["casa-assets", "objects", "build", *report.build, "--count", str(COUNT), "--library", str(library)]
        command = shlex.join(words)
    if output.as_json:
        row = {"id": "robocasa_v1", "status": "tasks", "verdict": "tasks", "folder": "", **measures(None)}
        missing = {task: list(draws) for task, draws in report.missing.items()}
        output.row({**row, "can_be_reset": list(report.can_be_reset), "missing": missing, "command": command})
        return
    able, every = len(report.can_be_reset), len(report.can_be_reset) + len(report.missing)
    output.line(f"{able} of the {every} atomic tasks of RoboCasa v1.0 can be reset with these objects alone")
    table = TextTable(("missing object", "for"), sentences=("for",))
    for draw in dict.fromkeys(draw for draws in report.missing.values() for draw in draws):
        table.add(draw, ", ".join(task for task, draws in report.missing.items() if draw in draws))
    table.print(output.console)
    if command:
        output.line(f"Make what is missing, then export again: {terminal_safe(command)}")


def _print_objects(results: list[ExportedObject], out: Path, output: Output, max_rows: int = 40) -> None:
    if not results:
        return
    written = [result for result in results if result.model]
    table = TextTable(("category", "train", "test"), right=("train", "test"))
    counts = Counter((result.category, result.split) for result in written)
    kinds = sorted({result.category for result in written})
    shown = kinds if output.verbose else kinds[:max_rows]
    for kind in shown:
        table.add(kind, str(counts[kind, "train"] or ""), str(counts[kind, "test"] or ""))
    if len(kinds) > len(shown):
        table.add(f"... and {len(kinds) - len(shown)} more", "", "")
    table.print(output.console)
    for result in results:
        if not result.model:
            output.line(f"left out {terminal_safe(result.id)}: {terminal_safe(result.message)}")
        else:
            output.detail(f"exported {terminal_safe(result.id)}: {result.model}")
    message = f"{pluralize(len(written), 'object')} in {pluralize(len(kinds), 'category')}"
    output.line(f"{message}; read {terminal_safe(str(out))}/README.md for how to add them")


for verb in (glb, robocasa, urdf, plugin):
    app.command(cls=Verb)(verb)
