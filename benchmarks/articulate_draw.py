"""Labelled cases that nobody else has: members of the own families in others' manners of modelling, and plain drawings.

    python benchmarks/articulate_draw.py --out FOLDER [--manner sketch game solid scan plain] [--each 4] [--seed 1]

Writes FOLDER/<manner>/cases/<case>/ with `input.obj`, `fused.obj` and gt.json, as `benchmarks/articulate.py --cases
FOLDER/<manner>` reads them. `plain` are drawings of solids (articulate_cases/plain), each in a style of its own; the
others are families under combinations of changes (articulate_cases/manners). The `source` of a case is its family or
kind, so that whole kinds can be left out of a fit. What is there is not written again.
"""

from __future__ import annotations

import argparse
import json
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from articulate_cases.fuse import fused
from articulate_cases.labelled import write_case
from articulate_cases.manners import MANNERS, in_manner
from articulate_cases.plain.draw import KINDS, draw
from articulate_families import FAMILIES, MORE, family_case

PLAIN = "plain"


def main() -> None:
    """Write the cases."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--manner", nargs="+", default=[*MANNERS, PLAIN], choices=[*MANNERS, PLAIN])
    parser.add_argument("--each", type=int, default=4, help="Members of each family, or drawings of each kind.")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="Part of the names of the families or kinds.")
    parser.add_argument("--jobs", type=int, default=1)
    args = parser.parse_args()
    for manner in args.manner:
        names = [n for n in (KINDS if manner == PLAIN else (*FAMILIES, *MORE)) if args.only in n]
        cases = args.out / manner / "cases"
        wanted = [(cases, manner, n, args.seed, i) for i in range(args.each) for n in names]
        wanted = [w for w in wanted if not (cases / f"{w[2]}_{w[4]}" / "gt.json").exists()]
        if args.jobs == 1:
            for one in wanted:
                _write(*one)
        else:
            with ProcessPoolExecutor(args.jobs) as pool:
                list(pool.map(_write, *zip(*wanted, strict=True))) if wanted else None
        rows = []
        for path in sorted(cases.glob("*/gt.json")):
            truth = json.loads(path.read_text(encoding="utf-8"))
            rows.append({k: truth[k] for k in ("name", "category", "source")} | {"tags": ["core", "proc"]})
        (cases / "index.json").write_text(json.dumps({"cases": rows}), encoding="utf-8")
        print(f"{manner}: {len(wanted)} written, {len(rows)} in all")


def _write(cases: Path, manner: str, name: str, seed: int, index: int) -> None:
    """Draw and write one case."""
    if manner == PLAIN:
        mesh = draw(name, seed, index)
    else:
        mesh, taken = in_manner(family_case(name, seed, index), manner, seed)
        mesh.truth["changes"] = taken
    mesh.truth["source"] = {"repo": name}
    write_case(cases / f"{name}_{index}", *fused(mesh))


if __name__ == "__main__":
    main()
