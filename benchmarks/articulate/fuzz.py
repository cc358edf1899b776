"""Change meshes in ways that leave what moves as it is, and see that the whole command always ends with a result.

    ./dev bench articulate_fuzz --cases FOLDER ... [--variant input] [--minutes 60] [--jobs 2] [--out FOLDER]

Faces are written twice, shuffled, reversed, or divided; vertices are split apart; units are tiny or huge; empty and
broken groups are added; the mesh stands there two to four times, beside or inside itself. Every outcome has to be an
accepted asset, one in review, or a rejection with a reason. What ends in a traceback is kept in `--out`, and the exit
code is 1.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from pathlib import Path

import numpy as np

from benchmarks.articulate.labelled import read_obj, write_obj
from benchmarks.articulate.predict import found_by_command
from casa_assets.articulate.run.build import ArticulateRequest
from casa_assets.core.numeric import Floats, Ints

Change = Callable[[Floats, Ints, np.random.Generator], tuple[Floats, Ints]]
Random = np.random.Generator


def twice(points: Floats, faces: Ints, rng: Random) -> tuple[Floats, Ints]:
    """All faces, or half of them, once more from the other side."""
    rows = faces if rng.random() < 0.5 else faces[rng.random(len(faces)) < 0.5]
    return points, np.concatenate([faces, rows[:, ::-1]])


def shuffled(points: Floats, faces: Ints, rng: Random) -> tuple[Floats, Ints]:
    """Faces, their corners, and vertices in another order."""
    order = rng.permutation(len(points))
    place = np.argsort(order)
    return points[order], np.roll(place[faces[rng.permutation(len(faces))]], int(rng.integers(3)), axis=1)


def turned_round(points: Floats, faces: Ints, rng: Random) -> tuple[Floats, Ints]:
    """All faces, or some, wound the other way."""
    some = rng.random(len(faces)) < (1.0 if rng.random() < 0.5 else 0.3)
    return points, np.where(some[:, None], faces[:, ::-1], faces)


def divided(points: Floats, faces: Ints, rng: Random) -> tuple[Floats, Ints]:
    """Some faces divided into three at their middle."""
    some = rng.random(len(faces)) < 0.3
    middle = points[faces[some]].mean(axis=1)
    new = len(points) + np.arange(len(middle))
    thirds = [np.stack([faces[some][:, k], faces[some][:, (k + 1) % 3], new], axis=1) for k in range(3)]
    return np.concatenate([points, middle]), np.concatenate([faces[~some], *thirds])


def split_apart(points: Floats, faces: Ints, rng: Random) -> tuple[Floats, Ints]:
    """Each face with vertices of its own."""
    del rng
    return points[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)


def other_units(points: Floats, faces: Ints, rng: Random) -> tuple[Floats, Ints]:
    """In micrometres, miles, or anything between, and far from the origin."""
    size = float(np.ptp(points, axis=0).max())
    return points * 10.0 ** rng.uniform(-5, 5) + rng.choice([0.0, 20.0]) * size, faces


def with_rubbish(points: Floats, faces: Ints, rng: Random) -> tuple[Floats, Ints]:
    """Faces without area, needles, and a crumb far inside."""
    picked = faces[rng.integers(len(faces), size=5)]
    flat = np.stack([picked[:, 0], picked[:, 0], picked[:, 1]], axis=1)
    crumb = points.mean(axis=0) + 1e-5 * np.ptp(points, axis=0) * rng.random((3, 3))
    return np.concatenate([points, crumb]), np.concatenate([faces, flat, len(points) + np.arange(3)[None]])


def copies(points: Floats, faces: Ints, rng: Random) -> tuple[Floats, Ints]:
    """Two to four times, beside each other or in the same place."""
    count, step = int(rng.integers(2, 5)), np.ptp(points, axis=0) * rng.choice([0.0, 1.0, 1.2])
    step[int(rng.integers(3))] = 0.0
    moved = [points + k * step for k in range(count)]
    return np.concatenate(moved), np.concatenate([faces + k * len(points) for k in range(count)])


CHANGES: Mapping[str, Change] = {
    f.__name__: f for f in (twice, shuffled, turned_round, divided, split_apart, other_units, with_rubbish, copies)
}
Job = tuple[Path, str, int]


def changed(mesh: Path, names: str, seed: int, target: Path) -> None:
    """Write a mesh with some changes, one after the other, and empty groups between its faces."""
    rng = np.random.default_rng([seed, *mesh.parent.name.encode()])
    points, faces = read_obj(mesh)
    for name in names.split("+"):
        points, faces = CHANGES[name](points, faces, rng)
    write_obj(target, points, faces)
    lines = target.read_text(encoding="utf-8").splitlines()
    first = next((k for k, line in enumerate(lines) if line.startswith("f ")), len(lines))
    lines[first:first] = ["g nothing", "o empty", "g all"]
    target.write_text("\n".join([*lines, "g end"]) + "\n", encoding="utf-8")


def outcome(job: Job, out: Path) -> tuple[Job, str, str]:
    """Run the whole command on a changed mesh; return how it ended, and the traceback if it did not end well."""
    mesh, names, seed = job
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "in" / "mesh.obj"
        target.parent.mkdir()
        changed(mesh, names, seed, target)
        found = found_by_command(ArticulateRequest(target, Path(folder) / "out"), target)
        if found["outcome"] == "traceback":
            kept = out / f"{mesh.parent.name}_{names}_{seed}.obj"
            kept.write_bytes(target.read_bytes())
            kept.with_suffix(".txt").write_text(found["message"], encoding="utf-8")
    return job, str(found["outcome"]), str(found["message"])


def jobs(meshes: list[Path], seed: int) -> Iterator[Job]:
    """Yield changes of meshes without end: each alone, then two at random."""
    rng = np.random.default_rng(seed)
    names = list(CHANGES)
    turn = 0
    while True:
        for k, mesh in enumerate(meshes):
            one = names[(k + turn) % len(names)]
            more = "" if turn < len(names) else f"+{names[int(rng.integers(len(names)))]}"
            yield mesh, one + more, turn
        turn += 1


def main() -> int:
    """Run for some minutes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=Path, nargs="+", required=True)
    parser.add_argument("--variant", default="input")
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("out/fuzz_articulate"))
    args = parser.parse_args()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    args.out.mkdir(parents=True, exist_ok=True)
    meshes = sorted({m for folder in args.cases for m in folder.rglob(f"{args.variant}.obj")})
    if not meshes:
        parser.error(f"no {args.variant}.obj below {', '.join(map(str, args.cases))}")
    order = np.random.default_rng(args.seed).permutation(len(meshes))
    until, ends = time.monotonic() + 60 * args.minutes, Counter[str]()
    work, waiting = jobs([meshes[k] for k in order], args.seed), set[Future[tuple[Job, str, str]]]()
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(args.jobs, mp_context=spawn, max_tasks_per_child=20) as pool:
        while waiting or time.monotonic() < until:
            while len(waiting) < 2 * args.jobs and time.monotonic() < until:
                waiting.add(pool.submit(outcome, next(work), args.out))
            done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
            for (mesh, names, seed), end, message in (future.result() for future in done):
                ends[end] += 1
                if end == "traceback":
                    print(f"{mesh.parent.name} {names} {seed}: {message.strip().splitlines()[-1]}", flush=True)
    print(f"{ends.total()} changed meshes: " + ", ".join(f"{count} {end}" for end, count in sorted(ends.items())))
    return int(ends["traceback"] > 0)


if __name__ == "__main__":
    raise SystemExit(main())
