"""The articulation benchmark: what `casa_assets.articulate` finds, scored by the benchmark's own score.py.

    CASA_SHARED=/path/to/shared ./dev bench articulate [--variant input welded fused] [--suite core]
        [--every 4] [--only regex] [--perturb SEED] [--true-frame] [--families] [--travel] [--keep FOLDER]

Prints the table of score.py for each variant and per type, of all cases and of those of its core suite, seconds of the
processor per mesh, and how often the frame was right. `--keep` stores what each case gave and takes what is stored
there: a run can be stopped and taken up, and several may share a folder (one for each version of the tool).
`--families` scores 40 appliances of this project's own families instead (CASA_SHARED is needed for score.py alone);
`--travel` also builds each case and prints the share of joints that reach their declared range in MuJoCo under 20 N
without a contact of over 1 mm beyond the rest one; and of each case its kind, and whether it holds its contract.
`--predict OUT.json` runs the whole command on any folder of cases, also without ground truth, and writes predictions
in the format of score.py (see benchmarks/articulate/scoring/predict.py).
`--true-frame` gives the tool the up and front that the ground truth has: what the frame guess costs is the difference.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from benchmarks.articulate.scoring.predict import predict
from benchmarks.articulate.scoring.score import looked_at, options, scored


def main() -> None:
    """Run and print."""
    parser = options(__doc__ or "")
    parser.add_argument("--true-frame", action="store_true")
    parser.add_argument("--travel", action="store_true", help="Also build each and print how far its joints go.")
    parser.add_argument("--keep", type=Path, help="Folder for what each case gave, of this version of the tool.")
    parser.add_argument("--out", type=Path, help="Folder for the predictions.")
    parser.add_argument("--predict", type=Path, metavar="OUT.json", help="Run the whole command; write what it finds.")
    parser.add_argument("--jobs", type=int, default=2, help="Processes of --predict.")
    parser.add_argument("--anonymous", action="store_true", help="With --predict: hide the names of files and folders.")
    args = parser.parse_args()
    if args.predict is not None:
        if args.cases is None:
            parser.error("--predict needs --cases")
        for variant in args.variant:
            several = len(args.variant) > 1
            out = args.predict.with_stem(f"{args.predict.stem}_{variant}") if several else args.predict
            predict(args.cases, variant, out, args.jobs, args.anonymous, args.only or "", args.every)
        return
    with scored(args) as score:
        for variant in args.variant:
            run(score, args, variant)


def run(score: ModuleType, args: argparse.Namespace, variant: str) -> None:
    """One variant."""
    names = score.case_names(args.suite, args.only)[:: args.every]
    done = []
    for name in names:
        stored = stored_at(args, variant, name)
        if stored is not None and stored.exists():
            done.append(json.loads(stored.read_text()))
        else:
            done.append(looked_at(score, args, variant, name))
            if stored is not None:
                stored.parent.mkdir(parents=True, exist_ok=True)
                stored.write_text(json.dumps(done[-1], default=float))
        if args.verbose:
            tell(done[-1]["row"], done[-1]["right"], done[-1]["took"])
    seconds = [d["took"] for d in done]
    print(f"\n== {variant}: {len(names)} cases; frame right {sum(d['right'] for d in done)}; seconds", end=" ")
    print(f"median {np.median(seconds):.2f} p95 {np.percentile(seconds, 95):.2f}")
    tables(score, [d["row"] for d in done])
    went: dict[str, list[bool]] = {}
    for kind, whole in (pair for d in done for pair in d["went"]):
        for each in ("ALL", kind):
            went.setdefault(each, []).append(whole)
    for kind, all_ in sorted(went.items()):
        share = sum(all_) / len(all_)
        message = "reach their range under 20 N, touching nothing"
        print(f"travel {kind}: {sum(all_)} of {len(all_)} joints ({share:.1%}) {message}")
    for d in done if args.travel else []:
        print(f"contract {d['row']['name']}: {d['holds']}")
    sys.stdout.flush()


def stored_at(args: argparse.Namespace, variant: str, name: str) -> Path | None:
    """The file that keeps what a case gave, or None where nothing is kept."""
    marks = [variant, *(["true"] if args.true_frame else []), *(["travel"] if args.travel else [])]
    marks += [] if args.perturb is None else [f"perturb{args.perturb}"]
    return None if args.keep is None else Path(args.keep) / "_".join(marks) / f"{name}.json"


def tables(score: ModuleType, rows: list[dict[str, Any]]) -> None:
    """All cases, those of the core suite where they are not all, and each category; then each type."""
    core = set(score.case_names("core"))
    inner = [r for r in rows if r["name"] in core]
    some = 0 < len(inner) < len(rows)
    groups = [score.summarise(rows, "ALL"), *([score.summarise(inner, "core")] if some else [])]
    kinds = sorted({r["category"] for r in rows})
    groups += [score.summarise([r for r in rows if r["category"] == k], k) for k in kinds]
    print(f"{score.table(groups)}\n\n{score.by_type(rows)}")
    if some:
        print(f"\ncore alone\n{score.by_type(inner)}")


def tell(row: dict[str, Any], good: bool, took: float) -> None:
    """What is wrong with one case, on one line each."""
    misses = [f"{p['name']}({p['type']}) {p['iou']:.2f}" for p in row["parts"] if p["iou"] < 0.5]
    wrong = [
        f"{p['name']}({p['type']}->{p.get('ptype')}): "
        + " ".join(k for k in ("type_ok", "joint_ok", "dir_ok") if p.get(k) is False)
        + f" ax {p.get('axis_deg')} o {p.get('origin_part')}"
        for p in row["parts"]
        if p["iou"] >= 0.5
        and (
            not p.get("joint_ok")
            or p.get("dir_ok") is False
            or p.get("axis_deg", 0) > 5
            or p.get("origin_part", 0) > 0.1
        )
    ]
    mark = "" if good else " FRAME"
    counts = f"{took:.1f}s gt {row['n_gt']} pred {row['n_pred']}"
    print(f"{row['name']}{mark} {counts} miss {misses} extra {row['extra']} wrong {wrong}")


if __name__ == "__main__":
    main()
