"""casa-assets ingest, fetch: sources into a library, and objects of Objaverse to be such sources."""

from __future__ import annotations

import re
from collections import Counter
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from casa_assets.cli.batch_output import (
    end_inputs,
    look,
    no_mesh_found,
    on_store,
    print_counts,
    print_events,
    print_others,
    print_summary,
)
from casa_assets.cli.group import LIMITS
from casa_assets.cli.options import (
    CLIP_HELP,
    Category,
    DryRun,
    ForceWorse,
    LibraryOut,
    Most,
    Out,
    Workers,
    more,
    shared,
    source,
)
from casa_assets.cli.output import Output
from casa_assets.errors import CasaError

if TYPE_CHECKING:
    from casa_assets.cli.batch_output import Sending
    from casa_assets.ingest.run.run import Options
    from casa_assets.ingest.run.shards.record import Shard
    from casa_assets.ingest.sources.places import StoreRoot
    from casa_assets.runs.outcome import Event


# An option that bounds an input; 0 stands for the default, which its help names.
_limit = partial(typer.Option, min=0, show_default=False, rich_help_panel=LIMITS)
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


@shared
def ingest(
    output: Output,
    sources: Annotated[
        list[str],
        typer.Argument(help="Files, folders, packages, manifests, addresses of stores.", parser=source),
    ],
    library: LibraryOut = Path("out/library"),
    category: Category = "",
    workers: Workers = 0,
    timeout: Annotated[float, _limit(metavar="SECONDS", help="Processor seconds per input; 300 by default.")] = 0.0,
    memory: Annotated[float, _limit(metavar="GB", help="Gigabytes per input; 8 by default.")] = 0.0,
    max_size: Annotated[float, _limit(metavar="MB", help="Megabytes of an input; 512 by default.")] = 0.0,
    max_faces: Annotated[int, _limit(help="Faces of an input; 2500000 by default.")] = 0,
    max_texture: Annotated[int, _limit(help="Pixels of a side; 16384 by default.")] = 0,
    max_pixels: Annotated[float, _limit(help="Million pixels; 67.2 by default.")] = 0.0,
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

    What the library holds of an input is kept while nothing has changed. An accepted asset is also kept where the new
    result is in review or was rejected; --force replaces it. Exit 0 when all were accepted, 1 when some were rejected,
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
    options = Options(
        library,
        category,
        workers,
        seconds=timeout,
        memory_bytes=int(memory * 1e9),
        guards=_guards(max_size, max_faces, max_texture, max_pixels),
        weights=clip_weights,
        keep_duplicates=keep_duplicates,
        split=split,
        again=_codes(retry),
        only=_codes(retry_only),
        dry_run=dry_run,
        shard=_shard(shard),
        refused=refused,
        force=force,
    )
    with on_store(store, library, output) as sending:
        events = _run_once(roots, options, output, explain, sending)
    if not dry_run:
        look(events, output)
    end_inputs(events, [event.path for event in events])


def _run_once(
    sources: list[Path | StoreRoot], options: Options, output: Output, explain: bool, sending: Sending
) -> list[Event]:
    from casa_assets.ingest.run.run import ingest as run
    from casa_assets.ingest.run.shards.record import NAME as SHARD_RECORD

    others: Counter[str] = Counter()

    events = print_events(
        lambda show_work: sending(run(sources, options, others=others, show_work=show_work)), output, options.dry_run
    )
    print_others(+others, output)
    if not events and options.only:
        output.line(f"nothing is rejected with, or in review for, {', '.join(sorted(options.only))}")
        return []
    if not events and options.shard is not None and (options.dry_run or (options.library / SHARD_RECORD).is_file()):
        output.line(f"shard {options.shard} has none of the inputs")
        return []
    if not events:
        raise no_mesh_found(sources)
    if options.dry_run and not output.as_json:
        print_counts(events, sum(event.count for event in events if event.kind == "kept"), output)
    elif not output.as_json or explain:
        print_summary(events, options.library, output, explain)
    return events


def _codes(words: list[str] | None) -> frozenset[str]:
    from casa_assets.library.review import SUBJECTS

    for word in words or ():
        if word not in SUBJECTS and not re.fullmatch(r"[A-Z]{3}[0-9]{3}", word):
            raise typer.BadParameter(f"{word!r} is no code such as FLT005, and none of {', '.join(SUBJECTS)}")
    return frozenset(words or ())


def _shard(words: str) -> Shard | None:
    from casa_assets.ingest.run.shards.record import Shard

    try:
        return Shard.parse(words) if words else None
    except CasaError as error:
        raise typer.BadParameter(str(error), param_hint="--shard") from None


def _guards(megabytes: float, faces: int, pixels: int, million_pixels: float) -> dict[str, float]:
    """Limits of the registry that this run changes; what is 0 stays as it is."""
    limits = {
        "input_bytes": megabytes * 1e6,
        "input_faces": faces,
        "input_texture_px": pixels,
        "input_texture_pixels": million_pixels * 1e6,
    }
    return {name: value for name, value in limits.items() if value}


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
