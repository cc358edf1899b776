"""Builds members of categories of objects, runs every check on them, and prints what they cost, by category.

    ./dev bench objects                                   4 members of each category
    ./dev bench objects --count 17 --library out/objects  as many as a full library has of each, and keep them
    ./dev bench objects --category apple mug --jobs 1     some, on one core

Seconds are wall time of one member in its process: `build` is numbers to Asset with its pictures painted or taken from
the cache, `write` both formats, `draw` the thumbnail, `check` every check; CPU is the processor time of all of it.
Faces are those that are seen, shapes those that collide, MB the files of a member. A row has medians, and the most
shapes that a member has; the last row is of all members, and below it stands what they come to. Each run begins with
an empty library. `--library` names a new folder where it stays; `casa-assets objects build` goes on from there. The
exit code is 1 where a member fails a check.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from casa_assets.cli.output import Output, TextTable
from casa_assets.cli.verbs.families import print_member
from casa_assets.core.system import CACHE_VARIABLE as CACHE
from casa_assets.families.build import FamilyResult, build_all, object_requests
from casa_assets.library.entry_files import read_certificate

MEGABYTE = 1e6


@dataclass(frozen=True)
class Cost:
    """What one member costs: seconds of its four steps and of the processor, faces, shapes, bytes of its folder."""

    category: str
    seconds: tuple[float, float, float, float, float]
    faces: int
    shapes: int
    size_bytes: int


def cost_of(result: FamilyResult) -> Cost:
    """The cost of a member that passed. Raises OutputError where its folder is damaged."""
    summary = read_certificate(Path(result.folder)).summary
    seconds = result.build_s, result.write_s, result.draw_s, result.check_s, result.cpu_s
    return Cost(result.request.family, seconds, summary.faces, summary.colliders, result.size_bytes)


def row(name: str, costs: list[Cost]) -> tuple[str, ...]:
    """Medians of the costs as text, beginning with a name."""
    shapes = [c.shapes for c in costs]
    return (
        name,
        str(len(costs)),
        *(f"{median(column):.2f}" for column in zip(*(c.seconds for c in costs), strict=True)),
        f"{median(c.faces for c in costs):.0f}",
        f"{median(shapes):.0f}",
        str(max(shapes)),
        f"{median(c.size_bytes for c in costs) / MEGABYTE:.2f}",
    )


def totals(costs: list[Cost], wall_s: float) -> str:
    """What all members come to, one line."""
    megabytes = sum(c.size_bytes for c in costs) / MEGABYTE
    per_minute = 60 * len(costs) / wall_s
    return (
        f"{len(costs)} members in {len({c.category for c in costs})} categories, {wall_s:.0f} s of wall time, "
        f"{sum(c.seconds[-1] for c in costs):.0f} s of processor, {per_minute:.0f} a minute, {megabytes:.0f} MB"
    )


def main() -> int:
    """Build, print, and say whether all passed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--category", nargs="*", default=[], help="categories; all where none is named")
    parser.add_argument("--count", type=int, default=4, help="members of each")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=0)
    parser.add_argument("--library", type=Path, help="a folder that does not exist yet, for the members to stay in")
    options = parser.parse_args()
    if options.library and options.library.exists():
        parser.error(f"--library: {options.library} exists; what it has would not be built, so name a new folder")
    output = Output()
    with tempfile.TemporaryDirectory() as folder:
        os.environ[CACHE] = str(Path(folder) / "cache")  # textures are painted, too
        requests = object_requests(options.category, options.count, options.seed)
        begin = time.monotonic()
        library = options.library or Path(folder) / "objects"
        results = list(build_all(requests, library, options.jobs, drawn=False))
        wall_s = time.monotonic() - begin
        wrong = [r for r in results if not r.passed]
        for result in wrong:
            print_member(result, output)
        costs = [cost_of(r) for r in results if r.passed and not r.is_kept]
    steps = ("build s", "write s", "draw s", "check s", "CPU s")
    heads = ("passed", *steps, "faces", "shapes", "most", "MB")
    table = TextTable(("category", *heads), right=heads)
    for name in sorted({c.category for c in costs}):
        table.add(*row(name, [c for c in costs if c.category == name]))
    if costs:
        table.add(*row("all", costs))
        table.print(output.console)
        output.line(totals(costs, wall_s))
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
