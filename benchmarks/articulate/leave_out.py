"""Leave each source of the articulation benchmark out of every fit, and score it by what the others taught.

    CASA_SHARED=/path/to/shared ./dev bench articulate_leave_out --keep FOLDER [--cases FOLDER] [--own FOLDER ...]
        [--variant input fused] [--jobs 2]

Fits the forests of controls and of fronts and the weights of hinges and drawers as the scripts of benchmarks/train do:
once on everything, and once for each source of the benchmark on everything else (drawn scenes, plain drawings and the
folders of `--own`, as `./dev bench articulate_draw` writes them, stay in every fit). Each case is then articulated with
what was fitted on everything, and with what was fitted without its source. Prints F1 and MAO of score.py side by side:
the difference is what the fit knows of these very cases. Rules and their constants are the same on both sides. KEEP
stores what was measured and what each case gave, of one version of the tool. Needs scikit-learn.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.articulate.scoring.score import load_score, looked_at, unpacked
from benchmarks.train import controls, fronts, hinges
from benchmarks.train.control_cases.samples import cached
from benchmarks.train.forest_file import forest_of
from casa_assets.articulate.controls.classify import CONTROL_CLASSES, CONTROL_FEATURES
from casa_assets.articulate.fronts.front_hypotheses import CONTEXT, FEATURES
from casa_assets.articulate.joints import joints as hinge_weights
from casa_assets.articulate.joints.front_features import DRAWER_FEATURES, EDGE_FEATURES
from casa_assets.articulate.plan import Models

NOTHING = "nothing left out"
SCENES, DRAWINGS = 1500, 20
VARIANTS = ("input", "fused")
Row = dict[str, Any]


def main() -> None:
    """Gather, fit, score, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--keep", type=Path, required=True)
    parser.add_argument("--cases", type=Path, help="Folder in which the benchmark is unpacked, or to unpack it in.")
    parser.add_argument("--own", type=Path, nargs="*", default=[], help="Folders of a manner each, with cases/.")
    parser.add_argument("--variant", nargs="+", default=[*VARIANTS])
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    args.keep.mkdir(parents=True, exist_ok=True)
    bench = unpacked(args.cases or args.keep)
    own = [folder / "cases" for folder in args.own]
    sources = {r["name"]: r["origin"] for r in json.loads((bench / "index.json").read_text(encoding="utf-8"))["cases"]}
    gather(args.keep, bench, own, args.jobs)
    outs = [NOTHING, *sorted(set(sources.values()))]
    jobs = [(args.keep, bench, own, out, args.variant) for out in outs]
    with ProcessPoolExecutor(args.jobs) as pool:
        found = dict(zip(outs, pool.map(scored_without, *zip(*jobs, strict=True)), strict=True))
    for variant in args.variant:
        tell(bench, variant, found, sources)


def gather(keep: Path, bench: Path, own: Sequence[Path], jobs: int) -> None:
    """Store all that is learned from, several folders at once."""
    with ProcessPoolExecutor(jobs) as pool:
        waiting: list[Future[Any]] = [pool.submit(hinge_samples, keep, folder) for folder in (bench, *own)]
        waiting += [pool.submit(front_samples, keep, folder, folder != bench) for folder in (bench, *own)]
        waiting.append(pool.submit(controls.gathered, keep, bench, own, SCENES, DRAWINGS))
        for each in waiting:
            each.result()


def hinge_samples(keep: Path, folder: Path) -> list[hinges.Front]:
    """The fronts of a folder of cases that teach hinges and drawers."""
    found: list[hinges.Front] = cached(
        keep / f"hinges_{'_'.join(folder.resolve().parts[-3:])}.pickle", lambda: hinges.gathered([folder], VARIANTS)[0]
    )
    return found


def front_samples(keep: Path, folder: Path, own: bool) -> list[fronts.Sample]:
    """The fused shells of a folder of cases that teach fronts."""
    return [s for s in fronts.gathered(folder, keep, own) if len(s.hypotheses.rows)]


def scored_without(keep: Path, bench: Path, own: Sequence[Path], out: str, variants: Sequence[str]) -> dict[str, Row]:
    """Rows of score.py by variant and name: of the cases of a source that no fit saw, or of all cases."""
    score = load_score(bench)
    plain = argparse.Namespace(perturb=None, true_frame=False, out=None, travel=False)
    fit = cached(keep / "fits" / f"{out}.pickle", lambda: fitted_without(keep, bench, own, out))
    models, *weights = fit
    edges, drawers = (
        np.array([weight.get(name, 0.0) for name in names])
        for weight, names in zip(weights, (EDGE_FEATURES, DRAWER_FEATURES), strict=True)
    )
    found = {}
    with (
        patch.object(hinge_weights, "EDGE_WEIGHTS", edges),
        patch.object(hinge_weights, "DRAWER_WEIGHTS", drawers),
    ):
        for row in json.loads((bench / "index.json").read_text(encoding="utf-8"))["cases"]:
            for variant in variants if out in (NOTHING, row["origin"]) else ():
                stored = keep / "rows" / out / variant / f"{row['name']}.pickle"
                case = (score, plain, variant, row["name"], models)
                found[f"{variant} {row['name']}"] = cached(stored, lambda case=case: looked_at(*case))
    return found


def fitted_without(
    keep: Path, bench: Path, own: Sequence[Path], out: str
) -> tuple[Models, dict[str, float], dict[str, float]]:
    """The forests, and the weights of hinge edges and of drawers, of everything but a source."""
    of_controls = [s for s in controls.gathered(keep, bench, own, SCENES, DRAWINGS) if s.source != out]
    of_fronts = [s for folder in (bench, *own) for s in front_samples(keep, folder, folder != bench)]
    of_hinges = [s for folder in (bench, *own) for s in hinge_samples(keep, folder) if s.source != out]
    alone, together = fronts.both([s for s in of_fronts if s.source != out])
    models = Models(
        controls=forest_of(controls.fitted(of_controls), CONTROL_FEATURES, CONTROL_CLASSES),
        fronts_alone=forest_of(alone, FEATURES, fronts.CLASSES),
        fronts=forest_of(together, (*FEATURES, *CONTEXT), fronts.CLASSES),
    )
    return models, *hinges.weight_tables(of_hinges)


def tell(bench: Path, variant: str, found: dict[str, dict[str, Row]], sources: dict[str, str]) -> None:
    """Print a row for each source, and one for all."""
    score = load_score(bench)
    print(f"\n{variant:<24}{'cases':>6}{'parts':>6}  {'fitted: F1':>11}{'MAO':>7}  {'left out: F1':>13}{'MAO':>7}")
    for source in (*sorted(set(sources.values())), "ALL"):
        names = [n for n, s in sources.items() if source in ("ALL", s)]
        fit = [found[NOTHING][f"{variant} {n}"]["row"] for n in names]
        out = [found[sources[n]][f"{variant} {n}"]["row"] for n in names]
        a, b = score.summarise(fit, source), score.summarise(out, source)
        numbers = f"{a['F1@0.5']:>13.3f}{a['MAO']:>7.3f}  {b['F1@0.5']:>13.3f}{b['MAO']:>7.3f}"
        print(f"{source:<24}{len(names):>6}{a['gt']:>6}{numbers}", flush=True)


if __name__ == "__main__":
    main()
