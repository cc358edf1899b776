"""Fit how sure `casa-assets articulate` is of frames, parts and plans, and print how well that holds.

    ./dev bench articulate_confidence ROWS.json... [--out registry/confidence.yaml] [--precision 0.85]

ROWS.json comes from `./dev bench train_plans --rows`: what the tool is sure of on each labelled case, told by forests
that have not seen its source, and whether that is right. Prints reliability tables, each case told by a fit that saw
no case of its source, then fits on all and writes the file. A frame is right where up and front are; a part where its
surface (IoU of 0.5), type and joint are, with its axis within 5 degrees, its hinge within a tenth of the part and its
direction of opening; a plan where all parts are, or all but one, or three of four.
"""

from __future__ import annotations

import argparse
import itertools
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize

from casa_assets import registry
from casa_assets.model.registry.rows import Bars, ConfidenceModel, Curve, Weights

Floats = npt.NDArray[np.float64]
# Features of a plan that its confidence is fitted on; the weights of the first are kept from being negative.
RISING = ("weakest", "mean", "all_right", "frame", "value")
FEATURES = (*RISING, "log_count")
# Fewest examples of a point of a curve, and strength of the prior on the weights. Choices.
MIN_EXAMPLES, RIDGE = 20, 0.02
BINS = (0.0, 0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.001)
IDENTITY = Curve(given=(0.0, 1.0), right=(0.0, 1.0))
HEAD = (
    "# How often `articulate` is right at a confidence. Written by benchmarks/articulate/confidence.py; do not edit.\n"
)


def fit_curve(given: Floats, right: Floats) -> Curve:
    """The share that is right by confidence: means of neighbours, pooled until they rise (isotonic regression)."""
    if not len(given):
        return IDENTITY
    order = np.argsort(given, kind="stable")
    groups = np.array_split(order, max(1, len(order) // MIN_EXAMPLES))
    # One of each kind is added to every group: nothing is certain.
    blocks = [[float(given[g].mean()), float(right[g].sum()) + 1.0, len(g) + 2.0] for g in groups]
    out: list[list[float]] = []
    for block in blocks:
        out.append(block)
        while len(out) > 1 and out[-2][1] / out[-2][2] >= out[-1][1] / out[-1][2]:
            (x, r, n), (y, s, m) = out[-2:]
            out[-2:] = [[(x * n + y * m) / (n + m), r + s, n + m]]
    points: dict[float, float] = {}
    for x, r, n in out:
        points[round(x, 3)] = round(r / n, 3)
    return Curve(given=tuple(points), right=tuple(points.values()))


def fit_weights(features: Floats, right: Floats) -> Weights:
    """Logistic regression with a small ridge."""
    bounds = [(None, None), *((0.0, None) if name in RISING else (None, 0.0) for name in FEATURES)]

    def loss(values: Floats) -> float:
        odds = values[0] + features @ values[1:]
        return float(np.logaddexp(0.0, odds).sum() - right @ odds + RIDGE * len(right) / 2 * (values[1:] ** 2).mean())

    best = minimize(loss, np.zeros(len(FEATURES) + 1), bounds=bounds, method="L-BFGS-B").x
    weights = {name: round(float(v), 3) for name, v in zip(FEATURES, best[1:], strict=True)}
    return Weights(intercept=round(float(best[0]), 3), weights=weights)


def plan_row(row: dict[str, Any], model: ConfidenceModel) -> list[float]:
    """Features of the plan of a row, from its raw confidences."""
    own = [model.part_at(kind, score) for score, _, kind in row["parts"]] or [0.0]
    values = {"weakest": min(own), "mean": float(np.mean(own)), "all_right": float(np.prod(own))}
    frame = model.frame.at(row["frame"][0]) if row["frame"] else 0.5
    values |= {"log_count": float(np.log(len(own))), "frame": frame, "value": row["value"]}
    return [values[name] for name in FEATURES]


def fit(rows: Sequence[dict[str, Any]]) -> ConfidenceModel:
    """All curves and weights; the bars are those of the registry."""
    frames = np.array([r["frame"] for r in rows if r["frame"]], dtype=float).reshape(-1, 2)
    parts = np.array([p[:2] for r in rows for p in r["parts"]], dtype=float).reshape(-1, 2)
    kind = np.array([p[2] for r in rows for p in r["parts"]])
    kinds = {k: fit_curve(*parts[kind == k].T) for k in sorted(set(kind)) if (kind == k).sum() >= MIN_EXAMPLES}
    model = registry.load_confidence().replace(frame=fit_curve(*frames.T), part=fit_curve(*parts.T), kinds=kinds)
    some = [r for r in rows if r["parts"]]
    features = np.array([plan_row(r, model) for r in some])
    return model.replace(plan=fit_weights(features, np.array([r["plan_right"] for r in some], dtype=float)))


def told(rows: Sequence[dict[str, Any]], model: ConfidenceModel) -> dict[str, list[tuple[float, bool]]]:
    """What a model says of rows, and whether it is right, for frames, parts and plans."""
    some = [r for r in rows if r["parts"]]
    return {
        "frame": [(model.frame.at(r["frame"][0]), r["frame"][1]) for r in rows if r["frame"]],
        "part": [(model.part_at(kind, s), ok) for r in rows for s, ok, kind in r["parts"]],
        "plan": [(model.plan.at(dict(zip(FEATURES, plan_row(r, model), strict=True))), r["plan_right"]) for r in some],
    }


def table(name: str, pairs: Sequence[tuple[float, bool]]) -> str:
    """Reliability: what was told against what is right, by bins; last the mean gap, weighted by cases."""
    values = np.array(pairs, dtype=float).reshape(-1, 2)
    lines, gap = [f"{name}: told      cases  mean told  right"], 0.0
    for low, high in itertools.pairwise(BINS):
        rows = values[(values[:, 0] >= low) & (values[:, 0] < high)]
        if len(rows):
            mean, share = rows.mean(axis=0)
            gap += len(rows) * abs(mean - share) / len(values)
            lines.append(f"  {low:.1f} to {min(high, 1.0):.1f}  {len(rows):6d}  {mean:9.2f}  {share:5.2f}")
    return "\n".join([*lines, f"  mean gap {gap:.3f}"])


def bar_for(pairs: Sequence[tuple[float, bool]], precision: float) -> tuple[float, float, float]:
    """The lowest bar above which that share is right; that share, and the share of cases above it."""
    values = np.array(sorted(pairs), dtype=float).reshape(-1, 2)
    above = [(float(v), float(values[values[:, 0] >= v, 1].mean())) for v in np.unique(values[:, 0])]
    good = [(v, share) for v, share in above if share >= precision]
    bar, share = good[0] if good else above[-1]
    return np.floor(bar * 100) / 100, share, float((values[:, 0] >= bar).mean())


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", type=Path, nargs="+")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--precision", type=float, default=0.85, help="Share of accepted plans that has to be right.")
    args = parser.parse_args()
    rows = [row for path in args.rows for row in json.loads(path.read_text(encoding="utf-8")).values()]
    groups = sorted({row["group"] for row in rows})
    unseen: dict[str, list[tuple[float, bool]]] = {"frame": [], "part": [], "plan": []}
    for group in groups:
        model = fit([row for row in rows if row["group"] != group])
        for name, pairs in told([row for row in rows if row["group"] == group], model).items():
            unseen[name] += pairs
    print(f"{len(rows)} cases of {len(groups)} sources; each told by a fit without its source")
    for name, pairs in unseen.items():
        print(table(name, pairs))
    bar, share, kept = bar_for(unseen["plan"], args.precision)
    print(f"plan bar {bar:.2f}: {share:.1%} of the plans above are right, {kept:.1%} of all plans are above")
    model = fit(rows)
    bars = registry.load_confidence().bars
    model = model.replace(bars=Bars(frame=bars.frame, plan=bar, front=bars.front))
    if args.out is not None:
        args.out.write_text(text(model), encoding="utf-8")


def text(model: ConfidenceModel) -> str:
    """The YAML of a model."""
    lines = [HEAD.rstrip("\n")]
    for name in ("frame", "part"):
        curve = getattr(model, name)
        lines.append(f"{name}: {{given: {list(curve.given)}, right: {list(curve.right)}}}")
    lines.append("kinds:")
    lines += [f"  {k}: {{given: {list(c.given)}, right: {list(c.right)}}}" for k, c in model.kinds.items()]
    weights = ", ".join(f"{name}: {value}" for name, value in model.plan.weights.items())
    lines += ["plan:", f"  intercept: {model.plan.intercept}", f"  weights: {{{weights}}}"]
    bars = model.bars
    return "\n".join([*lines, f"bars: {{frame: {bars.frame}, plan: {bars.plan}, front: {bars.front}}}"]) + "\n"


if __name__ == "__main__":
    main()
