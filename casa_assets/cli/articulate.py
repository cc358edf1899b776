"""casa-assets articulate: one static mesh of an appliance or cabinet into one that opens."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from casa_assets.cli.words import plain

if TYPE_CHECKING:
    from casa_assets.pipeline.articulate import Done

AXES = {"x": 0, "y": 1, "z": 2}


def articulate(
    mesh: Annotated[Path, typer.Argument(help="OBJ, GLB, glTF, PLY, STL or DAE of one thing.", exists=True)],
    out: Annotated[Path, typer.Option(help="Output folder, made where it is missing.")] = Path("out/articulated"),
    category: Annotated[str, typer.Option(help="What it is, such as microwave; else its name decides.")] = "",
    up: Annotated[str, typer.Option(help="Axis of the file that points up, such as +z; else it is guessed.")] = "",
    front: Annotated[str, typer.Option(help="Axis of the file that the front faces, such as -y.")] = "",
    size: Annotated[float, typer.Option(min=0, help="Longest side in metres; 0: by unit and category.")] = 0.0,
    report: Annotated[bool, typer.Option("--report", help="Print every part with confidence and runner-up.")] = False,
) -> None:
    """Find doors, drawers, knobs and buttons of a static mesh and write it as MJCF and USD that open.

    Exit 0 when something moves, 1 when no moving part was found or the mesh cannot be read, 2 on misuse.

    Example:  casa-assets articulate microwave.obj
    """
    from casa_assets.pipeline.articulate import Wish
    from casa_assets.pipeline.articulate import articulate as run

    console = Console()
    done = run(Wish(mesh, out, category, _axis(up), _axis(front), size))
    if done.found is None:
        console.print(f"[red]{done.code}[/] {escape(plain(done.says))}", highlight=False)
        raise typer.Exit(1)
    count = len(done.found.parts)
    console.print(f"[green]{count} moving part{'s' if count != 1 else ''}[/]: {done.folder}", highlight=False)
    if report:
        console.print(_table(done))


def _axis(word: str) -> tuple[float, float, float] | None:
    """A direction from such words as `+z`, `-y`, `x`. Raises typer.BadParameter."""
    if not word:
        return None
    sign, name = (-1.0 if word.startswith("-") else 1.0), word.lstrip("+-").lower()
    if name not in AXES:
        raise typer.BadParameter(f"{word!r}: one of +x, -x, +y, -y, +z, -z")
    x, y, z = (sign if AXES[name] == i else 0.0 for i in range(3))
    return (x, y, z)


def _table(done: Done) -> Table:
    assert done.found is not None
    frame = done.found.frame
    title = f"frame: {frame.confidence:.0%} sure ({frame.because}); next: {frame.runner_up}; size: {done.size}"
    table = Table("part", "on", "joint", "sure", "because", "else", title=escape(title), title_justify="left")
    for part in done.found.parts:
        joint = part.joint
        how = joint.kind.value + (f" {joint.edge.value}" if joint.edge else "")
        because = "; ".join(w for w in (part.because, joint.because) if w)
        table.add_row(part.name, part.parent or "body", how, f"{part.confidence:.0%}", because, joint.runner_up)
    return table
