"""Assets per minute with one and two workers, seconds per asset, and where the time goes.

    ./dev bench ingest_throughput [folder of meshes] [--jobs 1 2]

Each run starts from an empty library, so that nothing is taken from the cache. Writes out/bench/ingest_throughput.json
and .md, and prints the latter.
"""

from __future__ import annotations

import argparse
import os
import platform
import shutil
import statistics
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from benchmarks.ingest.judging.inputs import brief, dump
from casa_assets import registry
from casa_assets.checks.package.package import Package
from casa_assets.checks.run import run as run_checks
from casa_assets.errors import Rejected
from casa_assets.export import mjcf
from casa_assets.export.usd.document import write as write_usd
from casa_assets.ingest.load import load
from casa_assets.ingest.sources.bundle import collect
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.found import Found
from casa_assets.pipeline.ingest.run import Options, ingest
from casa_assets.pipeline.ingest.stages import STAGES
from casa_assets.pipeline.library.asset_package import PREVIEW_PX, thumbnail
from casa_assets.pipeline.library.library import Library, write_files
from casa_assets.pipeline.reports.entry import entries
from casa_assets.preview.still import render
from casa_assets.preview.studio import View


@dataclass(frozen=True)
class Run:
    """One run over the folder, from the start of the workers to the written index."""

    jobs: int
    inputs: int
    accepted: int
    seconds: float
    per_minute: float
    gaps_s: tuple[float, ...]


class Stopwatch:
    """Adds up seconds by name."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)

    @contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        begin = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] += time.perf_counter() - begin


def whole(folder: Path, out: Path, jobs: int) -> Run:
    """Ingest everything into an empty library."""
    shutil.rmtree(out, ignore_errors=True)
    begin = before = time.monotonic()
    gaps, accepted = [], 0
    for event in ingest([folder], Options(library=out, jobs=jobs)):
        now = time.monotonic()
        gaps.append(round(now - before, 3))
        before, accepted = now, accepted + (event.kind == "accepted")
    seconds = time.monotonic() - begin
    return Run(jobs, len(gaps), accepted, round(seconds, 1), round(60 * len(gaps) / seconds, 1), tuple(gaps))


def by_stage(folder: Path, library: Path) -> dict[str, float]:
    """Seconds in each stage, summed over the inputs, in this process, one at a time.

    Args:
        library: of an earlier run, for the category of each input.
    """
    known = registry.load()
    categories = {entry.source_path: entry.category for entry in entries(Library(library))}
    watch = Stopwatch()
    for found in discover([folder]):
        if isinstance(found, Found):
            with tempfile.TemporaryDirectory(prefix="casa_bench_") as place:
                try:
                    _one(found, known.category(categories.get(found.source.path, registry.FALLBACK)).id, place, watch)
                except Rejected:
                    continue  # what it took until then counts
    return dict(watch.seconds)


def _one(found: Found, category: str, place: str, watch: Stopwatch) -> None:
    known = registry.load()
    with watch("load"):
        bundle = collect(found, known.limits)
        told = brief(found, bundle, known.category(category))
        result: Any = load(bundle, known.limits)
    for stage in STAGES[1:]:
        with watch(stage.name):
            result = stage.function(result, told)
    asset, _ = result
    root = Path(place) / asset.id
    with watch("mjcf"):
        write_files(root, mjcf.write(asset))
    with watch("preview"):
        picture = thumbnail(render(root / "model.xml", View(size_px=PREVIEW_PX)))
    with watch("usd"):
        write_files(root, write_usd(asset, picture))
    with watch("checks"):
        run_checks(asset, asset.id, known.limits)
        run_checks(Package(asset, told.category, root), asset.id, known.limits)


def report(runs: list[Run], stages: dict[str, float], folder: str) -> str:
    """Markdown."""
    cores = len(os.sched_getaffinity(0))
    lines = ["# Ingest throughput", ""]
    lines += [f"`{folder}`. Machine: {platform.machine()}, {cores} cores, Python {platform.python_version()}.", ""]
    lines += ["| workers | inputs | accepted | seconds | inputs per minute |", "|---|---|---|---|---|"]
    lines += [f"| {r.jobs} | {r.inputs} | {r.accepted} | {r.seconds:.1f} | {r.per_minute:.1f} |" for r in runs]
    single = next((r for r in runs if r.jobs == 1 and r.inputs > 1), None)
    if single is not None:
        middle, p95 = (
            statistics.median(single.gaps_s),
            statistics.quantiles(single.gaps_s, n=20, method="inclusive")[-1],
        )
        lines += ["", f"One worker: median {middle:.1f} s per input, 95th percentile {p95:.1f} s."]
    total = sum(stages.values())
    lines += ["", "| stage | seconds | share |", "|---|---|---|"]
    for name, seconds in sorted(stages.items(), key=lambda item: -item[1]):
        lines.append(f"| {name} | {seconds:.1f} | {seconds / total:.0%} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Parse, run, write, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", default=Path("examples/meshes"), help="meshes, any layout")
    parser.add_argument("--jobs", type=int, nargs="+", default=[1, 2], help="numbers of workers")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), help="where results go")
    given = parser.parse_args()
    library = given.out / "throughput_library"
    runs = [whole(given.folder, library, jobs) for jobs in given.jobs]
    stages = by_stage(given.folder, library)
    dump(given.out / "ingest_throughput.json", {"runs": [asdict(r) for r in runs], "stages_s": stages})
    text = report(runs, stages, given.folder.as_posix())
    (given.out / "ingest_throughput.md").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
