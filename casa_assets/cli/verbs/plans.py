"""casa-assets scenes check-plan and fit: plans looked at, mended and fitted to a room, without building anything."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from casa_assets.cli import completion
from casa_assets.cli.options import OUT_HELP, more, shared
from casa_assets.cli.output import Output, pluralize

if TYPE_CHECKING:
    from casa_assets.layouts.check_plan.check import PlanCheck

STYLE = "modern_1"


def plan_file(named: Path) -> Path:
    """The file of a plan that a user names: by its path, or as `scenes list` does. Raises UnknownId."""
    from casa_assets.errors import UnknownId
    from casa_assets.registry.kitchens import PLANS, plan_names
    from casa_assets.registry.read import stated_in

    if named.is_file():
        return named
    if str(named) not in plan_names():
        raise UnknownId("plan or file", str(named), plan_names(), "`casa-assets scenes list` names the plans")
    return stated_in(f"{PLANS}/{named}.yaml")[-1]


PlanFile = Annotated[
    Path,
    typer.Argument(
        help="A plan: a YAML file, or the name of one, see `scenes list`.",
        callback=plan_file,
        autocompletion=completion.plans,
    ),
]
TriedStyle = Annotated[
    str,
    typer.Option(
        "--style",
        help="Name of a style, see `scenes list`; the plan is tried with it.",
        autocompletion=completion.styles,
    ),
]
OutFile = Annotated[
    Path | None, typer.Option("--out", help=more(OUT_HELP, "a YAML file that is not there yet."), dir_okay=False)
]


@shared
def check_plan(
    output: Output,
    file: PlanFile,
    style: TriedStyle = STYLE,
    fix: Annotated[bool, typer.Option("--fix", help="Write the corrected plan to --out.")] = False,
    out: OutFile = None,
) -> None:
    """Check a plan without building it: every fault with its line, and the nearest correction.

    Make corrections in the order in which they are printed. --json has them as edits: op, pointer, old and new
    value. Exit 0 when the plan fits, 1 when it has faults, 2 on misuse.

    Example:  casa-assets scenes check-plan studio.yaml --fix --out studio_2.yaml
    """
    from casa_assets.layouts.check_plan.check import check_plan as check
    from casa_assets.layouts.check_plan.edit import read_plan_text, write_new
    from casa_assets.registry.kitchens import load_style

    if fix != (out is not None):
        raise typer.BadParameter("--fix and --out go together: name a file for the corrected plan")
    found = check(read_plan_text(file), str(file), load_style(style)[0])
    output.row(
        {
            "id": file.stem,
            "verdict": "fits" if found.fits else "faulty",
            "file": str(file),
            "style": style,
            "mended": found.mended,
            "faults": [told.facts for told in found.faults],
        }
    )
    if not output.as_json:
        _print(found, file, output)
    if out is not None and found.mended:
        write_new(out, found.text)
        output.line(f"{out}: {pluralize(len(found.faults), 'correction')} made")
    if not found.fits:
        raise typer.Exit(1)


def _print(found: PlanCheck, file: Path, output: Output) -> None:
    for told in found.faults:
        pointer = ".".join(map(str, told.pointer)) or "(top)"
        output.wrong(f"{told.file}:{told.line}: {pointer}: expected {told.expected}, got {told.got}")
        output.wrong(f"    correction: {told.mend.sentence if told.mend else 'none was found'}")
    if found.fits:
        output.line(f"{file}: fits")
        return
    after = "with these corrections it fits" if found.mended else "what has no correction has to be rewritten"
    output.wrong(f"{pluralize(len(found.faults), 'fault')}; {after}")


@shared
def fit(
    output: Output,
    file: PlanFile,
    width: Annotated[float, typer.Option(help="Of the room, along its back wall, metres.", min=1.5, max=20)],
    depth: Annotated[
        float, typer.Option(help="Of the room, from its back wall to its front, metres.", min=1.5, max=20)
    ],
    style: TriedStyle = STYLE,
    out: OutFile = None,
) -> None:
    """Fit a plan to a room of another size: move walls and openings, then narrow or take out what does not fit.

    Shelves, fillers and doors go before drawers; sink, cooker and refrigerator stay. Prints each change, and the plan
    where no --out names a file. Exit 0 when the plan fits, 1 when the room is too small (the least room that is
    not is printed), 2 on misuse.

    Example:  casa-assets scenes fit studio.yaml --width 4.2 --depth 3.1 --out small.yaml
    """
    from casa_assets.layouts.check_plan.check import DoesNotFit, fit_plan
    from casa_assets.layouts.check_plan.edit import read_plan_text, write_new
    from casa_assets.registry.kitchens import load_style

    row = {"id": file.stem, "file": str(file), "style": style, "width": width, "depth": depth}
    try:
        fitted = fit_plan(read_plan_text(file), str(file), load_style(style)[0], width, depth)
    except DoesNotFit as error:
        output.row({**row, "verdict": "refused", "reason": error.reason, "least": error.least})
        output.wrong(str(error))
        raise typer.Exit(1) from None
    output.row({**row, "verdict": "fits", "changes": fitted.changes, "plan": fitted.text})
    for change in () if output.as_json else fitted.changes:
        output.line(f"# {change}")
    if out is not None:
        write_new(out, fitted.text)
        output.line(f"{out}: {pluralize(len(fitted.changes), 'change')}")
    elif not output.as_json:
        typer.echo(fitted.text, nl=False)
