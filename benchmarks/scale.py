"""How an ingest run spreads: one worker against two, Ray against the pool of this machine, and the model of a run.

    ./dev bench scale                     30 inputs made of the sample meshes, in five runs, ten minutes
    ./dev bench scale --inputs FOLDER     meshes of one's own
    ./dev bench scale --copies 5          so many of each sample, each a little larger than the one before

Prints seconds of each run, the efficiency of two workers, what Ray costs beside the local pool (where it is installed),
and how far the model of `pipeline/ingest/forecast.py` is off. Two cores of a virtual machine are often two threads of
one, and share memory and caches in any case: so two workers of one run are compared with two runs of one worker each,
side by side. Ends with what runs on clusters would take by that model. Idle cores, please.
"""

from __future__ import annotations

import argparse
import importlib.util
import multiprocessing
import shutil
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from casa_assets.core.typing import Floats
from casa_assets.pipeline.ingest.forecast import Overheads, forecast
from casa_assets.pipeline.ingest.job import Event
from casa_assets.pipeline.ingest.run import Options, ingest
from casa_assets.pipeline.workers.engine import RayCluster, Workers

SAMPLES = Path(__file__).parents[1] / "examples" / "meshes"
SUFFIXES = {".glb", ".obj", ".ply", ".stl", ".gltf"}
GROWTH = 1.07  # of each copy of a sample: another asset, and not a copy
CORES = (1, 8, 64, 512, 1_000, 10_000)
HEADS = ("seconds", "first after", "processor s", "of workers", "leading s")
COUNTS = (10_000, 800_000, 10_000_000)


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
    def costs(self) -> Floats:
        """Seconds of the clock that each input took a worker, in the order of the inputs."""
        ordered = sorted(self.events, key=lambda event: event.path)
        return np.array([event.cost.clock_s if event.cost else 0.0 for event in ordered])

    @property
    def cpu_s(self) -> float:
        """Processor seconds of all inputs."""
        return sum(event.cost.cpu_s for event in self.events if event.cost)


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--inputs", type=Path)
    parser.add_argument("--copies", type=int, default=3)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="casa-scale-") as folder:
        inputs = given.inputs or scaled_samples(Path(folder), given.copies)
        kinds: dict[str, Workers] = {"local, 1 worker": 1, "local, 2 workers": 2}
        if importlib.util.find_spec("ray") is not None:
            kinds |= {"Ray, 1 worker": RayCluster(most=1), "Ray, 2 workers": RayCluster(most=2)}
        runs: dict[str, Run] = {}
        print(f"{'run':18} {'inputs':>7}" + "".join(f"{head:>13}" for head in HEADS))
        for name, kind in kinds.items():
            one = runs[name] = run(inputs, Path(folder) / f"library {name}", kind)
            numbers = (one.seconds, one.first_s, one.cpu_s, one.costs.sum(), one.lead_s)
            print(f"{name:18} {len(one.events):7}" + "".join(f"{number:13.1f}" for number in numbers), flush=True)
        apart = apart_s(inputs, Path(folder))
    single, double = runs["local, 1 worker"], runs["local, 2 workers"]
    print(f"\nefficiency of two workers beside one: {single.seconds / double.seconds / 2:.2f}")
    print(f"two runs side by side, one worker and every other input each: {apart:.1f} s; these cores can do no better,")
    print(f"so the efficiency of two workers of one run is {apart / double.seconds:.2f}")
    print_engines(runs)
    overheads = measured_overheads(single)
    print(f"\nseconds besides the work, of the run with one worker: {overheads}")
    print_clusters(single.costs, overheads)


def print_engines(runs: dict[str, Run]) -> None:
    """Compare Ray with the local pool, and each run with what the model says of it.

    The model is told what the same inputs took a worker under the other engine, with as many workers, and what a run
    of the same engine with one worker takes besides the work.
    """
    for count in (1, 2):
        word = f"{count} worker" + "s" * (count > 1)
        for name, other in (("local", "Ray"), ("Ray", "local")):
            if f"{other}, {word}" not in runs:
                continue
            one, beside = runs[f"{name}, {word}"], runs[f"{other}, {word}"]
            if name == "Ray":
                print(f"Ray beside the local pool, {word}: {100 * (one.seconds / beside.seconds - 1):+.0f} %")
            overheads = measured_overheads(runs[f"{name}, 1 worker"])
            predicted = forecast(beside.costs, len(one.events), count, overheads).seconds
            error = f"{100 * (predicted / one.seconds - 1):+.0f} %"
            note = " (what it takes besides the work is of this very run)" if count == 1 else ""
            print(f"model of {name}, {word}: {predicted:.1f} s, {error}{note}")


def apart_s(inputs: Path, folder: Path) -> float:
    """Seconds of two runs side by side that know nothing of each other, with one worker and half of the inputs each."""
    halves = [folder / "even", folder / "odd"]
    for place, half in enumerate(halves):
        half.mkdir()
        for path in sorted(inputs.iterdir())[place::2]:
            shutil.copy(path, half)
    spawn = multiprocessing.get_context("spawn")
    processes = [spawn.Process(target=run, args=(half, folder / f"library {half.name}", 1)) for half in halves]
    begin = time.perf_counter()
    for process in processes:
        process.start()
    for process in processes:
        process.join()
        assert process.exitcode == 0
    return time.perf_counter() - begin


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


def run(inputs: Path, library: Path, workers: Workers) -> Run:
    """Ingest into a fresh library."""
    begin, before = time.perf_counter(), time.process_time()
    first: list[float] = []

    def show_work(_: str) -> None:
        first.append(time.perf_counter() - begin)

    events = list(ingest([inputs], Options(library, jobs=workers, keep_duplicates=True), show_work=show_work))
    return Run(time.perf_counter() - begin, first[0], time.process_time() - before, events)


def measured_overheads(single: Run) -> Overheads:
    """Of a run with one worker: what is left of its seconds are those between two jobs."""
    count = len(single.events)
    read_s = float(np.mean([event.seconds.get("read", 0.0) for event in single.events]))
    rest = max(0.0, single.seconds - single.first_s - float(single.costs.sum()))
    return Overheads(max(0.0, single.first_s - count * read_s), read_s, rest / count, 0.0, single.lead_s / count)


def print_clusters(costs: Floats, overheads: Overheads) -> None:
    """What the model says of clusters, for inputs like these."""
    heads = " ".join(f"{f'{cores:,} cores':>16}" for cores in CORES)
    print(f"\nhours of the clock, and the share of the cores in use\n{'inputs':>12} {heads}")
    for count in COUNTS:
        row = [forecast(costs, count, cores, overheads) for cores in CORES]
        print(f"{count:12,} " + " ".join(f"{one.seconds / 3600:10.3g} {100 * one.busy:4.0f}%" for one in row))


if __name__ == "__main__":
    main()
