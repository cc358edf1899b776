"""How an ingest run spreads: one worker against two.

    ./dev bench scale                     30 inputs made of the sample meshes, eleven runs, half an hour
    ./dev bench scale --inputs FOLDER     meshes of one's own
    ./dev bench scale --copies 5          so many of each sample, each a little larger than the one before
    ./dev bench scale --rounds 1          each run once instead of twice; the faster of two is what is compared

Prints seconds of each run, and the efficiency of two workers.

Efficiency compares two workers on two cores with one worker on one core: a worker that has two cores to itself uses
some of the second, since drawing and reading USD run threads. Cores share memory and caches, and those of a virtual
machine may be threads of one core. What that costs is measured apart: by two runs side by side that know nothing of
each other, one core each. Idle cores, please.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import trimesh

from casa_assets.ingest.run.run import Options, ingest
from casa_assets.runs.outcome import Event

SAMPLES = Path(__file__).parents[1] / "examples" / "meshes"
SUFFIXES = {".glb", ".obj", ".ply", ".stl", ".gltf"}
GROWTH = 1.07  # of each copy of a sample: another asset, and not a copy
ONE_CORE = "local, 1 on 1 core"
HEADS = ("seconds", "first after", "leading s")


@dataclass(frozen=True)
class Run:
    """One run.

    Attributes:
        seconds: in all. first_s: until the first input was begun. lead_s: processor time of the leading process.
    """

    seconds: float
    first_s: float
    lead_s: float
    events: list[Event]

    @property
    def work_s(self) -> float:
        """Seconds after the first input was begun."""
        return self.seconds - self.first_s


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--inputs", type=Path)
    parser.add_argument("--copies", type=int, default=3)
    parser.add_argument("--rounds", type=int, default=2)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="casa-scale-") as folder:
        inputs = given.inputs or scaled_samples(Path(folder), given.copies)
        kinds: dict[str, int] = {ONE_CORE: 1, "local, 1 worker": 1, "local, 2 workers": 2}
        first_run(inputs, Path(folder))
        runs: dict[str, Run] = {}
        print(f"{'run':18} {'inputs':>7}" + "".join(f"{head:>13}" for head in HEADS))
        for turn in range(given.rounds):
            for name, kind in kinds.items():
                with on_core(0 if name == ONE_CORE else None):
                    one = run(inputs, Path(folder) / f"library {name} {turn}", kind)
                numbers = (one.seconds, one.first_s, one.lead_s)
                print(f"{name:18} {len(one.events):7}" + "".join(f"{number:13.1f}" for number in numbers), flush=True)
                runs[name] = min(one, runs.get(name, one), key=lambda each: each.seconds)
        apart = apart_s(inputs, Path(folder))
    pinned, single, double = runs[ONE_CORE], runs["local, 1 worker"], runs["local, 2 workers"]
    efficiency, bound = pinned.seconds / double.seconds / 2, pinned.work_s / apart
    print(f"\nefficiency of two workers on two cores, beside one worker on one core: {efficiency:.2f}")
    print(f"the inputs take a worker {pinned.work_s:.1f} s on one core, and {apart:.1f} s with another run on the")
    print(f"other core: two of these cores do {bound:.2f} of twice what one does, whatever runs on them;")
    print(f"efficiency of two workers, of what these cores can do: {efficiency / bound:.2f}")
    print(f"beside one worker that may use both cores: {single.seconds / double.seconds / 2:.2f}")


def first_run(inputs: Path, folder: Path) -> None:
    """Ingest one input, so that none of the measured runs has to load what the leading process needs."""
    only = folder / "first"
    only.mkdir()
    shutil.copy(min(inputs.iterdir()), only)
    run(only, folder / "library first", 1)


@contextmanager
def on_core(number: int | None) -> Iterator[None]:
    """Keep this process, and all that it starts meanwhile, on one of its cores; None: leave it where it is."""
    cores = os.sched_getaffinity(0)
    try:
        if number is not None:
            os.sched_setaffinity(0, {sorted(cores)[number % len(cores)]})
        yield
    finally:
        os.sched_setaffinity(0, cores)


def run_on_core(number: int, inputs: Path, library: Path) -> Run:
    """Ingest into a fresh library with one worker, all on one core."""
    with on_core(number):
        return run(inputs, library, 1)


def apart_s(inputs: Path, folder: Path) -> float:
    """Seconds that all inputs take a worker where two runs go on side by side, a core and half of the inputs each."""
    halves = [folder / "even", folder / "odd"]
    for place, half in enumerate(halves):
        half.mkdir()
        for path in sorted(inputs.iterdir())[place::2]:
            shutil.copy(path, half)
    libraries = [folder / f"library {half.name}" for half in halves]
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as processes:
        return sum(one.work_s for one in processes.map(run_on_core, (0, 1), halves, libraries))


def scaled_samples(folder: Path, copies: int) -> Path:
    """The sample meshes, each several times in sizes of their own."""
    inputs = folder / "inputs"
    inputs.mkdir()
    for path in sorted(SAMPLES.iterdir()):
        if path.suffix not in SUFFIXES:
            continue
        try:
            mesh = trimesh.load(path, force="mesh")
        except Exception:  # noqa: BLE001  one of them is broken on purpose
            continue
        for number in range(copies):
            mesh.apply_scale(GROWTH)
            mesh.export(inputs / f"{path.stem}_{number}.glb")
    return inputs


def run(inputs: Path, library: Path, workers: int) -> Run:
    """Ingest into a fresh library."""
    begin, before = time.perf_counter(), time.process_time()
    first: list[float] = []

    def show_work(_: str) -> None:
        first.append(time.perf_counter() - begin)

    events = list(ingest([inputs], Options(library, jobs=workers, keep_duplicates=True), show_work=show_work))
    return Run(time.perf_counter() - begin, first[0], time.process_time() - before, events)


if __name__ == "__main__":
    main()
