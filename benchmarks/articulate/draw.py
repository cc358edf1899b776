"""Labelled cases that nobody else has: members of the own families in others' manners of modelling, and plain drawings.

    ./dev bench articulate_draw --out FOLDER [--manner sketch game solid scan plain] [--each 4] [--seed 1]

Writes FOLDER/<manner>/cases/<case>/ with `input.obj`, `fused.obj` and gt.json, as `./dev bench articulate --cases
FOLDER/<manner>` reads them. `plain` are drawings of solids (cases/plain), each in a style of its own; the others are
families under combinations of changes (cases/manners.py). The `source` of a case is its family or kind, so that whole
kinds can be left out of a fit. What is there is not written again.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

from benchmarks.articulate.cases.families import FAMILIES, MORE, family_case
from benchmarks.articulate.cases.fuse import fused
from benchmarks.articulate.cases.labelled import write_case
from benchmarks.articulate.cases.manners import MANNERS, in_manner
from benchmarks.articulate.cases.plain.draw import KINDS, draw

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
    manners = [m for m in args.manner if m != PLAIN]
    jobs = [(args.out, manners, n, args.seed, i) for i, n in _members(args, (*FAMILIES, *MORE)) if manners]
    jobs += [(args.out, [PLAIN], n, args.seed, i) for i, n in _members(args, KINDS) if PLAIN in args.manner]
    written = 0
    with ProcessPoolExecutor(args.jobs) as pool:
        for done, count in enumerate(pool.map(_write, *zip(*jobs, strict=True))):
            written += count
            if done % 10 == 0:  # a run that is stopped leaves folders that can be read
                _write_indices(args.out, args.manner)
    counts = _write_indices(args.out, args.manner)
    print(f"{written} written; {', '.join(f'{m} {n}' for m, n in counts.items())}")


def _write_indices(out: Path, manners: list[str]) -> dict[str, int]:
    """Write the index of each manner; returns how many cases it has."""
    counts = {}
    for manner in manners:
        rows = []
        for path in sorted((out / manner / "cases").glob("*/gt.json")):
            truth = json.loads(path.read_text(encoding="utf-8"))
            rows.append({k: truth[k] for k in ("name", "category", "source")} | {"tags": ["core", "proc"]})
        if rows:
            (out / manner / "cases" / "index.json").write_text(json.dumps({"cases": rows}), encoding="utf-8")
        counts[manner] = len(rows)
    return counts


def _members(args: argparse.Namespace, names: Iterable[str]) -> list[tuple[int, str]]:
    """Number and name of each member that is asked for, the first of every name before the second of any."""
    return [(i, n) for i in range(args.each) for n in names if args.only in n]


def _write(out: Path, manners: list[str], name: str, seed: int, index: int) -> int:
    """Write one member in each manner in which it is not there; returns how many were written."""
    missing = [m for m in manners if not (out / m / "cases" / f"{name}_{index}" / "gt.json").exists()]
    if not missing:
        return 0
    drawn = draw(name, seed, index) if missing == [PLAIN] else family_case(name, seed, index)
    drawn.truth["source"] = {"repo": name}
    for manner in missing:
        mesh = drawn
        if manner != PLAIN:
            mesh, taken = in_manner(drawn, manner, seed)
            mesh = replace(mesh, truth={**mesh.truth, "changes": taken})
        write_case(out / manner / "cases" / f"{name}_{index}", *fused(mesh))
    return len(missing)


if __name__ == "__main__":
    main()
