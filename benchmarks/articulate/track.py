"""The robustness track: cases of the articulation benchmark's form under changes that leave the truth the same.

    ./dev bench articulate_track --cases FOLDER --out OUT [--changes double_faces touching ...] [--seed 0]

FOLDER is as `./dev bench articulate --cases` takes it (with `cases/`), or a folder of cases itself. Writes
OUT/<change>/cases/<case>/ with `input.obj`, `gt.json` and, for changes that apply to it, `fused.obj`, and an index that
keeps what the rows of the first index say, the source of each case among it. What is there is not written again.
"""

from __future__ import annotations

import argparse
import json
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from benchmarks.articulate.cases.changes import CHANGES, FUSED, changed
from benchmarks.articulate.cases.labelled import read_case, write_case


def main() -> None:
    """Write the changed cases."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--changes", nargs="+", default=list(CHANGES), choices=list(CHANGES))
    parser.add_argument("--only", default="", help="Part of the names of the cases.")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1)
    args = parser.parse_args()
    cases = args.cases / "cases" if (args.cases / "cases").exists() else args.cases
    for change in args.changes:
        write_track(cases, args.out / change / "cases", change, args.seed, args.only, args.jobs)


def write_track(cases: Path, out: Path, change: str, seed: int = 0, only: str = "", jobs: int = 1) -> None:
    """Write all cases under one change; those that are there stay."""
    names = [p.parent.name for p in sorted(cases.glob("*/gt.json")) if only in p.parent.name]
    wanted = [n for n in names if not (out / n / "gt.json").exists()]
    if jobs == 1:
        written = [_write(cases / n, out / n, change, seed) for n in wanted]
    else:
        with ProcessPoolExecutor(jobs) as pool:
            many = len(wanted)
            rows = [cases / n for n in wanted], [out / n for n in wanted], [change] * many, [seed] * many
            written = list(pool.map(_write, *rows))
    known = {r["name"]: r for r in json.loads((cases / "index.json").read_text(encoding="utf-8"))["cases"]}
    rows_ = [known.get(p.parent.name, {"name": p.parent.name, "tags": []}) for p in sorted(out.glob("*/gt.json"))]
    (out / "index.json").write_text(json.dumps({"cases": rows_}), encoding="utf-8")
    print(f"{change}: {len(written)} written, {len(rows_)} in all")


def _write(folder: Path, out: Path, change: str, seed: int) -> str:
    """Write one case under one change; the ground truth last, so that what was stopped is written again."""
    mesh = changed(read_case(folder), change, seed)
    with_fused = change in FUSED and (folder / "fused.obj").exists()
    write_case(out, mesh, changed(read_case(folder, "fused"), change, seed) if with_fused else None)
    return out.name


if __name__ == "__main__":
    main()
