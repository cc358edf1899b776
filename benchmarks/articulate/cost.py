"""What `casa-assets articulate` costs, and what it finds where nothing moves: each mesh in a process of its own.

    ./dev bench articulate_cost MESH_OR_FOLDER... [--every 3] [--parts] [--none] [--core 0]

Prints for each mesh the seconds and the peak of memory of the whole command (reading, taking apart, writing, pictures,
checks), then median and p95 of both; `--parts` lists what moves, and `--none` says that nothing should: every part
found is then counted as false. Seconds are those of the processor as well as those of the clock, which on a machine at
work are more. `--core` keeps every process to one core.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import resource
import shutil
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from casa_assets.articulate.run.build import ArticulateRequest
from casa_assets.articulate.run.steps import ArticulateOutcome, articulate_one

SUFFIXES = frozenset({".obj", ".glb", ".gltf", ".ply", ".stl", ".dae"})
# What ends in one of these is no input: the tool would have been killed.
LONGEST_S = 600.0


@dataclass(frozen=True)
class Cost:
    """Of one mesh.

    Attributes:
        work_s: of the processor, after the imports; clock_s: of the clock. peak_gb: largest resident memory.
        parts: names of what moves. code: of a refusal, `died` where the process ended without an answer.
    """

    mesh: Path
    work_s: float
    clock_s: float
    peak_gb: float
    parts: tuple[str, ...]
    code: str


def meshes(places: Sequence[Path]) -> Iterator[Path]:
    """The mesh files among some paths and below them, by name; of a benchmark case that as it came in."""
    for place in places:
        if place.is_dir():
            cases = sorted(place.rglob("input.obj"))
            yield from cases or sorted(p for p in place.rglob("*") if p.suffix.lower() in SUFFIXES)
        else:
            yield place


def measured(mesh: Path, core: int | None) -> Cost:
    """The cost of one mesh, in a fresh process."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe(duplex=False)
    child = context.Process(target=_child, args=(mesh, core, theirs))
    child.start()
    theirs.close()
    try:
        answer = ours.recv() if ours.poll(LONGEST_S) else None
    except EOFError:
        answer = None
    if answer is None:
        child.kill()
    child.join()
    return answer if isinstance(answer, Cost) else Cost(mesh, 0.0, 0.0, 0.0, (), "died")


def _child(mesh: Path, core: int | None, answer: Connection) -> None:
    if core is not None and hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {core})
    out = Path(tempfile.mkdtemp())
    try:
        began, clock = time.process_time(), time.perf_counter()
        done = articulate_one(ArticulateRequest(mesh, out))
        took, clock = time.process_time() - began, time.perf_counter() - clock
    finally:
        shutil.rmtree(out, ignore_errors=True)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    found = done.articulation if isinstance(done, ArticulateOutcome) else None
    names = tuple(p.name for p in found.parts) if found is not None else ()
    answer.send(
        Cost(
            mesh,
            took,
            clock,
            peak,
            names,
            done.code if isinstance(done, ArticulateOutcome) else f"halt: {done.message}",
        )
    )


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("places", type=Path, nargs="+", metavar="MESH_OR_FOLDER")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--parts", action="store_true", help="List what moves.")
    parser.add_argument("--none", action="store_true", help="Nothing should move: count what does.")
    parser.add_argument("--core", type=int, help="Number of the core that all processes keep to.")
    args = parser.parse_args()
    costs = []
    for mesh in list(meshes(args.places))[:: args.every]:
        cost = measured(mesh, args.core)
        costs.append(cost)
        listed = f" {' '.join(cost.parts)}" if args.parts or args.none else ""
        name = "/".join(mesh.parts[-2:])
        print(f"{cost.work_s:7.1f} s {cost.clock_s:7.1f} s {cost.peak_gb:5.2f} GB", end=" ")
        print(f"{len(cost.parts):3d} parts {cost.code or 'ok':7s} {name}{listed}", flush=True)
    for word, values in (
        ("seconds of the processor", [c.work_s for c in costs]),
        ("seconds of the clock", [c.clock_s for c in costs]),
        ("GB at the peak", [c.peak_gb for c in costs]),
    ):
        median, high, most = np.percentile(values, [50, 95, 100])
        print(f"{word}: median {median:.2f}, p95 {high:.2f}, most {most:.2f} of {len(costs)} meshes")
    print(f"{sum(c.code == 'died' or c.code.startswith('halt') for c in costs)} without an answer")
    if args.none:
        wrong = [c for c in costs if c.parts]
        print(f"{sum(len(c.parts) for c in wrong)} false parts on {len(wrong)} of {len(costs)} meshes")


if __name__ == "__main__":
    main()
