"""The articulation benchmark: what `casa_assets.articulate` finds, scored by the benchmark's own score.py.

    CASA_SHARED=/path/to/shared ./dev bench articulate [--variant input welded fused] [--suite core]
        [--every 4] [--only regex] [--cases FOLDER]

Prints the table of score.py for each variant and per type, of all cases and of those of its core suite, seconds of the
processor per mesh, and how often the frame was right. `--predict OUT.json` runs the whole command on any folder of
cases, also without ground truth, and writes predictions in the format of score.py (benchmarks/articulate/predict.py).
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from benchmarks.articulate.predict import predict
from benchmarks.articulate.score import load_score, looked_at, unpacked


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--variant", nargs="+", default=["input", "welded", "fused"])
    parser.add_argument("--suite", default="all")
    parser.add_argument("--only", help="Regular expression of the names.")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--cases", type=Path, help="Folder in which the cases are unpacked, or to unpack them in.")
    parser.add_argument("--predict", type=Path, metavar="OUT.json", help="Run the whole command; write what it finds.")
    parser.add_argument("--jobs", type=int, default=2, help="Processes of --predict.")
    parser.add_argument("--anonymous", action="store_true", help="With --predict: hide the names of files and folders.")
    args = parser.parse_args()
    if args.predict is not None and args.cases is None:
        parser.error("--predict needs --cases")
    with tempfile.TemporaryDirectory() as scratch:
        score = None if args.predict is not None else load_score(unpacked(args.cases or Path(scratch)))
        for variant in args.variant:
            if score is not None:
                run(score, variant, score.case_names(args.suite, args.only)[:: args.every])
                continue
            several = len(args.variant) > 1
            out = args.predict.with_stem(f"{args.predict.stem}_{variant}") if several else args.predict
            predict(args.cases, variant, out, args.jobs, args.anonymous, args.only or "", args.every)


def run(score: ModuleType, variant: str, names: list[str]) -> None:
    """Score and print one variant: all cases, those of the core suite, and each category; then each type."""
    done = [looked_at(score, name, variant) for name in names]
    seconds = [d["took"] for d in done]
    print(f"\n== {variant}: {len(names)} cases; frame right {sum(d['right'] for d in done)}; seconds", end=" ")
    print(f"median {np.median(seconds):.2f} p95 {np.percentile(seconds, 95):.2f}")
    rows: list[dict[str, Any]] = [d["row"] for d in done]
    core = set(score.case_names("core"))
    inner = [r for r in rows if r["name"] in core]
    some = 0 < len(inner) < len(rows)
    groups = [score.summarise(rows, "ALL"), *([score.summarise(inner, "core")] if some else [])]
    kinds = sorted({r["category"] for r in rows})
    groups += [score.summarise([r for r in rows if r["category"] == k], k) for k in kinds]
    print(f"{score.table(groups)}\n\n{score.by_type(rows)}")
    if some:
        print(f"\ncore alone\n{score.by_type(inner)}")


if __name__ == "__main__":
    main()
