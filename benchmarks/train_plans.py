"""Fit the forest that tells how good a plan of moving parts is, which chooses between ways of splitting a mesh.

    CASA_SHARED=/path/to/shared python benchmarks/train_plans.py --cases FOLDER [FOLDER ...] [--variant input fused]
        [--keep FOLDER] [--jobs 2] [--rows ROWS.json] [--write]

Each FOLDER is as `benchmarks/articulate.py --cases` takes it: labelled cases, with an index whose rows may name a
source. Each way of splitting a case is followed to a plan, which score.py grades: `right` where F1 and MAO of the case
are both at least .85, `wrong` where their mean is below .5, else `partly`. The forest learns these grades from numbers
of the plan (casa_assets/articulate/plan_features.py). Printed are F1 and MAO with the plan that it chooses, fitted and
with the source of each case left out, beside the welded fragments alone, the score of the frame guess, and the best of
each case (no rule can do better); then how often plans are right by its confidence, out of fold. `--write` stores it in
registry/learned/plans.json. Needs scikit-learn.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import zlib
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from articulate import frame_is_right, load_score, prediction
from articulate_confidence import confidence_row

from casa_assets.articulate.choose_plan import GRADES, candidate_plans, plan_value
from casa_assets.articulate.frame.axes import guess_frame
from casa_assets.articulate.plan import Articulation
from casa_assets.articulate.plan_features import PLAN_FEATURES
from casa_assets.articulate.segment.welded_mesh import weld_triangles
from casa_assets.pipeline.articulate.models import load_models

Floats = npt.NDArray[np.float64]
TREES, LEAF, DEPTH = 60, 8, 9
RIGHT, WRONG = 0.85, 0.5
BINS = (0.0, 0.3, 0.5, 0.7, 0.8, 0.9, 1.01)


def case_plans(job: tuple[Path, str, str, Path | None]) -> dict[str, Any]:
    """The plans of one case: features, the score row of each, and the score of the frame guess."""
    root, name, variant, keep = job
    stored = None if keep is None else keep / f"{zlib.crc32(str(root).encode()):08x}" / variant / f"{name}.json"
    if stored is not None and stored.exists():
        return dict(json.loads(stored.read_text()))
    score = load_score(root)
    case = score.Case(f"{root}/{name}", variant)
    mesh = weld_triangles(case.V, case.F)
    frame = guess_frame(mesh)
    plans = candidate_plans(mesh.in_frame(frame), frame, models=load_models())
    rows = [
        {"way": p.way.value, "features": p.features.tolist(), "score": p.guess_score}
        | _graded(score.score_case(case, prediction(p.articulation)), p.articulation)
        for p in plans
    ]
    found = {"name": name, "root": str(root), "variant": variant, "category": case.J["category"], "plans": rows}
    found["frame"] = [frame.confidence, frame_is_right(frame, case)]
    if stored is not None:
        stored.parent.mkdir(parents=True, exist_ok=True)
        stored.write_text(json.dumps(found, default=float))
    return found


def _graded(row: dict[str, Any], articulation: Articulation) -> dict[str, Any]:
    """The row of score.py for a plan, and how sure the tool is of its parts."""
    return {"row": row, "sure": confidence_row(row, articulation)}


def quality(row: dict[str, Any]) -> tuple[float, float]:
    """F1 and MAO of one case."""
    hits = [p for p in row["parts"] if p["iou"] >= 0.5]
    good = [
        p
        for p in hits
        if p.get("joint_ok")
        and p.get("axis_deg", 99) <= 5
        and (p["jtype"] != "revolute" or p.get("origin_part", 9) <= 0.1)
    ]
    total = row["n_gt"] + row["n_pred"]
    return (2 * len(hits) / total, 2 * len(good) / total) if total else (1.0, 1.0)


def grade(row: dict[str, Any]) -> int:
    """Index in GRADES of a plan."""
    f1, mao = quality(row)
    return GRADES.index("right" if min(f1, mao) >= RIGHT else "wrong" if (f1 + mao) / 2 < WRONG else "partly")


def fit(features: Floats, grades: npt.NDArray[np.int64], weights: Floats) -> Any:
    """A forest of scikit-learn."""
    from sklearn.ensemble import RandomForestClassifier

    forest = RandomForestClassifier(
        n_estimators=TREES, min_samples_leaf=LEAF, max_depth=DEPTH, random_state=0, n_jobs=2, class_weight="balanced"
    )
    return forest.fit(features, grades, weights)


def chances_of(forest: Any, features: Floats) -> Floats:
    """(R, C) probabilities in the order of GRADES, 0 for grades that the forest has never seen."""
    out = np.zeros((len(features), len(GRADES)))
    out[:, forest.classes_] = forest.predict_proba(features)
    return out


def as_dict(forest: Any) -> dict[str, Any]:
    """The forest as registry/learned/ stores it."""
    trees = []
    for tree in forest.estimators_:
        t = tree.tree_
        nodes: list[Any] = []
        for i in range(t.node_count):
            if t.children_left[i] < 0:
                nodes.append([[round(100 * float(v)) for v in t.value[i][0] / t.value[i][0].sum()]])
            else:
                left, right = int(t.children_left[i]), int(t.children_right[i])
                nodes.append([int(t.feature[i]), float(f"{t.threshold[i]:.5g}"), left, right])
        trees.append(nodes)
    return {"features": list(PLAN_FEATURES), "classes": list(GRADES), "trees": trees}


def main() -> None:
    """Fit, print, and store."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=Path, nargs="+", required=True)
    parser.add_argument("--variant", nargs="+", default=["input", "fused"])
    parser.add_argument("--keep", type=Path, help="Folder for the plans of each case, of this version of the tool.")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--rows", type=Path, help="Write what benchmarks/articulate_confidence.py fits on.")
    parser.add_argument("--write", action="store_true")
    args = parser.parse_args()
    found, sources = _gathered(args)
    features = np.array([p["features"] for f in found for p in f["plans"]])
    grades = np.array([grade(p["row"]) for f in found for p in f["plans"]])
    owner = np.repeat(np.arange(len(found)), [len(f["plans"]) for f in found])
    group = np.array(sources)[owner]
    # Each case weighs the same, however many ways there are to split it.
    weights = 1.0 / np.bincount(owner)[owner]
    whole = fit(features, grades, weights)
    fitted = chances_of(whole, features)
    held = np.zeros_like(fitted)
    for source in np.unique(group):
        out = group == source
        held[out] = chances_of(fit(features[~out], grades[~out], weights[~out]), features[out])
    start = np.cumsum([0, *(len(f["plans"]) for f in found)])
    score = load_score(Path(found[0]["root"]))
    sets = sorted({(f["root"], f["variant"]) for f in found})
    choices: dict[str, Callable[[int], int]] = {
        "welded": lambda i: 0,
        "frame score": lambda i: int(np.argmax([p["score"] for p in found[i]["plans"]])),
        "held out": lambda i: int(np.argmax([plan_value(c) for c in held[start[i] : start[i + 1]]])),
        "fitted": lambda i: int(np.argmax([plan_value(c) for c in fitted[start[i] : start[i + 1]]])),
        "best": lambda i: int(np.argmax([sum(quality(p["row"])) for p in found[i]["plans"]])),
    }
    print(f"{'set':44s} cases  " + "  ".join(f"{c:>11s}" for c in choices) + "   F1/MAO")
    for root, variant in [*sets, ("", "")]:
        rows = [i for i, f in enumerate(found) if not root or (f["root"], f["variant"]) == (root, variant)]
        cells = [_cell(score, [found[i]["plans"][choose(i)]["row"] for i in rows]) for choose in choices.values()]
        print(f"{(root[-36:] + ' ' + variant) if root else 'all':44s} {len(rows):5d}  " + "  ".join(cells))
    chosen = [int(start[i]) + choices["held out"](i) for i in range(len(found))]
    _reliability(held[chosen], grades[chosen])
    if args.rows is not None:
        rows = {
            f"{f['root']}/{f['variant']}/{f['name']}": {
                "group": sources[i],
                "frame": f["frame"],
                "form": float(held[k, GRADES.index("right")]),
                **f["plans"][k - start[i]]["sure"],
            }
            for i, (f, k) in enumerate(zip(found, chosen, strict=True))
        }
        args.rows.write_text(json.dumps(rows), encoding="utf-8")
    if args.write:
        path = Path(__file__).parents[1] / "registry" / "learned" / "plans.json"
        path.write_text(json.dumps(as_dict(whole), separators=(",", ":")) + "\n", encoding="utf-8")
        print(f"wrote {path}, {path.stat().st_size // 1000} kB")


def _gathered(args: argparse.Namespace) -> tuple[list[dict[str, Any]], list[str]]:
    """The plans of all cases, and the source of each case."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    jobs, sources = [], []
    for folder in args.cases:
        root = folder / "cases" if (folder / "cases").is_dir() else folder
        index = json.loads((root / "index.json").read_text(encoding="utf-8"))["cases"]
        for row in index[:: args.every]:
            for variant in args.variant:
                if (root / row["name"] / f"{variant}.obj").exists():
                    jobs.append((root, row["name"], variant, args.keep))
                    source = row.get("source")
                    sources.append(str(source["repo"] if isinstance(source, dict) else source or root.parent.name))
    with multiprocessing.get_context("spawn").Pool(args.jobs, maxtasksperchild=40) as pool:
        found = list(pool.imap(case_plans, jobs, chunksize=4))
    return found, sources


def _cell(score: Any, rows: Sequence[dict[str, Any]]) -> str:
    summary = score.summarise(list(rows))
    return f"{summary['F1@0.5']:5.3f}/{summary['MAO']:5.3f}"


def _reliability(chances: Floats, grades: npt.NDArray[np.int64]) -> None:
    """How often chosen plans are right, by the confidence that they are, out of fold."""
    sure = chances[:, GRADES.index("right")]
    print("\nconfidence  plans  mean  right  wrong   (out of fold)")
    for low, high in pairwise(BINS):
        rows = (sure >= low) & (sure < high)
        if rows.any():
            right = float((grades[rows] == GRADES.index("right")).mean())
            wrong = float((grades[rows] == GRADES.index("wrong")).mean())
            shares = f"{sure[rows].mean():.2f}  {right:5.2f}  {wrong:5.2f}"
            print(f"{low:.1f} to {min(high, 1):.1f}  {int(rows.sum()):5d}  {shares}")


if __name__ == "__main__":
    main()
