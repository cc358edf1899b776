"""casa-assets ingest, fetch, articulate: meshes into a library; static ones of appliances into ones that open."""

from __future__ import annotations

import re
import shlex
from collections import Counter
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from casa_assets.cli import batch_output
from casa_assets.cli.batch_output import MOST_LISTED
from casa_assets.cli.options import (
    CLIP_HELP,
    Category,
    DryRun,
    ForceWorse,
    InputLimits,
    LibraryOut,
    Most,
    Out,
    SizeM,
    Workers,
    more,
    shared,
    source,
)
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
)
from casa_assets.cli.verbs.library import Sending, on_store
from casa_assets.errors import CasaError

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Mapping, Sequence

    from casa_assets.articulate.decisions import Decisions
    from casa_assets.articulate.run.steps import ArticulateOutcome
    from casa_assets.ingest.run.run import Options
    from casa_assets.ingest.run.shards import Shard
    from casa_assets.ingest.sources.places import Found, StoreRoot
    from casa_assets.model.record import Vec3
    from casa_assets.runs.outcome import Event

MeshSources = Annotated[
    list[str], typer.Argument(help="Files, folders, packages, manifests, addresses of stores.", parser=source)
]
Explain = Annotated[
    bool, typer.Option("--explain", help="Print every guess, with its confidence and reason; not with --dry-run.")
]
KeepDuplicates = Annotated[
    bool, typer.Option("--keep-duplicates", help="Keep meshes that duplicate one that is already in the library.")
]
Split = Annotated[bool, typer.Option("--split", help="Make one asset of each thing in a file that holds several.")]
ShardWords = Annotated[
    str,
    typer.Option(
        "--shard", metavar="I/N", help="Work on part I of N of the inputs alone, I from 1 to N, for `library merge`."
    ),
]
Retry = Annotated[
    list[str] | None,
    typer.Option(
        "--retry",
        metavar="CODE",
        help="Also work again on inputs rejected with this code, or in review for this subject.",
    ),
]
RetryOnly = Annotated[
    list[str] | None,
    typer.Option("--retry-only", metavar="CODE", help="Work again on such inputs, and on nothing else."),
]
StoreUrl = Annotated[
    str, typer.Option("--store", metavar="URL", help="Also keep the library there, such as s3://bucket/library.")
]
StaticMeshes = Annotated[
    list[Path], typer.Argument(help="Meshes, each of one thing, or folders of them.", exists=True, readable=True)
]
DecisionsFile = Annotated[
    Path | None,
    typer.Option(
        help="decisions.yaml of an earlier run, changed by you, or review.json of its page.",
        exists=True,
        dir_okay=False,
    ),
]
CategoryWeights = Annotated[
    str, typer.Option("--clip-weights", help=more(CLIP_HELP, "it tells the category where --category does not."))
]
Complete = Annotated[
    bool, typer.Option("--complete/--no-complete", help="Build an interior where a door or drawer opens onto nothing.")
]
CONTRACT_ADVICE = "to meet it, change decisions.yaml beside the model, or the mesh, and run again"
# Names of meshes that the progress bar shows at once.
MAX_NAMES = 3


@shared
def ingest(
    output: Output,
    sources: MeshSources,
    library: LibraryOut = Path("out/library"),
    category: Category = "",
    workers: Workers = 0,
    limits: InputLimits = None,
    clip_weights: Annotated[str, typer.Option(help=more(CLIP_HELP, "compares pictures."))] = "",
    keep_duplicates: KeepDuplicates = False,
    split: Split = False,
    retry: Retry = None,
    retry_only: RetryOnly = None,
    force: ForceWorse = False,
    dry_run: DryRun = False,
    shard: ShardWords = "",
    store: StoreUrl = "",
    explain: Explain = False,
) -> None:
    """Turn meshes into simulation-ready assets.

    Results of an earlier run are kept while nothing has changed. An accepted asset is also kept where the new result
    is in review or was rejected; --force replaces it. Exit 0 when all were accepted, 1 when some were rejected,
    4 when none was rejected but a person has to decide about some (review.csv in the library) or an accepted asset was
    kept in place of a new result, 2 on misuse.

    Examples:

      casa-assets ingest ~/meshes                      # every mesh of a folder
      casa-assets ingest mug.glb --category mug        # one file of a known kind
      casa-assets ingest objaverse/ t3d/manifest.jsonl --library lib --jobs 8
      casa-assets ingest s3://bucket/meshes            # a store
      casa-assets ingest table_set.glb --split         # each thing an asset
      casa-assets ingest ~/meshes --dry-run            # write nothing
      casa-assets ingest ~/meshes --retry-only FLT005  # what was rejected so
      casa-assets ingest ~/meshes --retry things       # and what is new
      casa-assets ingest ~/meshes --json > run.jsonl   # an object per input
      casa-assets ingest ~/meshes --store s3://bucket/library
      casa-assets ingest ~/meshes --shard 3/16 --library shards/3
    """
    from casa_assets.ingest.run.inputs import roots_of
    from casa_assets.ingest.run.run import Options

    if dry_run and explain:
        raise typer.BadParameter("--dry-run keeps no guesses; name another --library and leave --dry-run out")
    if dry_run and store:
        raise typer.BadParameter("does not go with --dry-run", param_hint="--store")
    roots, refused = roots_of(sources, library)
    options = Options(library, category, workers, keep_duplicates=keep_duplicates, split=split, force=force)
    options = replace(options, again=_codes(retry), only=_codes(retry_only), shard=_shard(shard), dry_run=dry_run)
    options = replace(options, weights=clip_weights, refused=refused, **(limits or {}))
    with on_store(store, library, output) as sending:
        events = _run_once(roots, options, output, explain, sending)
    if not dry_run:
        batch_output.look(events, output)
    batch_output.end_inputs(events, [event.path for event in events])


def _run_once(
    sources: list[Path | StoreRoot], options: Options, output: Output, explain: bool, sending: Sending
) -> list[Event]:
    from casa_assets.ingest.run.run import ingest as run
    from casa_assets.ingest.run.shards import SHARD_FILE

    others: Counter[str] = Counter()
    events = batch_output.print_events(
        lambda show_work: sending(run(sources, options, others=others, show_work=show_work)), output, options.dry_run
    )
    batch_output.print_others(+others, output)
    if not events and options.only:
        output.line(f"nothing is rejected with, or in review for, {', '.join(sorted(options.only))}")
        return []
    if not events and options.shard is not None and (options.dry_run or (options.library / SHARD_FILE).is_file()):
        output.line(f"shard {options.shard} has none of the inputs")
        return []
    if not events:
        raise batch_output.no_mesh_found(sources)
    if options.dry_run and not output.as_json:
        batch_output.print_counts(events, sum(event.count for event in events if event.kind == "kept"), output)
    elif not output.as_json or explain:
        batch_output.print_summary(events, options.library, output, explain)
    return events


def _codes(words: list[str] | None) -> frozenset[str]:
    from casa_assets.library.review import SUBJECTS

    for word in words or ():
        if word not in SUBJECTS and not re.fullmatch(r"[A-Z]{3}[0-9]{3}", word):
            raise typer.BadParameter(f"{word!r} is no code such as FLT005, and none of {', '.join(SUBJECTS)}")
    return frozenset(words or ())


def _shard(words: str) -> Shard | None:
    from casa_assets.ingest.run.shards import Shard

    try:
        return Shard.parse(words) if words else None
    except CasaError as error:
        raise typer.BadParameter(str(error), param_hint="--shard") from None


@shared
def fetch(
    output: Output,
    uids: Annotated[list[str] | None, typer.Argument(help="Objaverse uids.")] = None,
    lvis: Annotated[str, typer.Option(help="LVIS category of Objaverse to take objects of, such as Mug.")] = "",
    most: Most = 20,
    out: Out = Path("out/objaverse"),
) -> None:
    """Download objects of Objaverse with the `objaverse` package, which needs a network.

    Exit 0 when they are there, 2 on misuse or without a network.

    Examples:

      casa-assets fetch --lvis Mug --most 10
      casa-assets ingest out/objaverse/hf-objaverse-v1
    """
    from casa_assets.ingest.sources.objaverse import download

    if not uids and not lvis:
        raise typer.BadParameter("name uids, or an --lvis category")
    folder = download(uids or [], lvis, most, out)
    output.made(lvis or "objaverse", folder)
    output.line(f"Objects: {folder}")
    output.next_command("ingest", folder)


@shared
def articulate(
    output: Output,
    sources: StaticMeshes,
    out: LibraryOut = Path("out/articulated"),
    category: Category = "",
    up: Annotated[str, typer.Option(help="Axis of the file that points up, such as +z; else it is guessed.")] = "",
    front: Annotated[str, typer.Option(help="Axis of the file that the front faces, such as -y.")] = "",
    size_m: SizeM = 0.0,
    decisions: DecisionsFile = None,
    preview: Annotated[bool, typer.Option("--preview", help="Write strip.png: closed, by part, apart, open.")] = False,
    report: Annotated[bool, typer.Option("--report", help="Print every part with its confidence.")] = False,
    review: Annotated[bool, typer.Option("--review", help="Write review.html, to correct parts on.")] = False,
    clip_weights: CategoryWeights = "",
    complete: Complete = True,
    force: ForceWorse = False,
    workers: Workers = 0,
) -> None:
    """Find doors, drawers, knobs and buttons in static meshes, and write articulated assets as MJCF and USD.

    Results of an earlier run on the same file with the same options are kept, rejections too; a run that was stopped
    goes on where it ended. An accepted asset is also kept where the new result has fewer moving parts, is in review or
    was rejected; --force replaces it. Every decision is in decisions.yaml next to the model: change a line, and pass
    the file with --decisions. Exit 0 when all were accepted, 1 when some were rejected (ART001: nothing moves), 4 when
    none was but some are in review (review.csv in the library) or an accepted asset was kept so, 2 on misuse.

    Examples:

      casa-assets articulate microwave.obj --preview --report
      casa-assets articulate ~/appliances --jobs 8 --review
    """
    from casa_assets.articulate.run import review_page
    from casa_assets.articulate.run.build import ArticulateRequest
    from casa_assets.articulate.run.run import articulate as run

    weights = _weights(clip_weights)
    given, reviewed = _read_decisions(decisions, sources)
    common = category, _axis(up, "--up"), _axis(front, "--front"), size_m, given
    flags = preview or review, weights, complete, force

    def request_for(found: Found) -> ArticulateRequest:
        return ArticulateRequest(Path(found.source.place), out, *common, *flags, found)

    options = {"--category": category, "--up": up, "--front": front, "--size-m": size_m, "--clip-weights": clip_weights}
    others: Counter[str] = Counter()
    outcomes = _follow(
        lambda show_work: run(sources, out, request_for, workers, others, show_work, reviewed),
        output,
        report or output.verbose,
    )
    batch_output.print_others(+others, output)
    if not outcomes:
        raise batch_output.no_mesh_found(sources)
    if len(outcomes) > 1 and not output.as_json:
        kept = sum(outcome.count for outcome in outcomes if outcome.kept)
        in_review = batch_output.print_counts(outcomes, kept, output)
        batch_output.print_review(in_review, False, out, output)
    if review:
        output.line(str(review_page.write(out, outcomes, _review_command(sources, out, options, complete))))
    batch_output.look(outcomes, output)
    batch_output.end_inputs(outcomes, [str(outcome.mesh) for outcome in outcomes])


def _follow(
    start: Callable[[Callable[[Sequence[str]], None]], Generator[ArticulateOutcome]], output: Output, report: bool
) -> list[ArticulateOutcome]:
    """Run under a progress bar, print each outcome and return all; `start` takes what is called with names at work."""
    outcomes: list[ArticulateOutcome] = []
    with bar(output.console) as progress:
        task = progress.add_task("looking", total=None)

        def show_work(names: Sequence[str]) -> None:
            shown = ", ".join(safe(Path(name).name) for name in names[:MAX_NAMES])
            shown += f" and {len(names) - MAX_NAMES} more" if len(names) > MAX_NAMES else ""
            counts = batch_output.counts_text(*batch_output.counts_of(outcomes))
            progress.update(task, description=f"{counts}; at work on {shown}")

        with closing(start(show_work)) as running:
            for outcome in running:
                outcomes.append(outcome)
                progress.update(task, total=outcome.total, completed=sum(o.count for o in outcomes))
                if output.as_json:
                    output.row(_json_row(outcome))
                elif outcome.reason_kept or not outcome.kept or outcome.total <= MOST_LISTED or output.verbose:
                    _print_outcome(outcome, output)
                    if report and outcome.articulation is not None:
                        _table(outcome).print(output.console)
                        for line in outcome.unmet_checks:
                            output.line(f"  {terminal_safe(line)}")
    return outcomes


def _json_row(outcome: ArticulateOutcome) -> dict[str, object]:
    has_asset = outcome.folder is not None and not outcome.code
    return {
        "status": outcome.decision.value,
        "verdict": outcome.decision.value,
        "folder": "" if outcome.folder is None else str(outcome.folder),
        **(measures_at(outcome.folder) if has_asset else measures(None)),
        "to_decide": outcome.to_decide,
        "kept": outcome.kept,
        "path": str(outcome.mesh),
        "id": "" if outcome.folder is None else outcome.folder.name,
        "code": outcome.code,
        "message": outcome.reason_kept or outcome.message,
        "count": outcome.count,
        "parts": [
            {"name": p.name, "kind": p.kind.value, "on": p.parent or "body", "confidence": p.confidence}
            for p in (outcome.articulation.parts if outcome.articulation is not None else ())
        ],
        "warnings": issue_rows(
            i for i in (outcome.report.issues if outcome.report else ()) if i.severity.value == "warning"
        ),
    }


def _review_command(sources: Sequence[Path], out: Path, options: Mapping[str, object], complete: bool) -> str:
    """Return the command that applies the review.json of the page of this run."""
    words = ["casa-assets", "articulate", *map(str, sources), "--library", str(out)]
    words += [f"{name}={value}" for name, value in options.items() if value]
    words += [] if complete else ["--no-complete"]
    return shlex.join([*words, "--review", "--decisions", "review.json"])


def _read_decisions(path: Path | None, sources: Sequence[Path]) -> tuple[Decisions, Mapping[str, Decisions]]:
    """The decisions of a person on the one mesh, and those on many by their sha256. Raises typer.BadParameter."""
    from casa_assets.articulate.decisions import Decisions
    from casa_assets.library.mesh_decisions import read_decisions, read_review

    if path is None:
        return Decisions(), {}
    if path.suffix.lower() == ".json":
        return Decisions(), read_review(path)
    if len(sources) > 1 or sources[0].is_dir():
        message = "a decisions.yaml is that of one mesh; for many, give the review.json of the page of --review"
        raise typer.BadParameter(message, param_hint="--decisions")
    return read_decisions(path), {}


def _weights(clip_weights: str) -> Path | None:
    from casa_assets.library.clip import require_weights

    if not clip_weights:
        return None
    require_weights(clip_weights)
    return Path(clip_weights)


def _axis(word: str, option: str) -> Vec3 | None:
    """Return a direction from words such as `+z`, `-y`, `x`. Raises typer.BadParameter."""
    from casa_assets.articulate.decisions import parse_direction

    try:
        return parse_direction(word) if word else None
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint=option) from None


def _print_outcome(outcome: ArticulateOutcome, output: Output) -> None:
    name = safe(outcome.mesh.name)
    if outcome.reason_kept:
        output.styled(f"[yellow]kept[/] {name}: {safe(outcome.reason_kept)}")
        return
    if outcome.articulation is None:
        message = safe_message(outcome.message, str(outcome.mesh))
        output.styled(f"[red]{outcome.code}[/] {name}: {message}", is_wrong=True)
        return
    count = sum(not p.added for p in outcome.articulation.parts)
    whole = sum(t.is_full for t in outcome.travels.values())
    cavities = sum(r.built for r in outcome.articulation.cavities)
    closed = sum(r.in_doubt for r in outcome.articulation.cavities)
    added = f", {pluralize(cavities, 'interior')} added" if cavities else ""
    added += f", {pluralize(closed, 'interior')} not built behind fronts in doubt" if closed else ""
    reached = f"full range: {whole} of {pluralize(len(outcome.travels), 'joint')}"
    message = f"{pluralize(count, 'moving part')}, {reached}{added}"
    if not outcome.code:
        kept = " (there already)" if outcome.kept else ""
        mark = f"[{'green' if outcome.accepted else 'yellow'}]{outcome.decision.value}{kept}[/]"
    else:
        mark = f"[red]{outcome.code}[/] {safe(outcome.message)};"
    lines = [f"{mark} {name}: {message}", f"  {safe(str(outcome.folder))}"]
    if outcome.contract:
        lines.append(f"  holds the contract {outcome.contract}")
    elif outcome.unmet_checks:
        explanation, first, *others = outcome.unmet_checks
        rest = f" (and {len(others)} more: --report)" if others else ""
        lines += [f"  {safe(line)}" for line in (explanation, f"  {first}{rest}", f"  {CONTRACT_ADVICE}")]
    for issue in outcome.report.issues if outcome.report else ():
        lines.append(f"  {issue.severity.value} {issue.code} {safe(f'{issue.pointer} {issue.message}')}")
    for line in lines:
        output.styled(line, is_wrong=bool(outcome.code))


def _table(outcome: ArticulateOutcome) -> TextTable:
    assert outcome.articulation is not None
    frame = outcome.articulation.frame
    title = f"{outcome.category}; size: {outcome.size}; frame: {frame.confidence:.0%} sure ({frame.reason})" + (
        f"; next: {frame.runner_up}" if frame.runner_up else ""
    )
    heads = ("part", "on", "joint", "goes", "confidence", "reason", "else")
    table = TextTable(heads, sentences=("reason", "else"), right=("confidence",), title=terminal_safe(title))
    for part in outcome.articulation.parts:
        joint = part.joint
        how = joint.kind.value + (f" {joint.edge.value}" if joint.edge else "")
        way = outcome.travels.get(part.name)
        goes = "all" if way is not None and way.is_full else ""
        if way is not None and not way.is_full:
            goes = f"{min(way.free_share, way.pushed_share):.0%} {way.blocked_by}"
        sure = f"{part.confidence:.0%}"
        table.add(part.name, part.parent or "body", how, goes, sure, part.full_reason, joint.runner_up)
    for cavity in outcome.articulation.cavities:
        if cavity.built or cavity.in_doubt:
            name = f"{'+' if cavity.built else 'no'} {cavity.interior.value}"
            table.add(name, cavity.parts[0], "", "", f"{cavity.confidence:.0%}", cavity.reason, "")
    return table
