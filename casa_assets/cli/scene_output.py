"""Print the output of the verbs on scenes: each scene as it is done, a table of numbers, counts at the end."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from casa_assets.cli.progress import bar
from casa_assets.cli.text import pluralize
from casa_assets.errors import BatchFault

if TYPE_CHECKING:
    from casa_assets.pipeline.kitchens.scene_folders import SceneResult

NAME_CHARACTERS = 40  # characters of a name that are kept on one line
WIDE_TERMINAL = 140  # characters that the whole table takes
NARROW_COLUMNS = 5  # columns of numbers where there is less room


def print_progress(
    running: Iterator[SceneResult], count: int, word: str, console: Console, json_: bool
) -> list[SceneResult]:
    """Print a line for each scene as it is done; returns all of them.

    Args:
        word: what is done with them, for the bar. console: for people. json_: one JSON object per scene on standard
            output.
    """
    results: list[SceneResult] = []
    with bar(console) as progress:
        task = progress.add_task(word, total=count)
        for result in running:
            results.append(result)
            progress.update(task, completed=len(results))
            if json_:
                typer.echo(json.dumps(_json_row(result), sort_keys=True))
            else:
                _print_scene(result, progress.console)
    return results


def write_reports(results: list[SceneResult], out: Path, console: Console) -> None:
    """Write page, contact sheet and table of the folder; print where they are and how many scenes were made."""
    from casa_assets.pipeline.ingest.job import writing
    from casa_assets.pipeline.reports import kitchens

    with writing(out):
        page, picture = kitchens.write(out)
    made = sum(r.passed for r in results)
    kept = sum(r.kept for r in results)
    message = f"{made} of {pluralize(len(results), 'scene')} in {out}"
    console.print(f"{message} ({kept} unchanged)", highlight=False, soft_wrap=True)
    for name, path in (("Pictures", picture), ("Page", page), ("Numbers", out / kitchens.SUMMARY_PAGE)):
        console.print(f"{name + ':':9} {path}", highlight=False, soft_wrap=True)


def check_faults(results: list[SceneResult]) -> None:
    """Raises BatchFault where some were not made or checked by a fault of the program."""
    faults = [r.recipe.scene_id for r in results if r.is_fault]
    if faults:
        raise BatchFault(faults)


def print_numbers(results: list[SceneResult], out: Path, console: Console) -> None:
    """Print numbers of the scenes of this run, as far as they are in the folder, and their sum."""
    from casa_assets.pipeline.reports.kitchens import COLUMNS, cells, read_rows, sentence

    mine = {r.recipe.scene_id for r in results if r.folder}
    found = [row for row in read_rows(out) if row.id in mine]
    if not found:
        return
    if not console.is_terminal:
        console.width = max(console.width, WIDE_TERMINAL)
    shown = COLUMNS if console.width >= WIDE_TERMINAL else COLUMNS[:NARROW_COLUMNS]
    table = Table(box=None, padding=(0, 1), header_style="bold")
    table.add_column("scene", overflow="fold", min_width=min(NAME_CHARACTERS, max(len(row.id) for row in found)))
    table.add_column("verdict", overflow="fold")
    for heading, _, _ in shown:
        table.add_column(heading, justify="right", min_width=max(map(len, heading.split())))
    for row in found:
        mark = "[green]passed[/]" if row.passed else f"[red]{escape(row.verdict)}[/]"
        table.add_row(row.id, mark, *cells(row)[: len(shown)])
    console.print(table, highlight=False)
    console.print(sentence(found), highlight=False, soft_wrap=True)


def print_robots(results: list[SceneResult], console: Console) -> None:
    """Print for each scene how many joints each robot reaches and opens."""
    from casa_assets.pipeline.kitchens.robots import read_certificate

    table = Table(box=None, padding=(0, 1), header_style="bold")
    for heading in ("scene", "robot", "reached", "followed", "of joints", "margin, median", "without a parking place"):
        table.add_column(heading, overflow="fold")
    for result in results:
        found = read_certificate(Path(result.folder)) if result.folder else None
        if found is None:
            continue
        for robot in found.robots:
            numbers = (robot.reached, robot.followed, len(robot.joints), robot.margin, len(found.without_parking))
            table.add_row(result.recipe.scene_id, robot.robot, *map(str, numbers))
    console.print(table, highlight=False)


def print_states(results: list[SceneResult], console: Console) -> None:
    """Print for each scene its start states: how many, the deepest contact, the farthest motion, what was refused."""
    from casa_assets.pipeline.kitchens.scene_files import START_STATES
    from casa_assets.pipeline.kitchens.state_file import read_states

    table = Table(box=None, padding=(0, 1), header_style="bold")
    for heading in ("scene", "states", "deepest contact, mm", "farthest motion, mm", "kB", "draws given up"):
        table.add_column(heading, overflow="fold")
    for result in results:
        if not result.folder or result.report is None:
            continue
        folder = Path(result.folder)
        found, size = read_states(folder), (folder / START_STATES).stat().st_size
        numbers = (f"{1000 * found.depth.max():.2f}", f"{1000 * found.motion.max():.2f}", f"{size / 1000:.0f}")
        refused = ", ".join(f"{reason}: {count}" for reason, count in found.refused.items()) or "none"
        table.add_row(result.recipe.scene_id, str(len(found)), *numbers, refused)
    console.print(table, highlight=False)


def _json_row(result: SceneResult) -> dict[str, object]:
    return {
        "id": result.recipe.scene_id,
        "folder": result.folder,
        "passed": result.passed,
        "kept": result.kept,
        "message": result.message,
        "issues": [{"code": i.code, "pointer": i.pointer, "message": i.message} for i in result.problems],
        "build_s": round(result.build_s, 3),
        "write_s": round(result.write_s, 3),
        "draw_s": round(result.draw_s, 3),
        "check_s": round(result.check_s, 3),
        **result.counts,
    }


def _print_scene(result: SceneResult, console: Console) -> None:
    if result.kept and result.passed:
        console.print(f"[green]kept[/] [bold]{result.recipe.scene_id}[/]", soft_wrap=True)
        return
    mark = "[red]failed[/]" if not result.passed else "[green]made[/]" if result.report is None else "[green]passed[/]"
    seconds = f"build {result.build_s:.1f} s, write {result.write_s:.1f} s, draw {result.draw_s:.1f} s"
    if result.report is not None:
        seconds += f", check {result.check_s:.1f} s"
    console.print(f"{mark} [bold]{result.recipe.scene_id}[/] ({seconds})", highlight=False, soft_wrap=True)
    if result.message:
        console.print(f"  {escape(result.message)}", highlight=False, soft_wrap=True)
    for issue in result.problems:
        text = f"  [bold]{issue.code}[/] {escape(issue.pointer)}: {escape(issue.message)}"
        console.print(text, highlight=False, soft_wrap=True)
