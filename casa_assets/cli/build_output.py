"""Output of commands that build kitchens, fixtures or objects: each as it is done, tables, counts, the exit code."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.text import Text

from casa_assets.cli.output import Output, TextTable, issue_rows, measures_at, pluralize, working_on
from casa_assets.errors import BatchFault

if TYPE_CHECKING:
    from collections.abc import Mapping

    from casa_assets.families.build import FamilyRequest, FamilyResult
    from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult
    from casa_assets.model.issue import Report

NARROW_COLUMNS = 5  # columns of numbers that a terminal shows that has no room for all of them
MAX_LISTED = 20  # draws that are told one by one at the end
EXAMPLE_CHARACTERS = 160  # of what was said of a refused draw
WIDE_TERMINAL = 140  # characters that the whole table takes
MAX_TOLD = 12  # problems of one check of all members that are printed; the library keeps all of them


def follow(
    running: Iterator[SceneResult], recipes: Sequence[SceneRecipe], word: str, output: Output, lean: bool = False
) -> list[SceneResult]:
    """Print a line for each scene as it is done; returns all of them.

    Args:
        word: what is done with them, for the bar.
        lean: drop the reports of scenes that passed, which are on disk: thousands would fill the memory.
    """
    results: list[SceneResult] = []
    with working_on(output.console, word, [recipe.scene_id for recipe in recipes]) as done:
        for result in running:
            results.append(replace(result, report=None) if lean and result.passed else result)
            done(result.recipe.scene_id)
            if output.as_json:
                output.row(_scene_row(result))
            _print_scene(result, output)
    return results


def end(results: Sequence[SceneResult | FamilyResult], output: Output, one_is_enough: bool = False) -> None:
    """Print the command that shows the first that was made, and end with exit 1 where one failed, or where all did.

    Raises BatchFault after faults of the program.
    """
    output.look(*[result.folder for result in results if result.passed][:1])
    faults = [result for result in results if result.is_fault]
    if faults:
        raise BatchFault(one.recipe.scene_id if hasattr(one, "recipe") else one.request.title for one in faults)
    if not (any if one_is_enough else all)(result.passed for result in results):
        raise typer.Exit(1)


def write_reports(results: list[SceneResult], out: Path, output: Output) -> None:
    """Write page, contact sheet and table of the folder; print where they are and how many scenes were made."""
    from casa_assets.runs.outcome import writing
    from casa_assets.show.reports import kitchens

    with writing(out):
        page, picture = kitchens.write(out)
    made = sum(r.passed for r in results)
    kept = sum(r.kept for r in results)
    output.line(f"{made} of {pluralize(len(results), 'scene')} in {out} ({kept} unchanged)")
    for name, path in (("Pictures", picture), ("Page", page), ("Numbers", out / kitchens.SUMMARY)):
        output.line(f"{name + ':':9} {path}")


def print_numbers(results: list[SceneResult], out: Path, output: Output) -> None:
    """Print numbers of the scenes of this run, as far as they are in the folder, and their sum."""
    from casa_assets.show.reports.kitchens import COLUMNS, cells, read_rows, sentence

    mine = {r.recipe.scene_id for r in results if r.folder}
    found = [row for row in read_rows(out) if row.id in mine]
    if not found:
        return
    is_wide = not output.console.is_terminal or output.console.width >= WIDE_TERMINAL
    heads = [heading for heading, _, _ in COLUMNS[: None if is_wide else NARROW_COLUMNS]]
    table = TextTable(("scene", "verdict", *heads), sentences=("verdict",), right=heads)
    for row in found:
        verdict = Text(row.verdict, style="green" if row.passed else "red")
        table.add(row.id, verdict, *cells(row)[: len(heads)])
    table.print(output.console)
    output.line(sentence(found))


def print_robots(results: list[SceneResult], output: Output) -> None:
    """Print for each scene how many joints each robot reaches and opens."""
    from casa_assets.addons.robots.certify import read_certificate

    heads = ("reached", "followed", "of joints", "margin", "not parked")
    table = TextTable(("scene", "robot", *heads), right=heads)
    for result in results:
        found = read_certificate(Path(result.folder)) if result.folder else None
        if found is None:
            continue
        for robot in found.robots:
            numbers = (robot.reached, robot.followed, len(robot.joints), robot.margin, len(found.without_parking))
            table.add(result.recipe.scene_id, robot.robot, *map(str, numbers))
    table.print(output.console)
    if table.rows:
        output.line("margin: the median; not parked: joints of fixtures that have no parking place")


def print_sample(
    results: list[SceneResult], recipes: Sequence[SceneRecipe], seed: int, out: Path, output: Output
) -> None:
    """Print what became of draws, and write rejected.json and diversity.json.

    Tables show why some were refused, how diverse those are that passed, and what a kitchen cost.
    """
    from casa_assets.layouts.run import sample
    from casa_assets.layouts.run.draws import (
        diversity_of_recipes,
        diversity_of_reference,
        table_rows,
        write_diversity,
    )
    from casa_assets.runs.outcome import writing

    passed = {r.recipe.scene_id for r in results if r.passed}
    drawn = diversity_of_recipes(recipe for recipe in recipes if recipe.scene_id in passed)
    reference = diversity_of_reference()
    with writing(out):
        rejected = sample.write_rejected(out, seed, recipes, results)
        measured = write_diversity(out, drawn, reference)
    if len(results) <= MAX_LISTED:
        print_numbers(results, out, output)
    why = TextTable(("refused for", "plan", "style", "draws", "such as"), sentences=("such as",), right=("draws",))
    for row in sample.refusals(results):
        why.add(row.reason, row.plan, row.style, str(row.count), row.example[:EXAMPLE_CHARACTERS])
    why.print(output.console)
    heads = (f"these {len(passed)}", f"the {reference.kitchens} of plan x style")
    told = TextTable(("diversity", *heads), right=heads, title="Evenness from 0 to 1, distances from 0 to 1")
    for cells in table_rows(drawn, reference)[1:]:
        told.add(*cells)
    told.print(output.console)
    cost = sample.cost_of(results)
    steps = ", ".join(f"{step} {seconds:.1f}" for step, seconds in cost.steps.items())
    output.line(f"{cost.total:.1f} core-seconds per kitchen ({steps}), the mean of {pluralize(cost.kitchens, 'draw')}")
    share = f"{len(passed) / len(results):.1%}" if results else "none"
    output.line(
        f"{len(passed)} of {pluralize(len(results), 'draw')} passed ({share}); why the others did not: {rejected}"
    )
    output.line(f"Diversity: {measured}")


def print_states(results: list[SceneResult], output: Output) -> None:
    """Print for each scene its start states: how many, the deepest contact, the farthest motion, what was refused."""
    from casa_assets.layouts.run.scene_files import START_STATES
    from casa_assets.layouts.run.state_file import read_states

    heads = ("states", "deepest mm", "moved mm", "kB")
    table = TextTable(("scene", *heads, "draws given up"), sentences=("draws given up",), right=heads)
    for result in results:
        if not result.folder or result.report is None:
            continue
        folder = Path(result.folder)
        found, size = read_states(folder), (folder / START_STATES).stat().st_size
        numbers = (f"{1000 * found.depth.max():.2f}", f"{1000 * found.motion.max():.2f}", f"{size / 1000:.0f}")
        refused = ", ".join(f"{reason}: {count}" for reason, count in found.refused.items()) or "none"
        table.add(result.recipe.scene_id, str(len(found)), *numbers, refused)
    table.print(output.console)
    if table.rows:
        output.line("deepest: of all contacts; moved: the farthest that a thing goes on moving")


def print_batch_forms(results: list[SceneResult], output: Output) -> None:
    """Print for each scene the size of its batch form, and what an engine has to allocate for it."""
    from casa_assets.layouts.run.scene_folders import read_batch

    heads = ("colliders", "pairs", "joints", "locked", "awake in use", "nconmax", "njmax", "nccdmax", "nvmax")
    table = TextTable(("scene", *heads), right=heads)
    for result in results:
        found = read_batch(Path(result.folder)) if result.folder else None
        if found is None:
            continue
        engine = found.engine
        numbers = (found.colliders, found.pairs, len(found.joints), len(found.locked), engine.awake_in_use)
        limits = (engine.nconmax, engine.njmax, engine.nccdmax, engine.nvmax)
        table.add(result.recipe.scene_id, *(str(number) for number in (*numbers, *limits)))
    table.print(output.console)


def _scene_row(result: SceneResult) -> dict[str, Any]:
    """The row that `--json` prints for a scene."""
    verdict = "failed" if not result.passed else "made" if result.report is None else "passed"
    return {
        "id": result.recipe.scene_id,
        "folder": result.folder,
        "verdict": verdict,
        **measures_at(result.folder),
        "passed": result.passed,
        "kept": result.kept,
        "message": result.message,
        "issues": issue_rows(result.problems),
        **_seconds(result, 3),
        "cpu_s": result.cpu_s,
        **result.counts,
    }


def _seconds(result: SceneResult | FamilyResult, digits: int) -> dict[str, float]:
    """Wall-clock seconds of each step."""
    return {name: round(getattr(result, name), digits) for name in ("build_s", "write_s", "draw_s", "check_s")}


def _print_problems(result: SceneResult | FamilyResult, output: Output) -> None:
    """Print why something was not made, and what checks found."""
    say = output.line if result.passed else output.wrong
    for line in (result.message, *(f"  {i.code} {i.pointer}: {i.message}" for i in result.problems)):
        if line:
            say(line)


def _print_scene(result: SceneResult, output: Output) -> None:
    scene = result.recipe.scene_id
    if result.kept and result.passed:
        output.styled(f"[green]kept[/] [bold]{scene}[/]")
        return
    mark = "[red]failed[/]" if not result.passed else "[green]made[/]" if result.report is None else "[green]passed[/]"
    seconds = f"build {result.build_s:.1f} s, write {result.write_s:.1f} s, draw {result.draw_s:.1f} s"
    if result.report is not None:
        seconds += f", check {result.check_s:.1f} s"
    output.styled(f"{mark} [bold]{scene}[/] ({seconds})", is_wrong=not result.passed)
    _print_problems(result, output)
    for check in result.report.results if output.verbose and result.report else ():
        number = check.reason if check.number is None else f"{check.number:.4g} {check.unit}".rstrip()
        limit = "" if check.limit is None else f" (limit {check.limit:.4g})"
        output.detail(f"  {check.code} {check.status.value}: {number}{limit}")


def follow_members(
    running: Iterable[FamilyResult], requests: Sequence[FamilyRequest], output: Output
) -> list[FamilyResult]:
    """Print each member that failed, and as JSON or in many words each, as it is done; returns all."""
    results: list[FamilyResult] = []
    with working_on(output.console, "building", [request.title for request in requests]) as done:
        for result in running:
            results.append(result)
            done(result.request.title)
            print_member(result, output)
    return results


def _member_row(result: FamilyResult) -> dict[str, object]:
    """The row that `--json` prints for a member."""
    return {
        "member": result.request.title,
        "id": result.asset_id,
        "folder": result.folder,
        "verdict": "passed" if result.passed else "failed",
        **measures_at(result.folder if result.passed else None),
        "passed": result.passed,
        "kept": result.is_kept,
        "message": result.message,
        "issues": issue_rows(result.problems),
        **_seconds(result, 4),
        "cpu_s": round(result.cpu_s, 4),
        "bytes": result.size_bytes,
    }


def print_member(result: FamilyResult, output: Output, always: bool = False) -> None:
    """Print whether a member passed, how long it took, and every issue.

    Args:
        always: also of a member that passed, where the user did not ask for more words.
    """
    output.row(_member_row(result))
    if result.passed and not (always or output.verbose):
        return
    mark = "[green]passed[/]" if result.passed else "[red]failed[/]"
    seconds = f"build {result.build_s:.2f} s, write {result.write_s:.2f} s, check {result.check_s:.2f} s"
    where = f" {result.asset_id} ({seconds}, {result.size_bytes / 1e6:.2f} MB)" if result.asset_id else ""
    output.styled(f"{mark} [bold]{result.request.title}[/]{where}", is_wrong=not result.passed)
    _print_problems(result, output)


def print_members(results: Sequence[FamilyResult], output: Output) -> None:
    """Print a table of medians, a row for each family or category."""
    from casa_assets.families.build import summary

    names = ("family", "passed", "of", "build s", "write s", "draw s", "check s", "CPU s", "MB")
    table = TextTable(names, right=names[1:], title="median per member")
    for row in summary(list(results)):
        table.add(*row)
    table.print(output.console)
    if kept := sum(result.is_kept for result in results):
        output.line(f"{kept} of {len(results)} were there already and stay as they are")


def print_together(report: Report, titles: Mapping[str, str], output: Output) -> None:
    """Print what the checks of all members together found, the first few problems of each.

    Args:
        report: of a library. titles: code -> title of the checks to print.
    """
    for result in report.results:
        if result.code not in titles:
            continue
        number = result.reason if result.number is None else f"{result.number:.3g} (limit {result.limit:g})"
        output.line(f"{result.code} {titles[result.code]}: {result.status.value}, {number}")
        found = [issue for issue in report.issues if issue.code == result.code]
        for issue in found if output.verbose else found[:MAX_TOLD]:
            output.line(f"  {issue.pointer}: {issue.message}")
        if len(found) > MAX_TOLD and not output.verbose:
            output.line(f"  and {len(found) - MAX_TOLD} more, in library.json")
