"""The verb `casa-assets articulate`: turn static meshes of appliances or cabinets into ones that open."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from casa_assets.cli.options import Force, OldForce, OldSizeM
from casa_assets.cli.text import pluralize, terminal_safe
from casa_assets.errors import BatchFault

if TYPE_CHECKING:
    from collections.abc import Sequence

    from casa_assets.articulate.decisions import Decisions
    from casa_assets.model.record import Vec3
    from casa_assets.pipeline.articulate.run import ArticulateOutcome


def articulate(
    meshes: Annotated[
        list[Path],
        typer.Argument(
            metavar="MESH...", help="OBJ, GLB, glTF, PLY, STL or DAE, each of one thing.", exists=True, dir_okay=False
        ),
    ],
    out: Annotated[Path, typer.Option(help="Library to write to, made where it is missing.")] = Path("out/articulated"),
    category: Annotated[str, typer.Option(help="What it is, such as microwave; else its name, then its shape.")] = "",
    up: Annotated[str, typer.Option(help="Axis of the file that points up, such as +z; else it is guessed.")] = "",
    front: Annotated[str, typer.Option(help="Axis of the file that the front faces, such as -y.")] = "",
    size_m: Annotated[float, typer.Option(min=0, help="Longest side in metres; 0: by unit and category.")] = 0.0,
    decisions: Annotated[
        Path | None,
        typer.Option(help="The decisions.yaml of an earlier run, changed by hand.", exists=True, dir_okay=False),
    ] = None,
    preview: Annotated[bool, typer.Option("--preview", help="Write strip.png: closed, coloured, apart, open.")] = False,
    report: Annotated[bool, typer.Option("--report", help="Print every part with confidence and runner-up.")] = False,
    review: Annotated[bool, typer.Option("--review", help="Write review.html with the strips of all meshes.")] = False,
    clip: Annotated[
        Path | None,
        typer.Option(help="Weights of CLIP (open_clip), which then name what --category does not.", exists=True),
    ] = None,
    complete: Annotated[bool, typer.Option(help="Build an interior where a door or drawer opens onto nothing.")] = True,
    force: Force = False,
    jobs: Annotated[int, typer.Option(min=1, help="Meshes at once.")] = 1,
    size: OldSizeM = 0.0,
    anew: OldForce = False,
) -> None:
    """Find doors, drawers, knobs and buttons of static meshes and write them as MJCF and USD that open.

    What an earlier run made of the same file with the same options is kept.
    Every decision stands in decisions.yaml beside the model: change a line and give the file back with --decisions.
    Exit 0 when all are in the library, 1 when something was rejected (nothing moves: ART001), 2 on misuse.

    Example:  casa-assets articulate microwave.obj --preview --report
    """
    from casa_assets.pipeline.articulate import review_page
    from casa_assets.pipeline.articulate.build import ArticulateRequest
    from casa_assets.pipeline.articulate.run import articulate as run

    given = _read_decisions(decisions, len(meshes))
    axes = _axis(up, "--up"), _axis(front, "--front")
    requests = [
        ArticulateRequest(
            m, out, category, *axes, size_m or size, given, preview or review, clip, complete, force or anew
        )
        for m in meshes
    ]
    console = Console()
    outcomes = []
    for outcome in run(requests, jobs):
        outcomes.append(outcome)
        _print_outcome(outcome, console)
        if report and outcome.articulation is not None:
            _print_parts(outcome, console)
    if review:
        console.print(f"{review_page.write(out, outcomes)}", highlight=False)
    _exit_with(outcomes)


def _exit_with(outcomes: Sequence[ArticulateOutcome]) -> None:
    """End with exit 3 after a fault of the program, 1 after a rejection; return where all were accepted."""
    from casa_assets.pipeline.ingest.run import CRASH_CODE

    if faults := [str(outcome.mesh) for outcome in outcomes if outcome.code == CRASH_CODE]:
        raise BatchFault(map(terminal_safe, faults))
    if not all(outcome.accepted for outcome in outcomes):
        raise typer.Exit(1)


def _read_decisions(path: Path | None, meshes: int) -> Decisions:
    """Read the decisions of a person, none where no file is given. Raises typer.BadParameter for more than one mesh."""
    from casa_assets.articulate.decisions import Decisions
    from casa_assets.pipeline.articulate.sidecar import read

    if path is None:
        return Decisions()
    if meshes > 1:
        raise typer.BadParameter("the decisions are those on one mesh", param_hint="--decisions")
    return read(path)


def _axis(word: str, option: str) -> Vec3 | None:
    """Return a direction from words such as `+z`, `-y`, `x`. Raises typer.BadParameter."""
    from casa_assets.articulate.decisions import parse_direction

    try:
        return parse_direction(word) if word else None
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint=option) from None


def _print_outcome(outcome: ArticulateOutcome, console: Console) -> None:
    """Print one line for the outcome of a mesh, and one for each warning."""
    name = escape(terminal_safe(outcome.mesh.name))
    if outcome.articulation is None:
        console.print(f"[red]{outcome.code}[/] {escape(terminal_safe(outcome.message))}", highlight=False)
        return
    count = sum(not p.added for p in outcome.articulation.parts)
    whole = sum(t.is_full for t in outcome.travels.values())
    cavities = sum(r.built for r in outcome.articulation.cavities)
    added = f", {pluralize(cavities, 'interior')} added" if cavities else ""
    reached = f"full range: {whole} of {pluralize(len(outcome.travels), 'joint')}"
    message = f"{pluralize(count, 'moving part')}, {reached}{added}"
    if outcome.accepted:
        mark = f"[green]{'kept' if outcome.kept else 'accepted'}[/]"
    else:
        mark = f"[red]{outcome.code}[/] {escape(terminal_safe(outcome.message))};"
    console.print(f"{mark} {name}: {message}", highlight=False)
    console.print(f"  {escape(terminal_safe(str(outcome.folder)))}", highlight=False, soft_wrap=True)
    if outcome.contract:
        console.print(f"  holds the contract {outcome.contract}", highlight=False)
    elif outcome.unmet_checks:
        more = f" (and {len(outcome.unmet_checks) - 2} more: --report)" if len(outcome.unmet_checks) > 2 else ""
        console.print(f"  {escape(terminal_safe(': '.join(outcome.unmet_checks[:2])))}{more}", highlight=False)
    for issue in outcome.report.issues if outcome.report else ():
        console.print(
            f"  {issue.severity.value} {issue.code} {escape(terminal_safe(issue.pointer + ' ' + issue.message))}",
            highlight=False,
        )


def _print_parts(outcome: ArticulateOutcome, console: Console) -> None:
    """Print the table of all parts, and what the contract of its kind asks for in vain."""
    console.print(_table(outcome))
    for line in outcome.unmet_checks:
        console.print(f"  {escape(terminal_safe(line))}", highlight=False)


def _table(outcome: ArticulateOutcome) -> Table:
    """Return the table of all parts with confidence and runner-up, for --report."""
    assert outcome.articulation is not None
    frame = outcome.articulation.frame
    title = f"{outcome.category}; size: {outcome.size}; frame: {frame.confidence:.0%} sure ({frame.reason})" + (
        f"; next: {frame.runner_up}" if frame.runner_up else ""
    )
    table = Table(
        "part", "on", "joint", "goes", "confidence", "reason", "else", title=escape(title), title_justify="left"
    )
    for part in outcome.articulation.parts:
        joint = part.joint
        how = joint.kind.value + (f" {joint.edge.value}" if joint.edge else "")
        way = outcome.travels.get(part.name)
        goes = (
            ""
            if way is None
            else "all"
            if way.is_full
            else f"{min(way.free_share, way.pushed_share):.0%} {way.blocked_by}"
        )
        table.add_row(
            part.name, part.parent or "body", how, goes, f"{part.confidence:.0%}", part.full_reason, joint.runner_up
        )
    for cavity in outcome.articulation.cavities:
        if cavity.built:
            table.add_row(
                f"+ {cavity.interior.value}", cavity.parts[0], "", "", f"{cavity.confidence:.0%}", cavity.reason, ""
            )
    return table
