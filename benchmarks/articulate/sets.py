"""Score several folders of labelled cases as one table: a row for each change, manner or source.

    CASA_SHARED=... ./dev bench articulate_sets --sets TRACK [OWN ...] --keep KEEP [--variant input fused]
        [--changes touching ...] [--every 3] [--only regex] [--by-source] [--jobs 2]

A set is a folder with `cases/`, or a folder of such folders: what benchmarks/articulate/track.py and
benchmarks/articulate/draw.py write, and the open bench itself. Prints F1 and MAO of score.py, and beside them the share
of right joint types and of right opening directions; then the means over the changes: of input those that leave a clean
surface, of fused shells, and of holes and noise. `--by-source` adds a row for each source of each set, for fits that
leave whole sources out. KEEP holds what each case gave, of one version of the tool: a run that was stopped goes on.
"""

from __future__ import annotations

import argparse
import functools
import json
import re
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from benchmarks.articulate.scoring.score import load_score, looked_at

# Changes after which the surface itself is damaged; their mean stands apart.
DAMAGED = ("holes", "noise")
COLUMNS = ("F1@0.5", "F1c", "MAO", "MAOd", "jnt_acc", "dir_acc", "P", "R", "perfect")
Row = dict[str, Any]


def main() -> None:
    """Score and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sets", type=Path, nargs="+", required=True)
    parser.add_argument("--keep", type=Path, required=True)
    parser.add_argument("--variant", nargs="+", default=["input", "fused"])
    parser.add_argument("--changes", nargs="+", help="Only the sets of these names.")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--only", help="Regular expression of the names of cases.")
    parser.add_argument("--by-source", action="store_true")
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    sets = {s.name: s / "cases" for given in args.sets for s in _sets(given)}
    sets = {n: s for n, s in sets.items() if not args.changes or n in args.changes}
    jobs = []
    for name, cases in sets.items():
        for variant in args.variant:
            found = sorted(p.parent.name for p in cases.glob(f"*/{variant}.obj") if (p.parent / "gt.json").exists())
            found = [n for n in found if not args.only or re.search(args.only, n)][:: args.every]
            jobs += [(name, cases, variant, n, args.keep / name / variant / f"{n}.json") for n in found]
    with ProcessPoolExecutor(args.jobs) as pool:
        rows = list(pool.map(_score_case, *zip(*[j[1:] for j in jobs], strict=True), chunksize=4)) if jobs else []
    groups: dict[tuple[str, str], list[Row]] = {}
    for (name, _, variant, _, _), row in zip(jobs, rows, strict=True):
        groups.setdefault((variant, name), []).append(row)
    score = load_score(next(iter(sets.values())))
    print(f"{'':<34}{'cases':>6}{'parts':>6}" + "".join(f"{c:>9}" for c in COLUMNS) + f"{'frame':>8}{'sec':>7}")
    for (variant, name), of in sorted(groups.items()):
        _print(score, f"{variant} {name}", of)
        if args.by_source:
            sources = _sources(sets[name])
            for source in sorted(set(sources.values())):
                part = [r for r in of if sources.get(r["row"]["name"]) == source]
                if part:
                    _print(score, f"  {source}", part)
    for variant in args.variant:
        clean = [of for (v, name), of in groups.items() if v == variant and name not in DAMAGED]
        _print_mean(score, f"mean of {variant}", clean)
    damaged = [of for (_, name), of in groups.items() if name in DAMAGED]
    _print_mean(score, "mean of holes and noise", damaged)


def _sets(folder: Path) -> list[Path]:
    """The folders with `cases` in a folder, or it alone."""
    if (folder / "cases").is_dir():
        return [folder]
    return sorted(p for p in folder.iterdir() if (p / "cases").is_dir())


@functools.cache
def _score_of(cases: Path) -> ModuleType:
    """score.py reading a folder of cases."""
    return load_score(cases)


def _score_case(cases: Path, variant: str, name: str, kept: Path) -> Row:
    """What a case gave, or gives now."""
    if kept.exists():
        found: Row = json.loads(kept.read_text(encoding="utf-8"))
        return found
    plain = argparse.Namespace(perturb=None, true_frame=False, out=None, travel=False)
    row = looked_at(_score_of(cases), plain, variant, name)
    kept.parent.mkdir(parents=True, exist_ok=True)
    kept.write_text(json.dumps(row, default=float), encoding="utf-8")
    return row


def _sources(cases: Path) -> dict[str, str]:
    """Source of each case of a set."""
    rows = json.loads((cases / "index.json").read_text(encoding="utf-8"))["cases"]
    return {r["name"]: str(r.get("source", {}).get("repo", "unknown")) for r in rows}


def _print(score: ModuleType, title: str, of: list[Row]) -> None:
    """One row of the table."""
    s = score.summarise([r["row"] for r in of], title)
    frame, seconds = float(np.mean([r["right"] for r in of])), float(np.median([r["took"] for r in of]))
    numbers = "".join(f"{s[c]:>9.3f}" for c in COLUMNS)
    print(f"{title[:33]:<34}{len(of):>6}{s['gt']:>6}{numbers}{frame:>8.2f}{seconds:>7.2f}", flush=True)


def _print_mean(score: ModuleType, title: str, groups: list[list[Row]]) -> None:
    """The mean of several rows, none of them heavier than another."""
    if groups:
        all_ = [score.summarise([r["row"] for r in of], title) for of in groups]
        numbers = "".join(f"{np.nanmean([s[c] for s in all_]):>9.3f}" for c in COLUMNS)
        print(f"{title:<34}{sum(len(of) for of in groups):>6}{sum(s['gt'] for s in all_):>6}{numbers}")


if __name__ == "__main__":
    main()
