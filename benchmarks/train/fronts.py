"""Learn which rectangles on the front of a fused shell are doors and drawers; each source is left out in turn.

    CASA_SHARED=/path/to/shared ./dev bench train_fronts --keep FOLDER [--cases FOLDER ...] [--write]

Prints, for each source of the articulation benchmark while it is left out (of each further set of cases, made of our
own drawings, a third of its kinds while they are left out everywhere): how many fronts are found, missed, and found
where there is none; and how many of those told at a confidence are right. `--cases` adds folders that hold `cases/`
with a variant `fused`. `--keep` stores what was measured and takes what is stored there. `--write` writes
registry/learned/fronts.json. Needs scikit-learn (`pip install scikit-learn`), which nothing else here does.
"""

from __future__ import annotations

import argparse
import json
import pickle
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt
from sklearn.ensemble import ExtraTreesClassifier

from benchmarks.articulate.score import load_score, truth, unpacked
from benchmarks.train.controls import write_forest
from casa_assets.articulate.frame import given_frame
from casa_assets.articulate.fronts.front_hypotheses import (
    CONTEXT,
    FEATURES,
    FrontHypotheses,
    choose_fronts,
    context_features,
    log_odds,
    propose_fronts,
)
from casa_assets.articulate.fronts.relief import find_front_rectangles, merge_stairs
from casa_assets.articulate.segment.fragments import weld_triangles
from casa_assets.articulate.segment.orthographic import FRONT, SideRelief, measure_relief

Floats = npt.NDArray[np.float64]

# A rectangle is a front where it agrees so far with a true one, and none below the second; between them it says
# nothing. Where none agrees as far, the best does, down to the third.
SAME, OTHER, LEAST_SAME = 0.8, 0.5, 0.6
# A chosen rectangle is a hit from this agreement on.
HIT = 0.55
# The negatives of a case weigh as much as so many rectangles together, the positives of each true front as these.
NEGATIVES, POSITIVES = 200.0, 6.0
# True fronts are visible over this share of the picture, and fill this share of their rectangle.
MIN_VISIBLE, MIN_FILL = 0.003, 0.5
TREES, LEAVES, FEWEST_AT_LEAF, SHARE_OF_FEATURES, SEED = 48, 160, 10, 0.4, 4
MARGINS = (-1.0, -0.5, 0.0, 0.5)
FOLDS = 3
# What the forests tell apart.
CLASSES = ("other", "front")
CONFIDENCES = (0.0, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.01)


@dataclass
class Sample:
    """The hypotheses of one case, and how far each agrees with each true front: (T, N)."""

    name: str
    source: str
    own: bool
    hypotheses: FrontHypotheses
    agreement: Floats

    @property
    def kind(self) -> str:
        """The kind of thing, by the name of the case."""
        return self.name.split("_")[0]


def measured(score: ModuleType, name: str, source: str, own: bool) -> Sample:
    """Measure one fused case in its true frame."""
    case = score.Case(f"{score.CASES}/{name}", "fused")
    mesh = weld_triangles(case.V, case.F)
    up, front = truth(case)
    mesh = mesh.in_frame(given_frame(mesh, up, front or (0, -1, 0)))
    relief = measure_relief(mesh, FRONT)
    found = propose_fronts(mesh, relief, FRONT, merge_stairs(relief, find_front_rectangles(relief)))
    ends = np.concatenate([found.rows, found.columns], axis=1)
    rows = [_agreement(ends, box) for box in true_fronts(case, relief)]
    return Sample(name, source, own, found, np.array(rows).reshape(len(rows), len(ends)))


def true_fronts(case: Any, relief: SideRelief) -> list[Floats]:
    """The rectangles of pixels (first and last row, first and last column) of the doors and drawers that are seen."""
    face = relief.image.face
    label = np.where(face >= 0, case.lab[np.maximum(face, 0)], 0)
    out = []
    for part in case.parts:
        ground = (label == part["id"]) & (relief.blob < 0)
        if (
            part["type"] not in ("door", "drawer")
            or not part["scored"]
            or ground.sum() < MIN_VISIBLE * (face >= 0).sum()
        ):
            continue
        row, column = np.nonzero(ground)
        (a, b), (c, d) = np.percentile(row, [1, 99]), np.percentile(column, [1, 99])
        box = np.array([a, b + 1, c, d + 1])
        if ground.sum() >= MIN_FILL * (box[1] - box[0]) * (box[3] - box[2]):
            out.append(box)
    return out


def _agreement(ends: npt.NDArray[np.int64], box: Floats) -> Floats:
    high = np.minimum(ends[:, 1], box[1]) - np.maximum(ends[:, 0], box[0])
    wide = np.minimum(ends[:, 3], box[3]) - np.maximum(ends[:, 2], box[2])
    common = np.maximum(high, 0) * np.maximum(wide, 0)
    area = (ends[:, 1] - ends[:, 0]) * (ends[:, 3] - ends[:, 2])
    found: Floats = common / (area + (box[1] - box[0]) * (box[3] - box[2]) - common)
    return found


def targets(sample: Sample) -> tuple[Floats, Floats]:
    """Whether each hypothesis is a front, and its weight; zero for those that say nothing."""
    count = len(sample.hypotheses.rows)
    is_front, weight = np.zeros(count), np.ones(count)
    agreement = sample.agreement
    if len(agreement):
        weight[agreement.max(axis=0) > OTHER] = 0.0
    for row in agreement:
        best = float(row.max(initial=0.0))
        if best >= LEAST_SAME:
            same = row >= (max(SAME, best - 0.04) if best >= SAME else best - 0.02)
            is_front[same], weight[same] = 1.0, min(1.0, POSITIVES / same.sum())
    negative = (is_front == 0) & (weight > 0)
    weight[negative] = min(1.0, NEGATIVES / max(int(negative.sum()), 1))
    return is_front, weight


def learn(samples: Sequence[Sample], rows: Sequence[Floats]) -> ExtraTreesClassifier:
    """Learn a forest from the features of the hypotheses of each sample."""
    pairs = [targets(s) for s in samples]
    is_front, weight = (np.concatenate([p[k] for p in pairs]) for k in (0, 1))
    # Of many alike, a part stands for all.
    kept = (weight > 0) & ((is_front > 0) | (np.random.default_rng(SEED).random(len(weight)) < 2 * weight))
    weight = np.where(is_front > 0, weight, np.maximum(weight, 0.5))
    forest = ExtraTreesClassifier(
        TREES,
        max_leaf_nodes=LEAVES,
        min_samples_leaf=FEWEST_AT_LEAF,
        max_features=SHARE_OF_FEATURES,
        random_state=SEED,
    )
    return forest.fit(np.concatenate(rows)[kept], is_front[kept], weight[kept])


def told(forest: ExtraTreesClassifier, rows: Floats) -> Floats:
    """The log odds that a forest gives."""
    return log_odds(forest.predict_proba(rows)[:, 1]) if len(rows) else np.zeros(0)


def with_context(sample: Sample, forest: ExtraTreesClassifier) -> Floats:
    """The features of the hypotheses of a sample with those of their surroundings."""
    rows = sample.hypotheses.features
    return np.concatenate([rows, context_features(sample.hypotheses, told(forest, rows))], axis=1)


def both(samples: Sequence[Sample]) -> tuple[ExtraTreesClassifier, ExtraTreesClassifier]:
    """The forest that sees each hypothesis alone, and the one that sees its surroundings too."""
    alone = learn(samples, [s.hypotheses.features for s in samples])
    return alone, learn(samples, [with_context(s, alone) for s in samples])


class Tally:
    """Fronts found, found where there is none, and missed, at each margin; confidences, and whether each was right."""

    def __init__(self) -> None:
        self.counts = {m: np.zeros(3, dtype=int) for m in MARGINS}
        self.confidences: list[tuple[float, bool]] = []

    def add(self, sample: Sample, score: Floats) -> None:
        """Count one case."""
        for margin in MARGINS:
            chosen = choose_fronts(sample.hypotheses, score, margin)
            used: set[int] = set()
            for k in chosen:
                good = [t for t in np.flatnonzero(sample.agreement[:, k] >= HIT).tolist() if t not in used]
                used |= set(good[:1])
                if margin == MARGINS[1]:
                    self.confidences.append((float(1 / (1 + np.exp(-score[k]))), bool(good)))
            missed, extra = len(sample.agreement) - len(used), len(chosen) - len(used)
            self.counts[margin] += [len(used), extra, missed]

    def tell(self, name: str) -> None:
        """Print a line."""
        cells = []
        for margin, (hits, extra, missed) in self.counts.items():
            cells.append(
                f"{margin:+.1f}: {hits}/{extra}/{missed} F1 {2 * hits / max(2 * hits + extra + missed, 1):.3f}"
            )
        print(f"{name:34s} {'  '.join(cells)}", flush=True)


def judge(samples: Sequence[Sample]) -> None:
    """Leave out one source after the other, and kinds of our own drawings by thirds."""
    everything = {True: Tally(), False: Tally()}
    for source in sorted({s.source for s in samples}):
        inside = [s for s in samples if s.source == source]
        own = inside[0].own
        kinds = sorted({s.kind for s in inside})
        folds = [set(kinds[f::FOLDS]) for f in range(FOLDS)] if own else [set(kinds)]
        tally = Tally()
        for fold in folds:
            rest = [s for s in samples if not (s.own and s.kind in fold if own else s.source == source)]
            alone, together = both(rest)
            for sample in (s for s in inside if s.kind in fold):
                score = told(together, with_context(sample, alone))
                tally.add(sample, score)
                everything[own].add(sample, score)
        tally.tell(source)
    for own, tally in everything.items():
        tally.tell("ALL OWN" if own else "ALL BENCH")
    pairs = np.array([c for t in everything.values() for c in t.confidences]).reshape(-1, 2)
    for low, high in pairwise(CONFIDENCES):
        in_range = (pairs[:, 0] >= low) & (pairs[:, 0] < high)
        if in_range.any():
            share = pairs[in_range, 1].mean()
            print(f"told {low:.1f} to {min(high, 1.0):.1f}: {in_range.sum()} fronts, {share:.0%} right")


def gathered(folder: Path, keep: Path, own: bool) -> list[Sample]:
    """The samples of a folder of cases."""
    store = keep / f"{'_'.join(folder.resolve().parts[-3:])}.pickle"
    if store.exists():
        return list(pickle.loads(store.read_bytes()))
    score = load_score(folder)
    rows = {p.name: {"name": p.name} for p in sorted(folder.iterdir()) if (p / "fused.obj").exists()}
    if (folder / "index.json").exists():
        rows |= {r["name"]: r for r in json.loads((folder / "index.json").read_text(encoding="utf-8"))["cases"]}
    out = []
    for name, row in rows.items():
        source = folder.parent.name if own else row.get("origin", "")
        if (folder / name / "fused.obj").exists():
            out.append(measured(score, name, source, own))
    store.write_bytes(pickle.dumps(out))
    return out


def main() -> None:
    """Gather, judge, learn, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bench", type=Path, help="Folder in which the benchmark is unpacked, or to unpack it in.")
    parser.add_argument("--cases", type=Path, nargs="*", default=[], help="Folders that hold cases/.")
    parser.add_argument("--keep", type=Path, required=True)
    parser.add_argument("--write", action="store_true")
    args = parser.parse_args()
    args.keep.mkdir(parents=True, exist_ok=True)
    samples = gathered(unpacked(args.bench or args.keep), args.keep, False)
    samples += [s for folder in args.cases for s in gathered(folder / "cases", args.keep, True)]
    samples = [s for s in samples if len(s.hypotheses.rows)]
    judge(samples)
    if args.write:
        alone, together = both(samples)
        write_forest("fronts_alone", alone, FEATURES, CLASSES)
        write_forest("fronts", together, (*FEATURES, *CONTEXT), CLASSES)


if __name__ == "__main__":
    main()
