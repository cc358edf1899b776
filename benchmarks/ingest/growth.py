"""Seconds that a run of ten new inputs takes in a library that holds very many assets already.

    ./dev bench ingest_growth [--count 20000] [--new 10] [--out out/bench]

Ingests one box, then copies its entry under other ids, each with a signature, a digest and a source of its own: the
numbers of its form are moved at random, so far that most have no neighbour and some have a few, as in a library of many
things. Meshes and pictures are hard links. Then it times: the first run on that library, whose table of entries has to
be built; a run with `--new` more boxes; one more run with nothing new. Exit 1 where the second takes a minute or more.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.ingest.judging.copies import copied_entry
from tests.libraries import box_obj, casa

ROOT = Path(__file__).resolve().parents[2]
MOST_S = 60.0


def main() -> int:
    """Make the library and print the seconds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=20_000)
    parser.add_argument("--new", type=int, default=10)
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "bench")
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=asked.out) as place:
        work = Path(place)
        library = work / "library"
        _inputs(work / "first", 1, 0)
        _timed(work / "first", library)
        begin = time.monotonic()
        _grow(library, asked.count)
        print(f"{asked.count} entries made in {time.monotonic() - begin:.0f} s")
        _inputs(work / "warm", 1, 1)
        print(f"first run on it, one new input: {_timed(work / 'warm', library):.1f} s")
        _inputs(work / "new", asked.new, 2)
        seconds = _timed(work / "new", library)
        print(f"{asked.new} new inputs: {seconds:.1f} s (target below {MOST_S:.0f})")
        print(f"nothing new: {_timed(work / 'new', library):.1f} s")
        found = json.loads((library / "library.json").read_text(encoding="utf-8"))["report"]["issues"]
        print(f"{sum(issue['code'] == 'LIB001' for issue in found)} pairs of one form among them")
    return 0 if seconds < MOST_S else 1


def _inputs(folder: Path, count: int, lot: int) -> None:
    """Boxes of different proportions."""
    folder.mkdir()
    for i in range(count):
        size = (0.05 + 0.011 * i + 0.003 * lot, 0.2 + 0.013 * i, 0.06 + 0.002 * i)
        (folder / f"box_{lot}_{i}.obj").write_text(box_obj(size), encoding="ascii")


def _timed(folder: Path, library: Path) -> float:
    begin = time.monotonic()
    done = casa("ingest", folder, "--library", library, "--category", "cereal", "--jobs", 2)
    if done.returncode not in (0, 1):
        raise subprocess.CalledProcessError(done.returncode, "casa-assets ingest", done.stdout, done.stderr)
    return time.monotonic() - begin


def _grow(library: Path, count: int) -> None:
    """Copies of the only entry."""
    (source,) = library.glob("*/*/asset.json")
    rng = np.random.default_rng(0)
    for number in range(count):
        digest = hashlib.sha256(f"entry {number}".encode()).hexdigest()
        copied_entry(source.parent, digest, f"other_{number}.obj", rng)


if __name__ == "__main__":
    sys.exit(main())
