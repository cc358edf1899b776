"""Labelled cases that nobody else has: drawings of solids, each in a style of its own, and members of the own families.

    ./dev bench articulate_draw --out FOLDER [--set plain families] [--each 4] [--seed 1]

Writes FOLDER/<set>/cases/<case>/ with `input.obj`, `fused.obj` and gt.json, as `./dev bench articulate --cases
FOLDER/<set>` and benchmarks/train read them. The `source` of a case is its family or kind, so that whole kinds can be
left out of a fit. What is there is not written again.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from benchmarks.articulate.families import FAMILIES, MORE, family_case
from benchmarks.articulate.labelled import LabelledMesh, fused, write_case
from benchmarks.articulate.plain import appliances, fittings, furniture
from benchmarks.articulate.plain.drawing import Drawing, drawn_style

# Kinds by name, and the category of each in the benchmark's sense.
KINDS: dict[str, tuple[str, Callable[[Drawing], None]]] = {
    "cabinet": ("cabinet", furniture.cabinet),
    "wardrobe": ("cabinet", furniture.wardrobe),
    "desk": ("desk", furniture.desk),
    "chest": ("box", furniture.chest),
    "bin": ("bin", furniture.bin_),
    "safe": ("safe", furniture.safe),
    "washing_machine": ("washing_machine", appliances.washing_machine),
    "microwave": ("microwave", appliances.microwave),
    "range": ("oven", appliances.range_),
    "oven": ("oven", appliances.oven),
    "dishwasher": ("dishwasher", appliances.dishwasher),
    "fridge": ("fridge", appliances.fridge),
    "toaster": ("toaster", appliances.toaster),
    "coffee_machine": ("coffee_machine", appliances.coffee_machine),
    "laptop": ("laptop", appliances.laptop),
    "faucet": ("faucet", fittings.faucet),
    "switch": ("switch", fittings.switch),
    "remote": ("remote", fittings.remote),
    "button_box": ("button_box", fittings.button_box),
    "stove_top": ("stove", fittings.stove_top),
}


def draw(kind: str, seed: int, index: int) -> LabelledMesh:
    """Draw number `index` of a kind; the same for the same seed."""
    category, how = KINDS[kind]
    rng = np.random.default_rng([seed, index, *kind.encode()])
    drawing = Drawing(category, drawn_style(rng), rng)
    how(drawing)
    return drawing.mesh(f"{kind}_{index}")


SETS: dict[str, tuple[Iterable[str], Callable[[str, int, int], LabelledMesh]]] = {
    "plain": (KINDS, draw),
    "families": ((*FAMILIES, *MORE), family_case),
}


def main() -> None:
    """Write the cases."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--set", nargs="+", default=list(SETS), choices=list(SETS))
    parser.add_argument("--each", type=int, default=4, help="Members of each family, or drawings of each kind.")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="Part of the names of the families or kinds.")
    parser.add_argument("--jobs", type=int, default=1)
    args = parser.parse_args()
    for name in args.set:
        cases = args.out / name / "cases"
        # The first of every kind before the second of any.
        jobs = [
            (name, cases, kind, args.seed, i) for i in range(args.each) for kind in SETS[name][0] if args.only in kind
        ]
        with ProcessPoolExecutor(args.jobs) as pool:
            written = sum(pool.map(_write, *zip(*jobs, strict=True)))
        print(f"{name}: {written} written, {_write_index(cases)} there")


def _write(name: str, cases: Path, kind: str, seed: int, index: int) -> int:
    """Write one case where it is not there; return how many were written."""
    folder = cases / f"{kind}_{index}"
    if (folder / "gt.json").exists():
        return 0
    drawn = SETS[name][1](kind, seed, index)
    drawn.truth["source"] = {"repo": kind}
    write_case(folder, *fused(drawn))
    return 1


def _write_index(cases: Path) -> int:
    """Write the index of a folder of cases; return how many it has."""
    rows = []
    for path in sorted(cases.glob("*/gt.json")):
        truth = json.loads(path.read_text(encoding="utf-8"))
        rows.append({k: truth[k] for k in ("name", "category", "source")} | {"tags": ["core", "proc"]})
    (cases / "index.json").write_text(json.dumps({"cases": rows}), encoding="utf-8")
    return len(rows)


if __name__ == "__main__":
    main()
