"""Articulated objects of other people: rebuild them from their public sources, and score predictions on them.

    ./dev bench articulate_outside [--predictions FILE.json | --ours OUT] [--half looking sealed] [--variant input ...]
        [--folder out/articulate_outside] [--mirror FOLDER] [--only REGEX] [--jobs 2]

The first call clones the repositories of sources.yaml and builds a case of each object: `input.obj`, `welded.obj` and
`fused.obj` (triangles alone, at the closed pose), and the truth, gt.json. What is built is kept. Half of the origins
are for looking at, half are sealed: of these only totals are printed, and nobody opens a case. `--predictions` scores
what any program found: {case: {"parts": [{"type", "faces" or "face_runs", "joint": {"type", "axis", "origin",
"range"}}]}}, in the axes and units of the case. `--ours` runs `casa-assets articulate` on nameless copies first.
"""

from __future__ import annotations

import argparse
import json
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.articulate.outside.build import HALVES, build
from benchmarks.articulate.outside.metrics import CaseScore, recall, score_case, totals
from benchmarks.articulate.predict import predict

FIGURES = ("F1", "MAO", "E", "type", "joint", "doors' direction", "perfect", "mostly right")


def main() -> None:
    """Build, predict and score."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=Path("out/articulate_outside"))
    parser.add_argument("--mirror", type=Path, help="Folder of git directories owner+name, in place of cloning.")
    parser.add_argument("--half", nargs="+", choices=HALVES, default=["looking"])
    parser.add_argument("--variant", nargs="+", choices=("input", "welded", "fused"), default=["input"])
    parser.add_argument("--only", default="", help="Regular expression of the names of cases.")
    parser.add_argument("--jobs", type=int, default=2)
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--predictions", type=Path, help="JSON file of what a program found.")
    what.add_argument("--ours", type=Path, metavar="OUT", help="Run casa-assets on the cases; keep what it finds.")
    args = parser.parse_args()
    if args.only and "sealed" in args.half:
        parser.error("--only would tell single cases of the sealed half apart; score it whole")
    build(args.folder, args.mirror, args.jobs)
    for half in args.half:
        for variant in args.variant:
            found = args.predictions
            if args.ours is not None:
                found = args.ours / f"{half}_{variant}.json"
                predict(
                    args.folder / half,
                    variant,
                    found,
                    args.jobs,
                    anonymous=True,
                    only=args.only,
                    shows_each=half != "sealed",
                )
            if found is not None:
                told = json.loads(found.read_text(encoding="utf-8"))
                report(args.folder / half / "cases", half, variant, told, args.only)


def report(cases: Path, half: str, variant: str, told: Mapping[str, Any], only: str = "") -> list[CaseScore]:
    """Print the figures of predictions: of the sealed half only totals."""
    names = [row["name"] for row in json.loads((cases / "index.json").read_text(encoding="utf-8"))["cases"]]
    names = [n for n in names if re.search(only, n)]
    scores = [score_case(cases / name, variant, told.get(name, {})) for name in names]
    print(f"\n{half} half, {variant}: {sum(n in told for n in names)} of {len(names)} cases have a prediction")
    groups: list[tuple[str, Sequence[CaseScore]]] = [("all", scores)]
    if half != "sealed":
        groups += [(kind, [s for s in scores if s.kind == kind]) for kind in sorted({s.kind for s in scores})]
    print(f"{'':22s}{'cases':>6s}{'parts':>6s}{'told':>6s}  " + "  ".join(f"{f:>8.12s}" for f in FIGURES))
    for name, some in groups:
        row = totals(some)
        counts = f"{row['cases']:6.0f}{row['parts']:6.0f}{row['predicted']:6.0f}"
        print(f"{name:22.22s}{counts}  " + "  ".join(f"{row[f]:{max(8, len(f[:12]))}.3f}" for f in FIGURES))
    print("recall: " + ", ".join(f"{kind} {share:.2f} of {count}" for kind, (count, share) in recall(scores).items()))
    outcomes = Counter((told.get(s.name, {}).get("outcome", ""), _grade(s)) for s in scores)
    if any(outcome for outcome, _ in outcomes):
        for outcome in sorted({o for o, _ in outcomes}):
            grades = ", ".join(f"{outcomes[outcome, g]} {g}" for g in GRADES if outcomes[outcome, g])
            print(f"{outcome or 'no prediction'}: {grades}")
    return scores


GRADES = ("right", "mostly right", "wrong")


def _grade(score: CaseScore) -> str:
    return "right" if score.is_perfect else "mostly right" if score.is_mostly_right else "wrong"


if __name__ == "__main__":
    main()
