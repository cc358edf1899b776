"""Mutated files of every format, read and made into assets for a given time; tells what no input may do.

    ./dev bench fuzz_ingest [--minutes 30] [--seed 1] [--specimens FOLDER] [--only NAME,...] [--out out/fuzz]

Every case follows from the seed and its number. A finding is an error that is no rejection, a crash, a hang, more
memory than allowed, a reading of more than 10 s of processor time, or a file or address beyond the folder of the case;
its files are kept under OUT/findings with seed and number. `--wholes` cases of each batch of 200 that hold a mesh go
through all of ingest, checks included. Exit 1 where anything was found.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tests.support.fuzz.fuzz_run import Plan, Result, fuzz

ROOT = Path(__file__).resolve().parents[1]


def main() -> int:
    """Run, and print a line every few batches."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--wholes", type=int, default=2)
    parser.add_argument("--specimens", default="")
    parser.add_argument("--only", default="")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "fuzz")
    asked = parser.parse_args()
    plan = Plan(asked.seed, asked.minutes * 60, asked.out, asked.wholes, asked.specimens, asked.first, asked.only)
    result = Result()
    for batch, result in enumerate(fuzz(plan)):
        if batch % 10 == 0:
            print(_line(result), flush=True)
    print(_line(result))
    for verdict, count in sorted(result.verdicts.items(), key=lambda pair: (-pair[1], pair[0])):
        print(f"{count:>8}  {verdict}")
    for one in result.findings:
        print(f"FOUND {one.kind} seed {plan.seed} case {one.number}: {one.message.strip().splitlines()[-1][:200]}")
    return 1 if result.findings else 0


def _line(result: Result) -> str:
    kinds = f"{len(result.findings)} findings"
    return f"{result.cases} cases read, {result.wholes} whole, {kinds}, parent {result.peak_bytes / 1e6:.0f} MB at most"


if __name__ == "__main__":
    sys.exit(main())
