"""Output of commands that work on many inputs: each as it is done, tables, counts, the exit code."""

from __future__ import annotations

import shlex
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.text import Text

from casa_assets.cli.output import (
    Output,
    TextTable,
    bar,
    issue_rows,
    measures,
    measures_at,
    pluralize,
    safe,
    safe_message,
    terminal_safe,
    working_on,
)
from casa_assets.errors import BatchFault, CasaError

if TYPE_CHECKING:
    from casa_assets.articulate.run.steps import ArticulateOutcome
    from casa_assets.families.build import FamilyResult
    from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult
    from casa_assets.library.entry import Entry
    from casa_assets.model.issue import Decision
    from casa_assets.runs.outcome import Event

    Built = SceneResult | FamilyResult
    Done = Event | ArticulateOutcome

NARROW_COLUMNS = 5  # columns of numbers that a terminal shows that has no room for all of them
MAX_LISTED = 20  # draws that are listed one by one at the end
EXAMPLE_CHARACTERS = 160  # of the message about a refused draw
WIDE_TERMINAL = 140  # characters that the whole table takes
# Where a run has more inputs than this, what was in the library already is counted and not listed.
MOST_LISTED = 200
MAX_ROWS = 40  # of a table that are printed where the user did not ask for more words


def follow(
    running: Iterator[SceneResult], recipes: Sequence[SceneRecipe], word: str, output: Output, lean: bool = False
) -> list[SceneResult]:
    """Print a line for each scene as it is done; returns all of them.

    `lean`: drop the reports of scenes that passed, which are on disk: thousands would fill the memory.
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


def end_builds(results: Sequence[Built], output: Output, one_is_enough: bool = False) -> None:
    """Print the command that shows the first that was made, and end with exit 1 where one, or all, failed, or 3."""
    output.look(*[result.folder for result in results if result.passed][:1])
    if faults := [result for result in results if result.is_fault]:
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


def print_sample(
    results: list[SceneResult], recipes: Sequence[SceneRecipe], seed: int, out: Path, output: Output
) -> None:
    """Print and write why draws were refused and how diverse those are that passed; print what a kitchen cost."""
    from casa_assets.layouts.run import sample as run
    from casa_assets.layouts.run.diversity import table_rows, write_diversity
    from casa_assets.layouts.run.sample import diversity_of_recipes, diversity_of_reference
    from casa_assets.runs.outcome import writing

    passed = {r.recipe.scene_id for r in results if r.passed}
    drawn = diversity_of_recipes(recipe for recipe in recipes if recipe.scene_id in passed)
    reference = diversity_of_reference()
    with writing(out):
        rejected = run.write_rejected(out, seed, recipes, results)
        measured = write_diversity(out, drawn, reference)
    if len(results) <= MAX_LISTED:
        print_numbers(results, out, output)
    why = TextTable(("refused for", "plan", "style", "draws", "such as"), sentences=("such as",), right=("draws",))
    for row in run.refusals(results):
        why.add(row.reason, row.plan, row.style, str(row.count), row.example[:EXAMPLE_CHARACTERS])
    why.print(output.console)
    heads = (f"these {len(passed)}", f"the {reference.kitchens} of plan x style")
    table = TextTable(("diversity", *heads), right=heads, title="Evenness from 0 to 1, distances from 0 to 1")
    for cells in table_rows(drawn, reference)[1:]:
        table.add(*cells)
    table.print(output.console)
    cost = run.cost_of(results)
    steps = ", ".join(f"{step} {seconds:.1f}" for step, seconds in cost.steps.items())
    output.line(f"{cost.total:.1f} core-seconds per kitchen ({steps}), the mean of {pluralize(cost.kitchens, 'draw')}")
    share = f"{len(passed) / len(results):.1%}" if results else "none"
    output.line(
        f"{len(passed)} of {pluralize(len(results), 'draw')} passed ({share}); why the others did not: {rejected}"
    )
    output.line(f"Diversity: {measured}")


@dataclass(frozen=True)
class SceneTable:
    """Rows about each scene of a run: heads behind the id, those that are no numbers, a line below, cells by folder."""

    heads: tuple[str, ...]
    words: tuple[str, ...]
    note: str
    rows_of: Callable[[Path], Iterable[Sequence[object]]]


def follow_and_list(
    running: Iterator[SceneResult], recipes: Sequence[SceneRecipe], word: str, about: SceneTable, output: Output
) -> None:
    """Print a line for each scene as it is done, then a table about all, and end as `end_builds` does."""
    results = follow(running, recipes, word, output)
    table = TextTable(("scene", *about.heads), about.words, [name for name in about.heads if name not in about.words])
    for result in results if not output.as_json else ():
        for row in about.rows_of(Path(result.folder)) if result.folder and result.report is not None else ():
            table.add(result.recipe.scene_id, *map(str, row))
    table.print(output.console)
    if table.rows and about.note:
        output.line(about.note)
    end_builds(results, output)


def _robot_rows(folder: Path) -> Iterator[Sequence[object]]:
    from casa_assets.addons.robots.certify import read_certificate

    if (found := read_certificate(folder)) is not None:
        for robot in found.robots:
            numbers = robot.reached, robot.followed, len(robot.joints), robot.margin
            yield robot.robot, *numbers, len(found.without_parking)


def _state_rows(folder: Path) -> Iterator[Sequence[object]]:
    from casa_assets.layouts.run.state_file import read_states
    from casa_assets.model.kitchen.files import START_STATES

    found, size = read_states(folder), (folder / START_STATES).stat().st_size
    refused = ", ".join(f"{reason}: {count}" for reason, count in found.refused.items()) or "none"
    deepest, farthest = (f"{1000 * lengths.max():.2f}" for lengths in (found.depth, found.motion))
    yield len(found), deepest, farthest, f"{size / 1000:.0f}", refused


def _batch_rows(folder: Path) -> Iterator[Sequence[object]]:
    from casa_assets.addons.batch.batch_form import read_batch

    if (found := read_batch(folder)) is not None:
        needs = found.engine
        numbers = found.colliders, found.pairs, len(found.joints), len(found.locked), needs.awake_in_use
        yield *numbers, needs.nconmax, needs.njmax, needs.nccdmax, needs.nvmax


ROBOTS = SceneTable(
    ("robot", "reached", "followed", "of joints", "margin", "not parked"),
    ("robot",),
    "margin: the median; not parked: joints of fixtures that have no parking place",
    _robot_rows,
)
STATES = SceneTable(
    ("states", "deepest mm", "moved mm", "kB", "draws given up"),
    ("draws given up",),
    "deepest: of all contacts; moved: the farthest that a thing goes on moving",
    _state_rows,
)
BATCHES = SceneTable(
    ("colliders", "pairs", "joints", "locked", "awake in use", "nconmax", "njmax", "nccdmax", "nvmax"),
    (),
    "",
    _batch_rows,
)


def _scene_row(result: SceneResult) -> dict[str, Any]:
    verdict = "failed" if not result.passed else "made" if result.report is None else "passed"
    row = built_row(result, result.recipe.scene_id, verdict, digits=3)
    return {**row, **measures_at(result.folder), "kept": result.kept, "cpu_s": result.cpu_s, **result.counts}


def built_row(result: Built, id_: str, verdict: str, digits: int) -> dict[str, Any]:
    """Fields of a row about anything that was built, with the wall-clock seconds of each step."""
    row = {"id": id_, "folder": result.folder, "verdict": verdict, "passed": result.passed, "message": result.message}
    steps = ("build_s", "write_s", "draw_s", "check_s")
    seconds = {name: round(getattr(result, name), digits) for name in steps}
    return {**row, "issues": issue_rows(result.problems), **seconds}


def print_problems(result: Built, output: Output) -> None:
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
    print_problems(result, output)
    for check in result.report.results if output.verbose and result.report else ():
        number = check.reason if check.number is None else f"{check.number:.4g} {check.unit}".rstrip()
        limit = "" if check.limit is None else f" (limit {check.limit:.4g})"
        output.detail(f"  {check.code} {check.status.value}: {number}{limit}")


def no_mesh_found(sources: Sequence[object]) -> CasaError:
    """The error that the sources hold no mesh, with what would be one."""
    from casa_assets.formats.read.formats import LISTED

    names = ", ".join(map(str, sources))
    return CasaError(
        f"no mesh found in {names}; name {LISTED}, an archive of them, a manifest .jsonl or an Objaverse folder"
    )


def print_others(others: Counter[str], output: Output) -> None:
    """Say how many files were no meshes, by what they are; nothing where all were."""
    if not others:
        return
    counts = dict(sorted(others.items()))
    words = ", ".join(f"{count} {kind}" for kind, count in counts.items())
    blank = {"to_decide": [], "kept": False, "path": "", "id": "", "code": "", "warnings": [], "folder": ""}
    row = {**blank, **measures(None), "status": "no_mesh", "verdict": "no_mesh", "message": words}
    output.row({**row, "count": others.total(), "kinds": counts})
    if not output.as_json:
        output.line(f"No meshes: {pluralize(others.total(), 'file')} ({words})")


def counts_of(done: Sequence[Done]) -> tuple[int, int, int]:
    """Return how many inputs were accepted, are in review, and were rejected."""
    from casa_assets.model.issue import Decision

    accepted, in_review, rejected = (sum(one.count for one in done if one.decision is each) for each in Decision)
    return accepted, in_review, rejected


def counts_text(accepted: int, in_review: int, rejected: int, ok: str = "accepted") -> str:
    """Return how many were accepted, are in review and were rejected, with markup."""
    return f"[green]{accepted} {ok}[/], [yellow]{in_review} in review[/], [red]{rejected} rejected[/]"


def print_counts(done: Sequence[Done], kept: int, output: Output) -> int:
    """Print how many were rejected for each reason, then accepted, in review (returned), rejected, of them `kept`."""
    codes: Counter[str] = Counter()
    for one in done:
        codes[one.code] += one.count * bool(one.code)
    _print_codes(+codes, output)
    counts = counts_of(done)
    there = f" ({kept} {'was' if kept == 1 else 'were'} there already)" if kept else ""
    output.styled(f"{pluralize(sum(counts), 'input')}: {counts_text(*counts)}{there}")
    return counts[1]


def look(done: Sequence[Done], output: Output) -> None:
    """Print the command that shows the first asset that was made."""
    from casa_assets.model.issue import Decision

    output.look(*[one.folder for one in done if one.folder and one.decision is not Decision.REJECTED][:1])


def end_inputs(done: Sequence[Done], names: Sequence[str]) -> None:
    """End with exit 3 after a fault of the program, 1 after a rejection, 4 where a person has to decide."""
    from casa_assets.runs.outcome import CRASH_CODE

    if faults := [name for name, one in zip(names, done, strict=True) if one.code == CRASH_CODE]:
        raise BatchFault(map(terminal_safe, faults))
    _, in_review, rejected = counts_of(done)
    if rejected:
        raise typer.Exit(1)
    if in_review or any(one.reason_kept for one in done):
        raise typer.Exit(4)


def _print_codes(codes: Counter[str], output: Output) -> None:
    from casa_assets import registry

    if not codes:
        return
    records = registry.load()
    heads = ("code", "reason", "inputs", "what to do")
    table = TextTable(heads, sentences=("reason", "what to do"), right=("inputs",), title="Rejected by reason")
    why: dict[str, str] = {}
    if not codes.keys() <= records.rejections.keys():
        from casa_assets.show.page.page_template import explanations

        why = explanations()
    for code, count in codes.most_common():
        row = records.rejections.get(code)
        meaning, advice = (row.meaning, row.remedy) if row else (why.get(code, ""), "as the line of each input says")
        table.add(code, meaning, str(count), advice)
    table.print(output.console)


def print_review(count: int, asks_category: bool, library: Path, output: Output) -> None:
    """Print how to decide about the inputs in review; `asks_category`: the category of some of them is unknown."""
    if not count:
        return
    place = terminal_safe(shlex.quote(str(library)))
    wait, it = ("input waits", "it") if count == 1 else ("inputs wait", "them")
    output.line(f"Review:  {count} {wait} for your decision; exports include {it} only with --with-review")
    output.line(f"         decide on a page with `casa-assets review {place}`, or in {place}/review.csv, and run again")
    if asks_category:
        output.line("         no category was found for some: give --category if all are of one, or a manifest.jsonl")
        output.line('         with a line for each file, such as {"file": "a.glb", "category": "mug"}')


def print_events(
    start: Callable[[Callable[[str], None] | None], Generator[Event]], output: Output, dry_run: bool = False
) -> list[Event]:
    """Run, print a line for each input as it is done, and return all; `start` takes what is called with each begun."""
    events: list[Event] = []
    done = bad = unsure = 0
    begun: dict[str, None] = {}
    last_begun = 0.0
    with bar(output.console) as progress:
        task = progress.add_task("looking", total=None)

        def show() -> None:
            name = f"; {safe(Path(next(iter(begun))).name)}" if begun else ""
            counts = counts_text(done - bad - unsure, unsure, bad, ok="ok")
            progress.update(task, completed=done, description=f"{counts}{name}")

        def show_work(path: str) -> None:
            nonlocal last_begun
            begun[path] = None
            last_begun = time.monotonic()
            show()

        with closing(start(show_work)) as running:
            for event in running:
                events.append(event)
                begun.pop(event.path, None)
                done += event.count
                bad += event.count * event.was_rejected
                unsure += event.is_in_review
                progress.update(task, total=event.total)
                show()
                is_news = event.kind != "kept" or bool(event.reason_kept)
                if is_news or event.total <= MOST_LISTED or output.verbose or output.as_json:
                    _print_event(event, output, dry_run)
    if last_begun and output.verbose:
        output.line(f"Tail:    the last input was begun {time.monotonic() - last_begun:.0f} s before the end")
    return events


def _print_event(event: Event, output: Output, dry_run: bool) -> None:
    if output.as_json:
        output.row(_json_row(event, dry_run))
    elif event.kind == "rejected" or (output.verbose and event.was_rejected):
        message = safe_message(event.message, event.path)
        output.styled(f"[red]rejected[/] {safe(event.path)}: [bold]{event.code}[/] {message}", is_wrong=True)
    elif event.reason_kept:
        output.styled(f"[yellow]kept[/] {safe(event.path)}: {safe(event.reason_kept)}")
    elif dry_run or output.verbose:
        color = "yellow" if event.is_in_review else "green"
        kept = " (there already)" if event.kind == "kept" else ""
        output.styled(f"[{color}]{event.decision.value}[/]{kept} {safe(event.path)}: {event.asset_id}")
        for warning in event.warnings if event.is_in_review else ():
            output.line(f"  {terminal_safe(warning.pointer)}: {terminal_safe(warning.message)}")


def _json_row(event: Event, dry_run: bool) -> dict[str, object]:
    return {
        "status": event.decision.value,
        "verdict": event.decision.value,
        "folder": "" if event.folder is None else str(event.folder),
        **measures(event.summary),
        "to_decide": event.to_decide,
        "kept": event.kind == "kept",
        "path": event.path,
        "id": event.asset_id,
        "code": event.code,
        "message": event.message,
        "count": event.count,
        "dry_run": dry_run,
        "warnings": issue_rows(event.warnings),
    }


def print_summary(events: list[Event], library: Path, output: Output, explain: bool = False) -> None:
    """Print what became of the inputs of a run, and where to find it; `explain`: also every guess."""
    from casa_assets.library.entry_table import EntryTable
    from casa_assets.library.library import Library
    from casa_assets.model.issue import Decision

    touched = {e.asset_id for e in events}
    if len(touched) > MOST_LISTED:
        touched = {e.asset_id for e in events if e.kind != "kept"}
    rows = {e.id: e for e in EntryTable(Library(library)).entries if e.id in touched} if touched else {}
    most = len(rows) if output.verbose else MAX_ROWS
    for decision in (Decision.ACCEPTED, Decision.REVIEW):
        _table([entry for entry in rows.values() if entry.decision is decision], decision, most).print(output.console)
    if explain:
        for entry in rows.values():
            _print_guesses(entry, output)
    _print_library_checks(library, output)
    unsure = print_counts(events, sum(event.count for event in events if event.kind == "kept"), output)
    place = terminal_safe(str(library))
    output.line(f"Library: {place}/")
    print_review(unsure, any("category" in event.to_decide for event in events), library, output)
    output.next_command("report", "--library", library)


def _print_library_checks(library: Path, output: Output, max_lines: int = 6) -> None:
    from casa_assets.library.library_report import read_library_report
    from casa_assets.model.issue import Status

    library_report = read_library_report(library)
    issues = library_report.report.issues if library_report else ()
    shown = issues if output.verbose else issues[:max_lines]
    for issue in shown:
        place = f"{issue.pointer} " if issue.pointer else ""
        output.styled(f"[yellow]{issue.code}[/] {place}{safe(issue.message)}")
    for result in library_report.report.results if library_report else ():
        if result.status is Status.NOT_RUN and output.verbose:
            output.styled(f"[yellow]{result.code}[/] not run: {safe(result.reason)}")
    if len(issues) > len(shown):
        output.line(f"... and {len(issues) - len(shown)} more about the library as a whole, see the report")


def _table(found: list[Entry], decision: Decision, most: int) -> TextTable:
    """Numbers of accepted assets, or of those in review and what a person has to decide about them."""
    from casa_assets.model.issue import Decision

    is_accepted = decision is Decision.ACCEPTED
    about = ("shapes", "checks", "advice") if is_accepted else ("for you to decide",)
    heads = ("asset", "size (cm)", "mass", *about, "source")
    right = heads[2:-1] if is_accepted else ("mass",)
    table = TextTable(heads, right=right, title="Accepted" if is_accepted else "In review")
    for entry in found[:most]:
        assert entry.summary is not None
        size = " x ".join(f"{100 * v:.3g}" for v in entry.summary.extents)
        mass = f"{entry.summary.mass:.3g} kg" if entry.summary.mass >= 1 else f"{1000 * entry.summary.mass:.3g} g"
        checks = f"{entry.checks.passed}/{entry.checks.applying}"
        numbers = (str(entry.summary.colliders), checks, str(len(entry.warnings)))
        cells = numbers if is_accepted else (", ".join(entry.to_decide),)
        table.add(entry.id, size, mass, *cells, terminal_safe(entry.source_path))
    if len(found) > most:
        table.add(f"... and {len(found) - most} more", *[""] * (len(heads) - 1))
    return table


def _print_guesses(entry: Entry, output: Output) -> None:
    output.console.print(f"\n[bold]{entry.id}[/] {safe(entry.source_path)}", soft_wrap=True)
    lines = [f"  {g.subject}: {safe(g.value)} ({g.confidence:.0%}): {safe(g.reason)}" for g in entry.guesses]
    lines += [f"  [yellow]{i.code}[/] {safe(i.pointer)}: {safe(i.message)}" for i in entry.warnings]
    lines += [] if entry.accepted else [f"  [red]{entry.code}[/] {safe(entry.message)}"]
    for line in lines:
        output.styled(line)
