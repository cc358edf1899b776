"""Seconds, memory and bytes of tables of 1,000,000 entries, and of books over thousands of real folders.

    ./dev bench books [--count 1000000] [--libraries 20] [--folders 3000] [--out out/bench]

Entries are synthetic. They are drawn by chance: a category of the registry each, some of which have very many (the
n-th most frequent of them has 1/n as many as the first); sizes and masses about the usual ones; 15 in 100 are rejected,
one in 12 of the others is in review, every second has advice; of twenty libraries. They enter where entries enter that
were read from folders, so the time that a million folders take is not in these numbers: it is measured beside them with
`--folders` folders, each with an asset.json of 60 results of checks and a signature. Each step is a process of its own,
of which are told: seconds on the clock, of those the seconds of processors, the most memory, bytes on the disk.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

from benchmarks.ingest.again import ingest, make_library
from casa_assets import registry
from casa_assets.model.issue import REVIEW_CODE, Issue, Severity, Tally
from casa_assets.pipeline.library import entry_table
from casa_assets.pipeline.library.library import Library, Summary
from casa_assets.pipeline.reports.entry import Entry
from casa_assets.pipeline.tables import parquet

ROOT = Path(__file__).resolve().parents[1]
REJECTED_SHARE, REVIEW_SHARE, ADVICE_SHARE = 0.15, 1 / 12, 0.5
# Reasons of rejections with their weights.
REASONS = {"RUN007": 40, "MSH002": 15, "SRC002": 10, "AST009": 10, "FLT005": 10, "RUN001": 8, "RUN002": 5, "SRC004": 2}
ADVICE = ("SRC042", "GEO004", "FLT010")
SUBJECTS = ("scale", "mass", "category", "up_axis")
LICENCES = ("CC-BY-4.0", "CC0-1.0", "CC-BY-NC-4.0", "unknown")
SOURCES = ("objaverse", "folder", "manifest")
WORDS = ("red", "old", "small", "low poly", "scan", "antique", "kitchen", "set", "plain", "v2")
# Categories that are asked for, and their place among all, the most frequent one first: about 8,000 in a million.
ASKED, PLACE = ("mug", "bowl"), 20
BLANK: dict[str, Any] = {field.name: "" for field in fields(Entry)} | {
    "accepted": False, "summary": None, "warnings": (), "results": (), "guesses": (), "checks": Tally(), "colors": (),
    "is_whole": True,
}  # fmt: skip
QUERIES = {
    "category": ["--where", "category=mug"],
    "reason": ["--where", "reason=FLT005"],
    "size": ["--where", "size<=0.05"],
    "category, size and mass": ["--where", "category=mug", "--where", "size<=0.1", "--where", "mass>0.3"],
    "words": ["red mug"],
}


def main() -> int:
    """Run each step in a process of its own, and print what it took."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--libraries", type=int, default=20)
    parser.add_argument("--folders", type=int, default=3_000)
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "bench")
    parser.add_argument("--step", choices=STEPS, help="Do this alone in --out; a child of this benchmark.")
    asked = parser.parse_args()
    if asked.step:
        STEPS[asked.step](asked.out, asked.count, asked.libraries)
        return 0
    asked.out.mkdir(parents=True, exist_ok=True)
    print(f"cores: {len(os.sched_getaffinity(0))}, load: {os.getloadavg()[0]:.1f}")
    print(f"{'step':44} {'clock s':>8} {'processors s':>13} {'memory MB':>10} {'disk MB':>9}")
    with tempfile.TemporaryDirectory(dir=asked.out) as place:
        folder = Path(place)
        numbers = ["--count", str(asked.count), "--libraries", str(asked.libraries)]
        own = [sys.executable, "-m", "benchmarks.books", "--out", place, *numbers, "--step"]
        casa = [sys.executable, "-m", "casa_assets.cli.main"]
        tables = folder / "tables"
        timed(f"draw {asked.count:,} entries and drop them", [*own, "draw"])
        timed("write them as Parquet parts", [*own, "parquet"], tables)
        timed("again, one of the libraries has changed", [*own, "again"], tables)
        if asked.folders:
            of_folders(folder / "folders", asked.folders, casa)
    return 0


def timed(name: str, command: list[str], written: Path | None = None, codes: tuple[int, ...] = (0,)) -> float:
    """Run a command in a process of its own and print what it took; returns seconds of processors.

    Args:
        written: folder whose bytes are counted. codes: exit codes that are no failure.
    """
    begin = time.perf_counter()
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen(command, cwd=ROOT, stdout=output, stderr=subprocess.STDOUT)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        clock = time.perf_counter() - begin
        output.seek(0)
        text = output.read().decode()
    if process.returncode not in codes:
        raise subprocess.CalledProcessError(process.returncode, command, text)
    cpu = used.ru_utime + used.ru_stime
    disk = f"{size_of(written) / 1e6:9.0f}" if written is not None else ""
    print(f"{name:44} {clock:8.1f} {cpu:13.1f} {used.ru_maxrss / 1e3:10.0f} {disk}", flush=True)
    return cpu


def size_of(folder: Path) -> int:
    """Bytes of all files below a folder."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def synthetic_entries(count: int, seed: int = 0) -> Iterator[Entry]:
    """Entries drawn by chance, the same each time for a seed."""
    draw = random.Random(seed)
    known = registry.load().categories
    names = sorted(known.keys() - set(ASKED))
    random.Random(0).shuffle(names)
    names[PLACE:PLACE] = ASKED
    categories = [(name, known[name]) for name in names]
    chosen = draw.choices(categories, [1 / (i + 1) for i in range(len(categories))], k=count)
    reasons = draw.choices(list(REASONS), list(REASONS.values()), k=count)
    for number, (name, category) in enumerate(chosen):
        sha256 = hashlib.sha256(f"{seed} {number}".encode()).hexdigest()
        made: dict[str, Any] = {
            "id": f"{name}_{sha256[:10]}",
            "category": name,
            "source": draw.choices(SOURCES, (8, 1, 1))[0],
            "source_path": f"glbs/000-{number % 160:03}/{sha256[:32]}.glb",
            "sha256": sha256,
            "title": f"{draw.choice(WORDS)} {name.replace('_', ' ')} {draw.choice(WORDS)}",
            "author": f"author {draw.randrange(50_000)}",
            "licence": draw.choices(LICENCES, (80, 10, 5, 5))[0],
            "producer": "ingest",
            "cache_key": "5" * 64,
        }
        is_good = draw.random() >= REJECTED_SHARE
        made |= _accepted(category, draw) if is_good else {"code": reasons[number], "message": "is broken; mend it"}
        made["path"] = f"{name if is_good else 'rejected'}/{made['id']}"
        made["digest"] = sha256[::-1] if is_good else ""
        yield Entry(**{**BLANK, **made})


def _accepted(category: Any, draw: random.Random) -> dict[str, Any]:
    longest = category.longest_m.typical * draw.lognormvariate(0, 0.25)
    summary = Summary.model_construct(
        extents=tuple([longest * share for share in category.shape]),
        mass=category.mass_kg.typical * draw.lognormvariate(0, 0.4),
        colliders=draw.randint(1, 32),
        hull_vertices=64,
        faces=draw.randint(100, 20_000),
    )
    warnings = []
    if draw.random() < REVIEW_SHARE:
        warnings.append((REVIEW_CODE, draw.choice(SUBJECTS)))
    if draw.random() < ADVICE_SHARE:
        warnings.append((draw.choice(ADVICE), ""))
    return {
        "accepted": True,
        "summary": summary,
        "split": "test" if draw.random() < 0.2 else "train",
        "checks": Tally(58, len(warnings), 1, 14, len(warnings)),
        "colors": ((draw.choice(("red", "white", "grey", "brown")), 0.7), ("black", 0.2)),
        "warnings": tuple(
            [Issue.model_construct(code=c, severity=Severity.WARNING, pointer=p, message="") for c, p in warnings]
        ),
    }


def draw_only(_: Path, count: int, __: int) -> None:
    """Draw entries: what the other steps that draw take for it."""
    for _entry in synthetic_entries(count):
        pass


def write_parquet(out: Path, count: int, libraries: int) -> None:
    """Write the parts of all libraries."""
    places = [Library(out / "libraries" / f"shard_{number:02}") for number in range(libraries)]
    for place in places:
        (place.root / "mug").mkdir(parents=True, exist_ok=True)  # its time tells whether it has changed
    numbers = {place.root: number for number, place in enumerate(places)}

    def entries_of(library: Library) -> Iterator[Entry]:
        return synthetic_entries(count // libraries, numbers[library.root])

    parquet.write_index(places, out / "tables", entries_of=entries_of)


def write_again(out: Path, count: int, libraries: int) -> None:
    """The same after one of the libraries has changed."""
    os.utime(out / "libraries" / "shard_00" / "mug")
    write_parquet(out, count, libraries)


STEPS: dict[str, Callable[[Path, int, int], None]] = {
    "draw": draw_only,
    "parquet": write_parquet,
    "again": write_again,
}


def of_folders(folder: Path, count: int, casa: list[str]) -> None:
    """Books over folders of entries, which are a shard of small meshes, and what a merge of that takes."""
    inputs, shard, merged, tables = folder / "inputs", folder / "shard", folder / "merged", folder / "tables"
    inputs.mkdir(parents=True)
    make_library(inputs, shard, count, "--shard", "1/1")
    ingest(inputs, shard, "--shard", "1/1")
    print(f"{count:,} folders, of one entry each; a shard")
    merge = [*casa, "library", "merge", str(shard), "--library", str(merged), "--quiet"]
    each = {"library merge": timed("library merge", merge, codes=(0, 1, 4))}
    write = [*casa, "library", "index", str(merged), "--out", str(tables)]
    (merged / ".casa" / "cache" / entry_table.NAME).unlink()
    each["library index, files are opened"] = timed("library index, files are opened", write, tables)
    each["library index --force, table of entries"] = timed("library index, out of the table", [*write, "--force"])
    each["library index, nothing has changed"] = timed("library index, nothing has changed", write)
    for name, words in QUERIES.items():
        each[f"find by {name}"] = timed(
            f"find by {name}", [*casa, "find", *words, "--library", str(merged)], codes=(0, 1)
        )
    for name, seconds in each.items():
        print(f"  {name}: {1e3 * seconds / count:.2f} ms of processors for each entry, with the start of the command")


if __name__ == "__main__":
    sys.exit(main())
