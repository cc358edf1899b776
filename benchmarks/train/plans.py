"""Learn which plan of a mesh is right: a forest on each part, and one on the plan; sources are left out in turn.

    ./dev bench train_plans --cases FOLDER ... [--variant input fused] --keep FOLDER [--every 4] [--write]

Each FOLDER holds labelled cases, as `./dev bench articulate --cases` takes them; rows of its index name a source.
All plans of all cases are followed, measured, and scored against the truth; `--keep` stores that and takes what is
stored there. Printed are F1 and MAO of the plan that the rule before chose, of the plan that the forests choose for
sources that they have not seen, and of the best plan of each case, which no choice can beat; then reliability tables.
`--write` writes registry/learned/plan_parts.json and plans.json. Needs scikit-learn, which nothing else here does.
"""

from __future__ import annotations

import argparse
import importlib
import json
import multiprocessing
import os
import pickle
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from sklearn.ensemble import ExtraTreesClassifier

from benchmarks.articulate.confidence import table
from benchmarks.articulate.labelled import AXES, read_obj
from benchmarks.articulate.outside.cases import read_truth
from benchmarks.articulate.outside.metrics import CaseScore, compare, face_labels, totals
from benchmarks.articulate.score import prediction
from benchmarks.train.controls import write_forest
from casa_assets.articulate.frame import likely_frames
from casa_assets.articulate.plan import Frame, PartKind
from casa_assets.articulate.run.build import load_models
from casa_assets.articulate.search.choose import frame_confidences
from casa_assets.articulate.search.plan_features import (
    PART_FEATURES,
    PLAN_FEATURES,
    PlanMeasures,
    measure_plans,
    whole_features,
)
from casa_assets.articulate.search.plans import follow_plans
from casa_assets.articulate.segment.fragments import weld_triangles

Floats = npt.NDArray[np.float64]
PART_TREES = {"n_estimators": 60, "max_leaf_nodes": 220, "min_samples_leaf": 6, "max_features": 0.4, "random_state": 7}
PLAN_TREES = {"n_estimators": 100, "max_leaf_nodes": 40, "min_samples_leaf": 25, "max_features": 0.4, "random_state": 9}
CONTROLS = frozenset({"button", "knob"})
# Sources are left out in so many groups.
FOLDS = 8


@dataclass
class PlanRow:
    """One plan of a case: what was measured, how right each part is, its score, and what the rule before said."""

    measures: PlanMeasures
    right: Floats
    score: CaseScore
    rule: float
    rank: int


@dataclass
class CaseRows:
    """All plans of one variant of a case.

    Attributes:
        frames: of each frame, how sure it is by its looks, and whether it is right, None where that is not known.
    """

    name: str
    source: str
    variant: str
    plans: list[PlanRow]
    frames: list[tuple[float, bool | None]]

    @property
    def is_shell(self) -> bool:
        """True if the mesh is one shell."""
        return any(p.measures.whole["is_shell"] and p.measures.whole.get("by_welded") for p in self.plans)


def quality(score: CaseScore) -> float:
    """Return how good a plan is, 0..1: the mean of F1 by surface and F1 by all that is right; 1 where both are none."""
    total = score.truth + score.predicted
    if not total:
        return 1.0
    found, right = (sum(bool(p[key]) for p in score.parts) for key in ("found", "right"))
    return (2 * found / total + 2 * right / total) / 2


def stored_rows(keep: Path, root: Path, variant: str, name: str) -> Path:
    """Return the file that the plans of a case are stored in."""
    return keep / f"{zlib.crc32(str(root).encode()):08x}" / variant / f"{name}.pickle"


def case_rows(job: tuple[Path, str, str, str, Path]) -> CaseRows:
    """Follow one case to all its plans, or take what is stored."""
    root, name, source, variant, keep = job
    stored = stored_rows(keep, root, variant, name)
    if stored.is_file():
        return pickle.loads(stored.read_bytes())
    truth = read_truth(root / name)
    points, faces = read_obj(root / name / f"{variant}.obj")
    label = face_labels(truth, variant, len(faces))
    mesh = weld_triangles(points, faces)
    frames = likely_frames(mesh)
    plans = follow_plans(mesh, frames, "", load_models())
    rows = []
    for plan, measures in zip(plans, measure_plans(plans), strict=True):
        score = compare(truth, points, faces, label, prediction(plan.articulation))
        by_name = {p["predicted"]: p for p in score.parts if p["found"]}
        right = [float(by_name[p.name]["right"]) if p.name in by_name else 0.0 for p in plan.articulation.parts]
        rule = sum(p.confidence - 0.3 for p in plan.articulation.parts)
        rank = next(k for k, f in enumerate(frames) if f is plan.frame)
        rows.append(PlanRow(measures, np.array(right), score, rule, rank))
    found = CaseRows(name, source, variant, rows, [(f.confidence, frame_is_right(f, truth)) for f in frames])
    stored.parent.mkdir(parents=True, exist_ok=True)
    partial = stored.with_suffix(f".{os.getpid()}")
    partial.write_bytes(pickle.dumps(found))
    partial.replace(stored)
    return found


def frame_is_right(frame: Frame, truth: dict[str, Any]) -> bool | None:
    """Return whether up and front are those of the truth; None where that has no front, and often no certain up."""
    up, front = (AXES.get(v, v) if isinstance(v, str) else v for v in (truth["up"], truth.get("front")))
    if front is None:
        return None
    return bool(np.dot(frame.rotation[2], up) > 0.99 and np.dot(frame.rotation[1], front) < -0.99)


def unsaid(plan: PlanRow) -> npt.NDArray[np.bool_]:
    """Mark the (P,) controls of which the truth says nothing: many sets leave out all keys and knobs."""
    kinds = [PART_FEATURES[int(np.argmax(row[: len(PartKind)]))].removeprefix("is_") for row in plan.measures.parts]
    types = {p["type"] for p in plan.score.parts}
    if not types or types & CONTROLS:
        return np.zeros(len(kinds), dtype=bool)
    names = [f"{kind}_{kinds[:k].count(kind)}" for k, kind in enumerate(kinds)]
    return np.array([k in CONTROLS and n in plan.score.extra for k, n in zip(kinds, names, strict=True)], dtype=bool)


def fit_parts(cases: Sequence[CaseRows]) -> ExtraTreesClassifier:
    """Fit whether a part is right: surface, joint and direction."""
    rows = np.concatenate([p.measures.parts for c in cases for p in c.plans])
    right = np.concatenate([p.right for c in cases for p in c.plans])
    # All plans of a case weigh as much together, however many they are, and each plan's parts no more than their root.
    weight = np.concatenate(
        [np.full(len(p.right), 1.0 / (len(c.plans) * max(len(p.right), 1) ** 0.5)) for c in cases for p in c.plans]
    )
    told = ~np.concatenate([unsaid(p) for c in cases for p in c.plans])
    return ExtraTreesClassifier(**PART_TREES, n_jobs=2).fit(rows[told], right[told] > 0.5, sample_weight=weight[told])


def chances(forest: ExtraTreesClassifier, plans: Sequence[PlanRow]) -> list[Floats]:
    """Return the probability of each part of some plans."""
    counts = np.cumsum([0, *(len(p.right) for p in plans)])
    if not counts[-1]:
        return [np.zeros(0) for _ in plans]
    told = forest.predict_proba(np.concatenate([p.measures.parts for p in plans]))[:, 1]
    return [told[a:b] for a, b in pairwise(counts.tolist())]


def fit_plans(cases: Sequence[CaseRows], told: Sequence[Sequence[Floats]]) -> ExtraTreesClassifier:
    """Fit how good a plan is, from its features and the probabilities of its parts."""
    rows = np.array(
        [
            whole_features(p.measures, t)
            for c, ts in zip(cases, told, strict=True)
            for p, t in zip(c.plans, ts, strict=True)
        ]
    )
    good = np.array([quality(p.score) for c in cases for p in c.plans])
    weight = np.concatenate([np.full(len(c.plans), 1.0 / len(c.plans)) for c in cases])
    both = np.concatenate([weight * good, weight * (1.0 - good)])
    target = np.repeat([True, False], len(rows))
    return ExtraTreesClassifier(**PLAN_TREES, n_jobs=2).fit(np.tile(rows, (2, 1)), target, sample_weight=both)


def folds(cases: Sequence[CaseRows]) -> list[list[str]]:
    """Divide the sources into groups of about as many cases."""
    count: dict[str, int] = {}
    for c in cases:
        count[c.source] = count.get(c.source, 0) + 1
    groups: list[list[str]] = [[] for _ in range(FOLDS)]
    sizes = [0] * FOLDS
    for source in sorted(count, key=lambda s: (-count[s], s)):
        k = int(np.argmin(sizes))
        groups[k].append(source)
        sizes[k] += count[source]
    return [g for g in groups if g]


def fit(cases: Sequence[CaseRows]) -> tuple[ExtraTreesClassifier, ExtraTreesClassifier]:
    """Fit both forests; what the second reads of the first is told by forests without the source."""
    told: dict[int, list[Floats]] = {}
    for group in folds(cases):
        inner = fit_parts([c for c in cases if c.source not in group])
        told |= {id(c): chances(inner, c.plans) for c in cases if c.source in group}
    return fit_parts(cases), fit_plans(cases, [told[id(c)] for c in cases])


def scores_of(case: CaseRows, models: tuple[ExtraTreesClassifier, ExtraTreesClassifier]) -> Floats:
    """Return how good the forests hold each plan to be."""
    told = chances(models[0], case.plans)
    rows = np.array([whole_features(p.measures, t) for p, t in zip(case.plans, told, strict=True)])
    return np.asarray(models[1].predict_proba(rows)[:, 1])


def confidence_row(case: CaseRows, values: Floats, chosen: int, told: Floats) -> dict[str, Any]:
    """Return what benchmarks/articulate/confidence.py fits on: how sure the tool is, and whether it is right."""
    ranks = sorted({p.rank for p in case.plans})
    goods = [max(float(v) for p, v in zip(case.plans, values, strict=True) if p.rank == r) for r in ranks]
    plan = case.plans[chosen]
    sure = frame_confidences([case.frames[r][0] for r in ranks], goods)[ranks.index(plan.rank)]
    right = case.frames[plan.rank][1]
    kinds = [PART_FEATURES[int(np.argmax(row[: len(PartKind)]))].removeprefix("is_") for row in plan.measures.parts]
    hidden = unsaid(plan)
    seen = replace(
        plan.score, extra=tuple(e for e in plan.score.extra if not hidden.any() or not e.startswith(tuple(CONTROLS)))
    )
    return {
        "group": case.source,
        "frame": None if right is None else [float(sure), right],
        "value": float(values[chosen]),
        "parts": [[float(c), bool(r), k] for c, r, k, h in zip(told, plan.right, kinds, hidden, strict=True) if not h],
        "plan_right": bool(seen.predicted) and seen.is_mostly_right,
        "perfect": seen.is_perfect,
    }


def by_rule(case: CaseRows) -> PlanRow:
    """Return the plan of the likeliest frame, no kind assumed, that the rule before takes."""
    first = [p for p in case.plans if p.rank == 0 and not p.measures.whole["assumes_kind"]] or case.plans
    if case.is_shell:
        first = sorted(first, key=lambda p: bool(p.measures.whole.get("by_creases")))
    best = max(first, key=lambda p: round(p.rule, 9))
    return best if best.rule > first[0].rule + (0.5 if len(first[0].right) else 0.25) else first[0]


def main() -> None:
    """Follow, fit, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=Path, nargs="+", required=True)
    parser.add_argument("--variant", nargs="+", default=["input"])
    parser.add_argument("--keep", type=Path, required=True)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--stored-only", action="store_true", help="Take the cases that are stored, and follow none.")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--follow-only", action="store_true", help="Store the plans, and fit nothing.")
    parser.add_argument("--rows", type=Path, help="Write what benchmarks/articulate/confidence.py fits on.")
    parser.add_argument("--write", action="store_true")
    args = parser.parse_args()
    cases, folders = gathered(args)
    if args.follow_only:
        return
    taken: dict[int, tuple[PlanRow, float]] = {}
    rows: dict[str, Any] = {}
    # Forests that also learn from shells choose worse on both; shells are chosen by the sum, as the tool does.
    pieces = [c for c in cases if not c.is_shell]
    for group in folds(cases):
        models = fit([c for c in pieces if c.source not in group])
        for c in cases:
            if c.source in group:
                values = scores_of(c, models)
                first = by_rule(c)
                k = next(k for k, p in enumerate(c.plans) if p is first) if c.is_shell else int(np.argmax(values))
                taken[id(c)] = (c.plans[k], float(values[k]))
                rows[f"{c.source}/{c.variant}/{c.name}"] = confidence_row(
                    c, values, k, chances(models[0], [c.plans[k]])[0]
                )
    if args.rows is not None:
        args.rows.write_text(json.dumps(rows), encoding="utf-8")
    print(compared(cases, folders, taken))
    told = [(value, plan.score) for plan, value in taken.values() if plan.score.predicted]
    print(table("plan is right or has one fault", [(value, score.is_mostly_right) for value, score in told]))
    print(table("plan is right", [(value, score.is_perfect) for value, score in told]))
    if args.write:
        parts, plans = fit(pieces)
        write_forest("plan_parts", parts, PART_FEATURES, ("wrong", "right"))
        write_forest("plans", plans, PLAN_FEATURES, ("bad", "good"))


def compared(cases: Sequence[CaseRows], folders: Sequence[str], taken: Mapping[int, tuple[PlanRow, float]]) -> str:
    """Return F1, MAO and the share that is right of each source, folder and all: by the rule, by forests, at best."""
    groups = {c.source: [d for d in cases if d.source == c.source] for c in cases}
    groups |= {f: [c for c, g in zip(cases, folders, strict=True) if g == f] for f in dict.fromkeys(folders)}
    lines = [f"{'source':40s} {'variant':8s} cases   {'rule before':19s} {'forests':19s} best plan (F1/MAO, right)"]
    for name, mine in (groups | {"all": list(cases)}).items():
        for variant in dict.fromkeys(c.variant for c in mine):
            rows = [c for c in mine if c.variant == variant]
            ways = (
                [by_rule(c).score for c in rows],
                [taken[id(c)][0].score for c in rows],
                [max(c.plans, key=lambda p: quality(p.score)).score for c in rows],
            )
            cells = (f"{t['F1']:.3f}/{t['MAO']:.3f} {t['perfect']:.2f}  " for t in map(totals, ways))
            lines.append(f"{name[-40:]:40s} {variant:8s} {len(rows):5d}   {' '.join(cells)}")
    return "\n".join(lines)


def gathered(args: argparse.Namespace) -> tuple[list[CaseRows], list[str]]:
    """Return the plans of all cases, and the folder of each; those that are not stored are followed."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    jobs = []
    for folder in args.cases:
        root = folder / "cases" if (folder / "cases").is_dir() else folder
        index = json.loads((root / "index.json").read_text(encoding="utf-8"))["cases"]
        for row in index[:: args.every]:
            source = row.get("source")
            told = str(source["repo"] if isinstance(source, dict) else source or root.parent.name)
            jobs += [
                (root, row["name"], told, variant, args.keep)
                for variant in args.variant
                if (root / row["name"] / f"{variant}.obj").exists()
                and (not args.stored_only or stored_rows(args.keep, root, variant, row["name"]).is_file())
            ]
    with multiprocessing.get_context("spawn").Pool(args.jobs, maxtasksperchild=40) as pool:
        found, folders = [], []
        for k, rows in enumerate(pool.imap(follow_safely, jobs, chunksize=2), 1):
            if rows is not None and rows.plans:
                found.append(rows)
                folders.append(str(jobs[k - 1][0].parent))
            if k % 20 == 0:
                print(f"{k} of {len(jobs)} followed", flush=True)
    return found, folders


def follow_safely(job: tuple[Path, str, str, str, Path]) -> CaseRows | None:
    """As `case_rows`; what goes wrong is printed, and the other cases go on."""
    try:
        # By its name: what is stored by a script that runs as __main__ could not be read by others.
        return importlib.import_module("benchmarks.train.plans").case_rows(job)  # type: ignore[no-any-return]
    except Exception as error:  # noqa: BLE001
        print(f"{job[1]} {job[3]}: {type(error).__name__}: {error}", flush=True)
        return None


if __name__ == "__main__":
    main()
