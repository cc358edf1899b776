"""casa-assets check, checks, doctor, review, categories, schemas: what fails, what is missing, what is known."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.text import Text

from casa_assets.cli.group import Verb, group_of
from casa_assets.cli.options import (
    LIBRARY_HELP,
    OUT_HELP,
    AsJson,
    Browser,
    Port,
    complete_categories,
    complete_things,
    library_at,
    more,
    shared,
)
from casa_assets.cli.output import Output, TextTable, from_column, measures_at, pluralize

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from casa_assets.cli.doctor import Finding
    from casa_assets.model.registry.category import Category, SizeRange

PACKAGE, RENDERER = "package ", "renderer "
SUBJECT_WIDTH = 16
# Consequences for a subject for which a check fails.
EFFECTS = {
    "error": "error: what fails is kept out of the library",
    "warning": "warning: advice that is kept with the asset",
    "rejection": "rejection: the input was not taken",
}
categories = group_of(
    "categories", "Categories of things: usual size and mass, substance, other names, what builds them: list, show."
)


@shared
def check(
    output: Output,
    folders: Annotated[
        list[Path],
        typer.Argument(
            help="Folders of assets or kitchens.", exists=True, file_okay=False, autocompletion=complete_things
        ),
    ],
) -> None:
    """Run every check that applies on assets or kitchens in their folders; nothing is written.

    It finds what was changed by hand since they were made. `checks CODE` explains a code. Exit 0 when all pass, 1 when
    one does not, 2 on misuse.

    Example:  casa-assets check out/library/mug/mug_0123456789
    """
    from casa_assets.api.assets import check_folder

    failed = False
    for folder in folders:
        report = check_folder(folder)
        failed |= not report.passed
        verdict = "passed" if report.passed else "failed"
        facts = report.model_dump(mode="json", exclude={"subject"})
        output.made(report.subject, folder, measures_at(folder), verdict, **facts)
        for result in report.results if not output.as_json else ():
            number = result.reason if result.number is None else f"{result.number:.4g} {result.unit}".rstrip()
            output.detail(f"{result.code} {result.status.value}: {number}".removesuffix(": "))
        say = output.line if report.passed else output.wrong
        for issue in report.issues if not output.as_json else ():
            word = "advice" if issue.severity.value == "warning" else "error"
            say(f"{word} {issue.code} {issue.pointer}: {issue.message}")
        if not output.as_json:
            say(f"{verdict} {report.subject}: {report.tally}")
    if failed:
        raise typer.Exit(1)


@shared
def doctor(
    output: Output,
    out: Annotated[
        Path, typer.Option("--out", help=more(OUT_HELP, "this folder is tested, nothing stays in it."))
    ] = Path("out"),
) -> None:
    """Test this machine (Python, packages, rendering, disk), and print the command that installs what is missing.

    Exit 0 when all that is needed is here, 1 when something is missing, 2 on misuse. What is optional and missing is a
    note, and does not change the exit code.

    Example:  casa-assets doctor --verbose
    """
    from casa_assets.cli.doctor import findings

    found = findings(out)
    missing = [finding for finding in found if finding.needed and not finding.ok]
    for finding in found:
        verdict = "passed" if finding.ok else "failed" if finding.needed else "note"
        output.row({"id": finding.subject, "verdict": verdict, **finding.model_dump(mode="json")})
    if not output.as_json:
        _print_findings(found, output)
    if missing:
        output.wrong(f"Needed and missing: {', '.join(finding.subject for finding in missing)}.")
        raise typer.Exit(1)
    output.line("Everything that is needed is here.")


def _print_findings(found: Sequence[Finding], output: Output) -> None:
    """Print what is wrong, then what else there is to say; optional packages and those that are here on a line each."""
    draws = any(f.ok for f in found if f.subject.startswith(RENDERER))
    wrong = [finding for finding in found if finding.needed and not finding.ok]
    rest = [finding for finding in found if finding not in wrong]
    packages = [finding for finding in rest if finding.subject.startswith(PACKAGE)]
    for finding in wrong:
        _print_finding(finding, output)
    if output.verbose:
        for finding in rest:
            _print_finding(finding, output)
        return
    # Where one renderer draws, there is nothing to say of single ones.
    shown = [f for f in rest if f not in packages and not (draws and f.subject.startswith(RENDERER))]
    for finding in (one for one in shown if not one.ok):
        _print_finding(finding, output)
    if names := [finding.subject.removeprefix(PACKAGE) for finding in packages if not finding.ok]:
        words = f"optional, not installed or of another version: {', '.join(names)}; --verbose says more"
        output.console.print(_line("note", "yellow", "packages", words), soft_wrap=True, highlight=False)
    if here := sum(finding.ok for finding in packages):
        output.console.print(_line("ok", "green", "packages", f"{here} are here"), highlight=False)
    for finding in (one for one in shown if one.ok):
        _print_finding(finding, output)


def _print_finding(finding: Finding, output: Output) -> None:
    mark = ("ok", "green") if finding.ok else ("MISSING", "bold red") if finding.needed else ("note", "yellow")
    fix = f"; run: {finding.fix}" if finding.fix and not finding.ok else ""
    line = _line(*mark, finding.subject.removeprefix(PACKAGE), f"{finding.message}{fix}")
    console = output.failures if finding.needed and not finding.ok else output.console
    console.print(line, soft_wrap=True, highlight=False)


def _line(mark: str, style: str, subject: str, words: str) -> Text:
    return Text.assemble((f"{mark:8}", style), f"{subject:{SUBJECT_WIDTH}}  ", words)


def review(
    library: Annotated[Path, typer.Argument(help=LIBRARY_HELP, exists=True, file_okay=False)] = Path("out/library"),
    port: Port = 0,
    browser: Browser = True,
) -> None:
    """Open a page on which you decide about assets in review: accept, reject, correct category, pose, size and mass.

    Each decision is written to review.csv of the library at once; the next `casa-assets ingest` applies it. Articulated
    meshes have a page of their own, on which parts are corrected too; `casa-assets articulate` applies review.json,
    which that page writes. Only this machine can open the pages; Ctrl-C ends them.
    Exit 0 when nothing is left to decide, 2 on misuse, 130 after Ctrl-C.

    Example:

      casa-assets review out/library
    """
    from casa_assets.errors import OutputError
    from casa_assets.runs.outcome import writing
    from casa_assets.show.view.review import ARTICULATED, ReviewServer
    from casa_assets.show.view.server import open_in_browser

    console = Console(soft_wrap=True, highlight=False)
    place = library_at(library)
    with writing(library):
        try:
            server = ReviewServer(place, port)
        except OverflowError as error:
            raise OutputError(str(port), "is no port; give one from 1024 to 65535") from error
        with server:
            pages = []
            if server.waiting:
                console.print(f"{pluralize(len(server.waiting), 'input')} to decide about: {server.address}")
                pages.append(server.address)
            if server.articulated:
                pages.append(f"{server.address}{ARTICULATED}")
                console.print(f"{pluralize(len(server.articulated), 'articulated mesh')}: {pages[-1]}")
            if not pages:
                console.print("nothing is in review")
                return
            console.print("Ctrl-C ends it; then run the same command on the same sources again")
            for page in pages if browser else ():
                open_in_browser(page)
            server.serve_forever()


def checks(
    codes: Annotated[
        list[str] | None, typer.Argument(help="Codes of reports, such as USD002; none: all checks.")
    ] = None,
    as_markdown: Annotated[
        bool, typer.Option("--markdown", help="Print Markdown, as in docs/reference/checks.md.")
    ] = False,
    json_: AsJson = False,
) -> None:
    """List every check, or explain codes of a report: what is tested, its limit, and what to do when it fails.

    Exit 0 when it is printed, 2 when there is no such code.

    Examples:

      casa-assets checks
      casa-assets checks USD002 FLT005
    """
    from casa_assets.errors import UnknownId
    from casa_assets.show.reports.checks_page import check_facts, checks_markdown, every_code

    if as_markdown:
        typer.echo(checks_markdown(), nl=False)
        return
    known = every_code() if codes else {}
    wanted = [code.upper() for code in codes or ()]
    for code in wanted:
        if code not in known:
            raise UnknownId("code", code, known, "`casa-assets checks` lists them")
    output = Output(json_)
    found = [known[code] for code in wanted] or list(check_facts())
    for facts in found:
        row = asdict(facts)
        output.row({"id": row.pop("code"), **row})
    if json_:
        return
    about = "what is tested, and what to do"
    table = TextTable(("code", "title", "severity", "limit", about), sentences=("title", about))
    for facts in found:
        limit = "" if facts.limit is None else f"{facts.limit:g} {facts.unit}".strip()
        if not wanted:
            table.add(facts.code, facts.title, facts.severity, limit, facts.about)
            continue
        output.line(f"{facts.code}  {facts.title}")
        for name, words in {"severity": EFFECTS[facts.severity], "looks at": facts.subject, "limit": limit}.items():
            if words:
                output.line(f"  {name + ':':10} {words}")
        output.line(f"  {facts.about}")
    table.print(output.console)


def schemas(
    name: Annotated[
        str,
        typer.Argument(
            help="scene, scene_report, asset, behavior, plan or style; none: list them.", show_default=False
        ),
    ] = "",
    json_: AsJson = False,
) -> None:
    """Print the JSON Schema of scene.json, asset.json, behavior.json, the report.json of a kitchen, a plan or a style.

    With --json each is one line, with the file that it describes. Exit 0 when it is printed, 2 when there is no schema
    of this name.

    Example: casa-assets schemas scene > scene.schema.json
    """
    from casa_assets.api.schemas import SCHEMAS, schema_text, title_of

    output = Output(json_)
    for known in (name,) if name else SCHEMAS:
        text = schema_text(known)  # raises UnknownId
        output.row({"id": known, "file": title_of(known), "schema": json.loads(text)})
        if not json_:
            typer.echo(text if name else known, nl=not name)


@categories.command("list", cls=Verb)
def list_categories(json_: AsJson = False) -> None:
    """List every category with its class, usual size and mass, and what builds it.

    First those that `ingest` assigns to meshes, then those of fixtures, which families build. Exit 0.

    Example:  casa-assets categories list
    """
    output, builders = Output(json_), _builders()
    heads = ("longest, m", "mass, kg")
    table = TextTable(("category", "class", *heads, "built by", *from_column()), right=heads, sentences=("built by",))
    for category in _all().values():
        row = _row(category, builders.get(category.id, ()))
        output.row(row)
        usual = (f"{category.longest_m.typical:g}", f"{category.mass_kg.typical:g}")
        table.add(category.id, category.parent, *usual, ", ".join(row["built_by"]), row["from"])
    if not json_:
        table.print(output.console)
        output.line(pluralize(len(table.rows), "category"))


@categories.command(cls=Verb)
def show(
    names: Annotated[list[str], typer.Argument(help="Ids of categories.", autocompletion=complete_categories)],
    json_: AsJson = False,
) -> None:
    """Print what is known of categories: usual size and mass, substance, other names, what builds them.

    Exit 0 when there are such categories, 2 when there are not.

    Example:  casa-assets categories show mug microwave
    """
    from casa_assets.errors import UnknownId

    output, known, builders = Output(json_), _all(), _builders()
    for name in names:
        if name not in known:
            raise UnknownId("category", name, known)
    for name in names:
        row = _row(known[name], builders.get(name, ()))
        output.row(row)
        if not json_:
            _print_category(row, output)


def _all() -> Mapping[str, Category]:
    from casa_assets import registry

    known = registry.load()
    return {**known.categories, **known.fixtures}


def _builders() -> dict[str, tuple[str, ...]]:
    """Category -> commands that build one: of families, and of objects by their form."""
    from casa_assets.registry.families import families, object_names

    found: dict[str, tuple[str, ...]] = {}
    for made in families().values():
        found[made.category] = (*found.get(made.category, ()), f"families build {made.name}")
    for name in object_names():
        found[name] = (*found.get(name, ()), f"objects build {name}")
    return found


def _row(category: Category, builders: tuple[str, ...]) -> dict[str, Any]:
    from casa_assets import registry
    from casa_assets.registry.read import origin_of_row
    from casa_assets.registry.tables import look_alikes

    table = "categories.yaml" if category.id in registry.load().categories else "fixtures.yaml"
    kinds = look_alikes()
    kind = kinds.get(category.id)
    size = category.extents
    return {
        "id": category.id,
        "class": category.parent,
        "classes": [name for name in registry.load().classes_of(category) if name != category.id],
        "size": [side.typical for side in size],
        "size_low": [side.low for side in size],
        "size_high": [side.high for side in size],
        "longest": _range(category.longest_m),
        "mass": category.mass_kg.typical,
        "mass_range": _range(category.mass_kg),
        "substance": category.substance,
        "build": category.build.value,
        "rests": category.upright.value,
        "fixed": category.fixed,
        "affords": [use.value for use in category.affords],
        "aliases": list(category.aliases),
        "lvis": list(category.lvis),
        "looks_like": sorted(name for name, other in kinds.items() if kind and other == kind and name != category.id),
        "basis": {"size": category.basis.size.value, "mass": category.basis.mass.value},
        "built_by": list(builders),
        "from": origin_of_row(table, category.id),
    }


def _range(span: SizeRange) -> list[float]:
    return [span.low, span.typical, span.high]


def _print_category(row: dict[str, Any], output: Output) -> None:
    size = " x ".join(f"{value:.3g}" for value in row["size"])
    low, _, high = row["longest"]
    light, _, heavy = row["mass_range"]
    lines = {
        "class": " > ".join(row["classes"]),
        "size": f"{size} m, as it rests; longest side {low:g} to {high:g} m ({row['basis']['size']})",
        "mass": f"{row['mass']:g} kg; {light:g} to {heavy:g} kg ({row['basis']['mass']})",
        "substance": f"{row['substance']}, {row['build']}",
        "rests": row["rests"] + (", fixed to the building" if row["fixed"] else ""),
        "affords": ", ".join(row["affords"]),
        "other names": ", ".join(row["aliases"]),
        "looks like": ", ".join(row["looks_like"]),
        "built by": ", ".join(f"casa-assets {command}" for command in row["built_by"]),
        "from": row["from"] if from_column() else "",
    }
    output.line(row["id"])
    for name, words in lines.items():
        if words:
            output.line(f"  {name + ':':12} {words}")
